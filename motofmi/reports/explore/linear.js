/* The linear system of a vehicle and a device at its port, assembled from the Jacobians of the two compiled components:
   x' = A x + B u,  y = C x + D u  for each, and u = y of the other by equal names (torques of the port, motion). */

class Coupled {
  /* parts: {vehicle: {library, values}, device: {library, values}}; the device may be absent. */
  constructor(parts) {
    let first = 0;
    this.parts = Object.entries(parts).map(([name, { library, values }]) => {
      const fmu = new Fmu(library, true), valid = fmu.set(values);
      fmu.initialise();
      const part = { name, library, fmu, valid, first, own: library.states.length, columns: library.columns.length };
      part.jacobian = new Float64Array(library.rows.length * part.columns);
      first += part.own;
      return part;
    });
    this.n = first;
    this.valid = this.parts.every((part) => part.valid);
    this.states = this.parts.flatMap((p) => p.library.states.map((n) => `${p.name}.${n}`));
    this.bind();
    this.connect();
    for (const part of this.parts.slice(1)) part.fmu.jacobian(part.jacobian);
  }

  free() { for (const part of this.parts) part.fmu.free(); }

  /* The inertia that moves with the handlebar is part of the vehicle. */
  bind() {
    const [vehicle, ...devices] = this.parts;
    for (const { library, fmu } of devices)
      if ("port_inertia" in library.references && "added_steer_inertia" in vehicle.library.references)
        vehicle.fmu.set({ added_steer_inertia: fmu.get(["port_inertia"])[0] });
  }

  /* signals: every connected input, with the outputs that it is the sum of, as a row over the states. */
  connect() {
    this.signals = [];
    for (const target of this.parts) {
      target.driven = [];
      target.library.taken.forEach((name, input) => {
        const sources = this.parts.filter((p) => p !== target && p.library.given.includes(name))
          .map((part) => ({ part, output: part.library.given.indexOf(name) }));
        if (!sources.length) return;
        const signal = { input, sources, row: new Float64Array(this.n), next: new Float64Array(this.n) };
        this.signals.push(signal);
        target.driven.push(signal);
      });
    }
  }

  /* A (n, n) in rows at a speed in m/s. */
  matrix(speed) {
    const [vehicle] = this.parts, { n } = this, A = new Float64Array(n * n);
    vehicle.fmu.set({ speed });
    vehicle.fmu.jacobian(vehicle.jacobian);
    this.settle();
    for (const part of this.parts) for (let i = 0; i < part.own; i++) this.addRow(A, (part.first + i) * n, part, i);
    return A;
  }

  /* The rows of the signals. A signal that reaches an input through the direct feed-through of another part follows by
     repetition, as many times as there are parts: ports have no algebraic loops. */
  settle() {
    for (const signal of this.signals) signal.row.fill(0);
    for (let round = 0; round < this.parts.length; round++) {
      for (const { next, sources } of this.signals) {
        next.fill(0);
        for (const { part, output } of sources) this.addRow(next, 0, part, part.own + output);
      }
      for (const signal of this.signals) [signal.row, signal.next] = [signal.next, signal.row];
    }
  }

  /* Row i of a part's Jacobian over the states of the whole, added to `to` from a place on. */
  addRow(to, place, part, i) {
    const { jacobian, columns, own, first } = part, at = i * columns;
    for (let j = 0; j < own; j++) to[place + first + j] += jacobian[at + j];
    for (const { input, row } of part.driven) {
      const slope = jacobian[at + own + input];
      if (slope !== 0) for (let j = 0; j < this.n; j++) to[place + j] += slope * row[j];
    }
  }
}
