/* The linear system of a vehicle and devices at its ports, assembled from the Jacobians of the compiled components:
   x' = A x + B u,  y = C x + D u  for each, and u = sum of y of the others by equal names (forces of the ports, motion). */

/* A compiled component at straight running. */
class CompiledPart {
  constructor(name, { library, values }) {
    Object.assign(this, { name, library, values, fmu: new Fmu(library, true) });
    this.valid = this.fmu.set(values);
    this.fmu.initialise();
  }

  value(name) { return this.fmu.value(name); }

  set(values) { this.fmu.set(values); }

  /* The rates and these outputs are differentiated by the states and these inputs. */
  prepare(outputs, inputs) {
    const { states } = this.library;
    this.derivatives = new Derivatives(this.fmu, [...states.map((n) => `der(${n})`), ...outputs], [...states, ...inputs]);
  }

  evaluate(jacobian) { this.derivatives.evaluate(jacobian); }

  free() {
    this.derivatives.free();
    this.fmu.free();
  }
}

/* A linearised FMU: its Jacobian over all its states and inputs and its calculated values are given, and constant. */
class GivenPart {
  constructor(name, { library, values }) { Object.assign(this, { name, library, values, valid: true }); }

  value(name) { return this.library.references[name]; }

  prepare(outputs, inputs) {
    const { library, library: { states } } = this, places = (all, chosen) => [...states.map((_, i) => i), ...chosen.map((n) => states.length + all.indexOf(n))];
    const rows = places(library.outputs, outputs), columns = places(library.inputs, inputs);
    this.chosen = rows.flatMap((i) => columns.map((j) => library.jacobian[i][j]));
  }

  evaluate(jacobian) { jacobian.set(this.chosen); }

  free() {}
}

class Coupled {
  /* parts: {vehicle: {library, values}, device: {library, values}, device_2: ...}; devices may be absent. */
  constructor(parts) {
    let first = 0;
    this.parts = Object.entries(parts).map(([name, given]) => new (given.library.wasm ? CompiledPart : GivenPart)(name, given));
    for (const part of this.parts) {
      Object.assign(part, { first, own: part.library.states.length });
      first += part.own;
    }
    this.n = first;
    const [vehicle, ...devices] = this.parts, changed = carried(vehicle.values, devices);
    this.valid = changed !== null && this.parts.every((part) => part.valid);
    if (changed) vehicle.set(changed);
    this.states = this.parts.flatMap((p) => p.library.states.map((n) => `${p.name}.${n}`));
    this.connect();
    for (const part of devices) part.evaluate(part.jacobian);
  }

  free() { for (const part of this.parts) part.free(); }

  /* signals: every connected input, with the outputs that it is the sum of, as a row over the states. */
  connect() {
    this.signals = [];
    const others = (part) => this.parts.filter((p) => p !== part);
    for (const part of this.parts) {
      part.given = part.library.outputs.filter((n) => others(part).some((p) => p.library.inputs.includes(n)));
      part.taken = part.library.inputs.filter((n) => others(part).some((p) => p.library.outputs.includes(n)));
      part.columns = part.own + part.taken.length;
      part.jacobian = new Float64Array((part.own + part.given.length) * part.columns);
      part.prepare(part.given, part.taken);
    }
    for (const target of this.parts) {
      target.driven = target.taken.map((name, input) => {
        const sources = others(target).filter((p) => p.given.includes(name)).map((part) => ({ part, output: part.given.indexOf(name) }));
        return { input, sources, row: new Float64Array(this.n), next: new Float64Array(this.n) };
      });
      this.signals.push(...target.driven);
    }
  }

  /* A (n, n) in rows at a speed in m/s. */
  matrix(speed) {
    const [vehicle] = this.parts, { n } = this, A = new Float64Array(n * n);
    vehicle.set({ speed });
    vehicle.evaluate(vehicle.jacobian);
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
