/* What the page shows, and the same as text in the address: #view=locus&speed=30&A=sharp_1971;none;vehicle.trail:0.1
   Several devices that act together are separated by commas. */

const SIDES = ["A", "B"];

class Settings {
  constructor(data) {
    this.data = data;
    this.view = "locus";
    this.speed = 30;
    this.edit = "B";
    this.mode = "weave";
    this.side = "B";
    for (const [k, side] of SIDES.entries()) this[side] = { vehicle: data.vehicle, device: data.devices[k], values: {} };
    this.read(location.hash.slice(1));
  }

  read(text) {
    const given = new URLSearchParams(text), among = (name, valid) => { if (valid.includes(given.get(name))) this[name] = given.get(name); };
    among("view", ["locus", "speed"]);
    among("edit", SIDES);
    among("side", SIDES);
    among("mode", MODES);
    const speed = Number(given.get("speed"));
    if (speed >= 1 && speed <= 60) this.speed = speed;
    for (const side of SIDES) {
      const [vehicle, device, ...values] = (given.get(side) ?? "").split(";");
      if (!(vehicle in this.data.vehicles) || !devicesOf(device).every((d) => d in this.data.choices) || this.refusal(vehicle, device)) continue;
      this[side] = { vehicle, device, values: {} };
      for (const [key, value] of values.map((v) => v.split(":")))
        if (this.row(side, key) && Number.isFinite(Number(value))) this[side].values[key] = Number(value);
    }
  }

  /* A frame in a notebook has no address. */
  write() {
    if (location.protocol === "about:") return;
    const text = new URLSearchParams({ view: this.view, speed: this.speed, edit: this.edit, side: this.side, mode: this.mode });
    for (const side of SIDES) {
      const { vehicle, device, values } = this[side];
      text.set(side, [vehicle, device, ...Object.entries(values).map(([key, value]) => `${key}:${value}`)].join(";"));
    }
    history.replaceState(null, "", `#${text.toString().replaceAll("%3B", ";").replaceAll("%3A", ":").replaceAll("%2C", ",")}`);
  }

  /* The components of a side by part: {vehicle, device, device_2}. */
  components(side) {
    const { vehicle, device } = this[side], parts = { vehicle: this.data.vehicles[vehicle] };
    devicesOf(device).forEach((name, k) => { parts[k ? `device_${k + 1}` : "device"] = this.data.choices[name]; });
    return parts;
  }

  /* Why a vehicle and devices cannot be coupled; empty where they can. */
  refusal(vehicle, device) {
    const { modules, vehicles, choices } = this.data;
    return refusal(modules[vehicles[vehicle].module], devicesOf(device).map((name) => modules[choices[name].module]));
  }

  /* The declaration of a parameter `part.name`; undefined where the side has no such parameter. */
  row(side, key) {
    const at = key.indexOf("."), component = this.components(side)[key.slice(0, at)];
    return component && this.data.modules[component.module].parameters[key.slice(at + 1)];
  }

  value(side, key) {
    const at = key.indexOf(".");
    return this[side].values[key] ?? this.components(side)[key.slice(0, at)].values[key.slice(at + 1)];
  }

  /* All values of the parts of a side, by part and name. */
  parts(side, libraries) {
    const parts = {};
    for (const [part, component] of Object.entries(this.components(side))) {
      const values = { ...component.values };
      for (const name of Object.keys(values)) values[name] = this.value(side, `${part}.${name}`);
      parts[part] = { library: libraries[component.module], values };
    }
    return parts;
  }

  /* Values that the new components of a side lack are left out. */
  choose(side, change) {
    Object.assign(this[side], change);
    for (const key of Object.keys(this[side].values)) if (!this.row(side, key)) delete this[side].values[key];
    if ("device" in change) for (const key of Object.keys(this[side].values)) if (key.startsWith("device")) delete this[side].values[key];
    if ("vehicle" in change) for (const key of Object.keys(this[side].values)) if (key.startsWith("vehicle.")) delete this[side].values[key];
  }

  title(side) {
    const { vehicle, device, values } = this[side], changed = Object.keys(values).length;
    return `${vehicle} ${device === "none" ? "without a device" : `with ${devicesOf(device).join(" and ")}`}${changed ? `, ${changed} changed` : ""}`;
  }
}

/* The names of the devices that act together. */
function devicesOf(device) { return device === "none" ? [] : device.split(","); }
