/* The co-simulation of a vehicle and the devices at its ports, in one pass and without rollback.

   Each step: the vehicle steps with the forces continued as a parabola through their last three values; then every angle
   is known at both ends with its rate, and the devices step with the Hermite cubic through them, and with a parabola for
   other motion. The method is fmus/cosimulation/coupling/hermite.py; its error in the modes is of order 3 in the step. */

/* Communication steps [s] with which the error of the coupling in every mode is below 0.01 %: the arms of a rider whose
   inertia changes with the posture are stiffer. */
const STEP = 1e-3, STEP_WITH_POSTURE = 8e-4;
/* Relative error of an internal step of an FMU without an exact step; between 1e-10 and this, the modes do not change. */
const TOLERANCE = 1e-6;

const changesInertia = ({ library }) => library.outputs.includes("inertia_torque");

class Stepped {
  /* An instance that steps: values of connected inputs at the start of a step, and their derivatives in it. */
  constructor({ library, values }, inputs, initial, start) {
    Object.assign(this, { fmu: new Fmu(library, false), inputs, count: inputs.length });
    const inner = "relative_tolerance" in library.references ? { relative_tolerance: TOLERANCE } : {};
    this.valid = this.fmu.set({ ...values, ...inner }) && this.fmu.set(initial);
    this.fmu.initialise(start);
    this.fmu.start();
    const { fmi } = this.fmu, orders = inputs.flatMap((n) => [1, 2, 3].map((order) => [library.references[n], order])).flat();
    this.requests = fmi.malloc(4 * orders.length + 8);
    new Uint32Array(fmi.memory.buffer, this.requests, orders.length).set(orders);
    this.slopes = fmi.malloc(24 * this.count + 8);
    this.inputReferences = library.references_of(inputs);
    this.inputValues = fmi.malloc(8 * this.count + 8);
  }

  /* values (inputs), slopes (inputs x 3): the polynomial of every connected input over the step. */
  step(time, size, values, slopes) {
    const { fmu, fmu: { fmi, instance, flags }, count } = this;
    this.give(values);
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
  /* parts as in Coupled; initial: states of the parts by part and name; start: the time [s]. */
  constructor(parts, speed, initial = {}, start = 0) {
    const step = Object.values(parts).some(changesInertia) ? STEP_WITH_POSTURE : STEP;
    Object.assign(this, { step, time: start, ok: true, pushed: {} });
    const { vehicle, ...devices } = parts, all = Object.entries(devices), known = (name) => vehicle.library.outputs.includes(name);
    this.forces = FORCES.filter((n) => vehicle.library.inputs.includes(n) && all.some(([, d]) => d.library.outputs.includes(n)));
    this.motions = MOTION.filter((n) => known(n) && all.some(([, d]) => d.library.inputs.includes(n) || d.library.inputs.some((angle) => RATES[angle] === n)));
    this.devices = all.map(([name, given]) => this.device(name, given, initial[name] ?? {}, start));
    const changed = carried(vehicle.values, this.devices.map(({ stepped }) => stepped.fmu));
    this.vehicle = new Stepped({ library: vehicle.library, values: { ...vehicle.values, ...changed } }, this.forces, { ...initial.vehicle, speed }, start);
    this.ok = changed !== null;
    this.readMotion = reader(this.vehicle.fmu, this.motions);
    this.motion = this.readMotion();
    for (const each of this.devices) each.stepped.give(each.of(this.motion));
    this.torques = [this.force()];
    this.slopes = new Float64Array(3 * this.forces.length);
    this.rates = this.motions.map((n) => this.motions.indexOf(RATES[n]));
    this.angles = this.motions.map((n) => this.motions.findIndex((angle) => RATES[angle] === n));
    this.motionSlopes = new Float64Array(3 * this.motions.length);
  }

  /* A device with the places of its inputs among the motions, and of its outputs among the forces; `of` and `slopesOf`
     give arrays that the next call overwrites. */
  device(name, given, initial, start) {
    const inputs = this.motions.filter((n) => given.library.inputs.includes(n)), outputs = this.forces.filter((n) => given.library.outputs.includes(n));
    const stepped = new Stepped(given, inputs, initial, start), places = inputs.map((n) => this.motions.indexOf(n)), slopes = new Float64Array(3 * inputs.length), values = new Float64Array(inputs.length);
    return {
      name, stepped, slopes, read: reader(stepped.fmu, outputs), targets: outputs.map((n) => this.forces.indexOf(n)),
      of: (motion) => {
        for (let i = 0; i < places.length; i++) values[i] = motion[places[i]];
        return values;
      },
      slopesOf: (all) => {
        for (let i = 0; i < places.length; i++) for (let k = 0; k < 3; k++) slopes[3 * i + k] = all[3 * places[i] + k];
        return slopes;
      },
    };
  }

  free() {
    this.vehicle.free();
    for (const { stepped } of this.devices) stepped.free();
  }

  /* Inputs of the vehicle besides those of the devices: speed, disturbances. A disturbance on an input that a device
     drives adds to it. */
  disturb(values) {
    const own = Object.entries(values).filter(([name]) => !this.forces.includes(name));
    for (const [name, value] of Object.entries(values)) if (this.forces.includes(name)) this.pushed[name] = value;
    this.pushing = Object.values(this.pushed).some((value) => value !== 0);
    if (own.length) this.vehicle.fmu.set(Object.fromEntries(own));
  }

  states() {
    const of = ({ fmu }) => Object.fromEntries(fmu.library.states.map((n, i) => [n, fmu.get(fmu.library.states)[i]]));
    return Object.fromEntries([["vehicle", of(this.vehicle)], ...this.devices.map(({ name, stepped }) => [name, of(stepped)])]);
  }

  /* The sum of the devices' forces. */
  force() {
    const sum = new Float64Array(this.forces.length);
    for (const { read, targets } of this.devices) {
      const own = read();
      for (let i = 0; i < own.length; i++) sum[targets[i]] += own[i];
    }
    return sum;
  }

  advance() {
    const { step: h, time, torques, motion, slopes } = this, [t0, t1 = t0, t2] = torques;
    for (let i = 0; i < t0.length; i++) {
      slopes[3 * i] = t2 ? (3 * t0[i] - 4 * t1[i] + t2[i]) / (2 * h) : (t0[i] - t1[i]) / h;
      slopes[3 * i + 1] = t2 ? (t0[i] - 2 * t1[i] + t2[i]) / (h * h) : 0;
    }
    this.ok &&= this.vehicle.step(time, h, this.pushing ? t0.map((t, i) => t + (this.pushed[this.forces[i]] ?? 0)) : t0, slopes);
    this.motion = this.readMotion();
    this.continueMotion(motion, this.motion, this.before ?? motion.map((m, i) => 2 * m - this.motion[i]));
    for (const { stepped, of, slopesOf } of this.devices) {
      this.ok &&= stepped.step(time, h, of(motion), slopesOf(this.motionSlopes));
      stepped.give(of(this.motion));
    }
    this.before = motion;
    this.torques = [this.force(), t0, torques.length === 1 ? undefined : t1];
    this.time += h;
    return this.ok;
  }

  /* The derivatives of the motion between two values m0 and m1, the one before m0 being known. */
  continueMotion(m0, m1, before) {
    const { step: h, rates, angles, motionSlopes: to } = this;
    for (let i = 0; i < m0.length; i++) {
      const rate = rates[i], mean = (m1[i] - m0[i]) / h;
      if (rate >= 0) {
        const second = (2 * (3 * mean - 2 * m0[rate] - m1[rate])) / h, third = (6 * (m0[rate] + m1[rate] - 2 * mean)) / (h * h);
        to[3 * i] = m0[rate];
        to[3 * i + 1] = to[3 * rate] = second;
        to[3 * i + 2] = to[3 * rate + 1] = third;
        to[3 * rate + 2] = 0;
      } else if (angles[i] < 0) {
        to[3 * i] = (m1[i] - before[i]) / (2 * h);
        to[3 * i + 1] = (m1[i] - 2 * m0[i] + before[i]) / (h * h);
      }
    }
  }
}

/* A function that reads variables of an instance. */
function reader(fmu, names) {
  const references = fmu.library.references_of(names), place = fmu.fmi.malloc(8 * names.length + 8);
  return () => {
    fmu.fmi.fmi3GetFloat64(fmu.instance, references, names.length, place, names.length);
    return Float64Array.from(fmu.numbers(place, names.length));
  };
}
