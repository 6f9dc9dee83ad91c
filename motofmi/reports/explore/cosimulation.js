/* The co-simulation of two FMUs at the handlebar port, in one pass and without rollback.

   Each step: the vehicle steps with the torques continued as a parabola through their last three values; then the angle
   is known at both ends with its rate, and the device steps with the Hermite cubic through them. The method is
   fmus/cosimulation/coupling/hermite.py; its error in the modes is of order 3 in the step. */

const TORQUE = ["handlebar_torque", "frame_torque"], TURN = ["steer_angle", "steer_rate", "frame_rate"];

class Stepped {
  /* An instance that steps: values at the start of a step, and derivatives of the inputs in it. */
  constructor({ library, values }, initial, start) {
    this.fmu = new Fmu(library, false);
    this.valid = this.fmu.set(values) && this.fmu.set(initial);
    this.fmu.initialise(start);
    this.fmu.start();
    this.inputs = library.inputs.filter((n) => TORQUE.includes(n) || TURN.includes(n));
    const { fmi } = this.fmu, orders = this.inputs.flatMap((n) => [1, 2, 3].map((order) => [library.references[n], order])).flat();
    this.count = this.inputs.length;
    this.requests = fmi.malloc(4 * orders.length + 8);
    new Uint32Array(fmi.memory.buffer, this.requests, orders.length).set(orders);
    this.slopes = fmi.malloc(24 * this.count + 8);
    this.inputReferences = this.fmu.library.references_of(this.inputs);
    this.inputValues = fmi.malloc(8 * this.count + 8);
  }

  /* values (inputs), slopes (inputs x 3): the polynomial of every connected input over the step. */
  step(time, size, values, slopes) {
    const { fmu, fmu: { fmi, instance, flags }, count } = this;
    fmu.numbers(this.inputValues, count).set(values);
    fmi.fmi3SetFloat64(instance, this.inputReferences, count, this.inputValues, count);
    fmu.numbers(this.slopes, 3 * count).set(slopes);
    fmi.component_set_input_derivatives(instance, this.requests, 3 * count, this.slopes, 3 * count);
    fmi.component_after(0);
    return fmi.fmi3DoStep(instance, time, size, 1, flags, flags + 8, flags + 16, flags + 24) <= 1;
  }

  give(values) {
    const { fmu, count } = this;
    fmu.numbers(this.inputValues, count).set(values);
    fmu.fmi.fmi3SetFloat64(fmu.instance, this.inputReferences, count, this.inputValues, count);
  }

  free() {
    const { fmi } = this.fmu;
    for (const place of [this.requests, this.slopes, this.inputReferences, this.inputValues]) fmi.free(place);
    this.fmu.free();
  }
}

class CoSimulation {
  /* parts as in Coupled; initial: states of the vehicle and the device by part and name; start: the time [s]. */
  constructor(parts, speed, step = 1e-3, initial = {}, start = 0) {
    Object.assign(this, { step, time: start, ok: true });
    const carried = { ...parts.vehicle.values };
    if (parts.device) {
      this.device = new Stepped(parts.device, initial.device ?? {}, start);
      if ("port_inertia" in parts.device.library.references) [carried.added_steer_inertia] = this.device.fmu.get(["port_inertia"]);
    }
    this.vehicle = new Stepped({ library: parts.vehicle.library, values: carried }, { ...initial.vehicle, speed }, start);
    this.readMotion = reader(this.vehicle.fmu, TURN);
    this.readTorque = this.device ? reader(this.device.fmu, TORQUE) : () => [0, 0];
    this.motion = [...this.readMotion()];
    this.device?.give(this.motion);
    this.torques = [[...this.readTorque()]];
    this.slopes = { vehicle: new Float64Array(6), device: new Float64Array(9) };
  }

  free() {
    this.vehicle.free();
    this.device?.free();
  }

  /* Inputs of the vehicle that no device drives: speed, disturbances. */
  disturb(values) { this.vehicle.fmu.set(values); }

  states() {
    const of = ({ fmu }) => Object.fromEntries(fmu.library.states.map((n, i) => [n, fmu.get(fmu.library.states)[i]]));
    return { vehicle: of(this.vehicle), ...(this.device ? { device: of(this.device) } : {}) };
  }

  advance() {
    const { step: h, time, torques, motion: [a0, s0, w0], slopes } = this, [t0, t1 = t0, t2] = torques;
    for (let i = 0; i < 2; i++) {
      slopes.vehicle[3 * i] = t2 ? (3 * t0[i] - 4 * t1[i] + t2[i]) / (2 * h) : (t0[i] - t1[i]) / h;
      slopes.vehicle[3 * i + 1] = t2 ? (t0[i] - 2 * t1[i] + t2[i]) / (h * h) : 0;
    }
    this.ok &&= this.vehicle.step(time, h, t0, slopes.vehicle);
    const [a1, s1, w1] = this.motion = this.readMotion();
    if (this.device) {
      const mean = (a1 - a0) / h, second = (2 * (3 * mean - 2 * s0 - s1)) / h, third = (6 * (s0 + s1 - 2 * mean)) / (h * h);
      const before = this.before ?? 2 * w0 - w1;
      slopes.device.set([s0, second, third, second, third, 0, (w1 - before) / (2 * h), (w1 - 2 * w0 + before) / (h * h), 0]);
      this.ok &&= this.device.step(time, h, [a0, s0, w0], slopes.device);
      this.device.give(this.motion);
    }
    this.before = w0;
    this.torques = [this.readTorque(), t0, t1 === t0 ? undefined : t1];
    if (torques.length === 1) this.torques = [this.torques[0], t0];
    this.time += h;
    return this.ok;
  }
}

/* A function that reads variables of an instance. */
function reader(fmu, names) {
  const references = fmu.library.references_of(names), place = fmu.fmi.malloc(8 * names.length);
  return () => {
    fmu.fmi.fmi3GetFloat64(fmu.instance, references, names.length, place, names.length);
    return Float64Array.from(fmu.numbers(place, names.length));
  };
}
