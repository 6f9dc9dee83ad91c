/* What devices at the ports change in a vehicle, and which of them go together: the rules of vehicle_fmu/ridden.py and
   vehicle_fmu/rider_mass_removed.py, where they are explained. */

const RIDER_BODY = ["rider_mass", "rider_height", "rider_roll_inertia"], REAR_FRAME = ["rear_mass", "rear_mass_height", "rear_roll_inertia"];
const FORCES = ["handlebar_torque", "frame_torque", "roll_torque", "lateral_force"]; // of devices on the vehicle
const MOTION = ["steer_angle", "steer_rate", "frame_rate", "roll_angle", "roll_rate", "lateral_velocity", "turning_acceleration"];
const RATES = { steer_angle: "steer_rate", roll_angle: "roll_rate" };

/* The parameters of a vehicle that its devices change, from all its values; null where the rear frame does not contain
   the rider. A device gives a calculated value by name, undefined where it has none. */
function carried(values, devices) {
  const changed = {};
  for (const device of devices) {
    const inertia = device.value("port_inertia"), [mass, height, roll] = RIDER_BODY.map((name) => device.value(name));
    if (inertia !== undefined && "added_steer_inertia" in values) changed.added_steer_inertia = inertia;
    if (mass === undefined) continue;
    const [whole, centre, own] = REAR_FRAME.map((name) => changed[name] ?? values[name]), rest = whole - mass, moment = whole * centre - mass * height;
    const left = own + whole * centre ** 2 - moment ** 2 / rest - roll - mass * height ** 2;
    if (!(rest > 0 && moment >= 0 && left > 0)) return null;
    REAR_FRAME.forEach((name, i) => { changed[name] = [rest, moment / rest, left][i]; });
  }
  return changed;
}

/* Why a vehicle and devices (descriptions of modules) cannot be coupled; empty where they can. */
function refusal(vehicle, devices) {
  const lacking = devices.flatMap((d) => d.inputs).filter((name) => MOTION.includes(name) && !vehicle.outputs.includes(name));
  if (lacking.length) return `the vehicle has no output ${lacking[0]}`;
  if (devices.filter((d) => "port_inertia" in d.references).length > 1) return "two riders cannot both hold the handlebar";
  const leaning = devices.filter((d) => d.outputs.includes("roll_torque"));
  if (leaning.length > 1) return "two riders cannot both lean";
  if (leaning.length && !REAR_FRAME.every((name) => name in vehicle.references)) return "the vehicle has no rear frame from which the mass of a leaning rider is removed";
  return "";
}
