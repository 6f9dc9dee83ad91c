/* The controls of the configuration that is edited: vehicle, device, and a slider with a number for every parameter. */

const PROMINENT = ["trail", "ground_trail", "caster_angle", "front_cornering_stiffness", "rear_cornering_stiffness", "front_cornering_stiffness_0", "rear_cornering_stiffness_0", "front_pKy1", "rear_pKy1", "gravity", "steering_damping"];

function unitShown(unit) { return unit === "rad" ? { unit: "deg", factor: DEGREES } : { unit, factor: 1 }; }

/* A range for a slider: a fifth to the triple of the value, or 0.1 to both sides of zero, within the bounds. */
function range({ min, max, unit }, value) {
  const reach = unit === "rad" && value ? [value - 0.25, value + 0.25] : value ? [0.2 * value, 3 * value].sort((a, b) => a - b) : [-0.1, 0.1];
  return [Math.max(reach[0], min ?? -Infinity), Math.min(reach[1], max ?? Infinity)];
}

function element(tag, attributes = {}, ...children) {
  const made = document.createElement(tag);
  for (const [name, value] of Object.entries(attributes))
    if (name.startsWith("on")) made.addEventListener(name.slice(2), value);
    else if (value !== false) made.setAttribute(name, value === true ? "" : value);
  made.append(...children);
  return made;
}

function pressed(parent, options, chosen, choose) {
  parent.querySelectorAll("button").forEach((b) => b.remove());
  for (const [value, label] of options)
    parent.append(element("button", { type: "button", "aria-pressed": String(value === chosen), "data-value": value, onclick: () => choose(value) }, label));
}

class Controls {
  constructor(settings, changed) {
    Object.assign(this, { settings, changed, place: document.getElementById("parameters") });
    this.build();
  }

  build() {
    const { settings } = this, side = settings.edit, open = [...this.place.querySelectorAll("details[open]")].map((d) => d.id);
    pressed(document.getElementById("edit"), SIDES.map((s) => [s, s]), side, (s) => { settings.edit = s; this.build(); this.changed([]); });
    this.place.replaceChildren(
      this.select("vehicle", "Motorcycle", Object.keys(settings.data.vehicles)),
      this.select("device", "Device at the handlebar", ["none", ...Object.keys(settings.data.choices)]),
      ...Object.entries(settings.components(side)).reverse().flatMap(([part, component]) => this.group(side, part, component)));
    for (const id of open) document.getElementById(id)?.setAttribute("open", "");
  }

  select(part, label, names) {
    const { settings } = this, chosen = settings[settings.edit][part], id = `choose-${part}`;
    const options = names.map((n) => element("option", { value: n, selected: n === chosen }, n));
    const list = element("select", { id, onchange: () => { settings.choose(settings.edit, { [part]: list.value }); this.build(); this.changed([settings.edit]); } }, ...options);
    return element("p", {}, element("label", { for: id }, label), list);
  }

  group(side, part, component) {
    const names = Object.keys(component.values), first = part === "device" ? names : names.filter((n) => PROMINENT.includes(n)), more = names.filter((n) => !first.includes(n));
    const made = [...first.map((n) => this.slider(side, `${part}.${n}`))];
    if (more.length) made.push(element("details", { id: `more-${part}` }, element("summary", {}, `${more.length} more parameters of the ${part}`), ...more.map((n) => this.slider(side, `${part}.${n}`))));
    return made;
  }

  slider(side, key) {
    const { settings } = this, row = settings.row(side, key), { unit, factor } = unitShown(row.unit), at = key.indexOf(".");
    const own = settings.components(side)[key.slice(0, at)].values[key.slice(at + 1)], now = settings.value(side, key);
    const [low, high] = range(row, own).map((v) => v * factor), id = `p-${key.replace(".", "-")}`;
    const line = element("div", { class: "row" }), text = (v) => Number((v * factor).toPrecision(5));
    const write = (typed, from) => {
      if (typed === "" || !Number.isFinite(Number(typed))) return;
      const value = Math.min(Math.max(Number(typed) / factor, row.min ?? -Infinity), row.max ?? Infinity);
      if (Math.abs(value - own) <= 1e-12 * Math.abs(own)) delete settings[side].values[key];
      else settings[side].values[key] = Number(value.toPrecision(8));
      line.classList.toggle("changed", key in settings[side].values);
      if (from !== slider) slider.value = value * factor;
      if (from !== number) number.value = text(value);
      this.changed([side]);
    };
    const slider = element("input", { type: "range", id, min: low, max: high, step: "any", value: now * factor, oninput: () => write(slider.value, slider), onkeydown: (event) => this.step(event, slider, low, high, write) });
    const number = element("input", { type: "number", step: "any", value: text(now), "aria-label": `${row.description}, value`, onchange: () => write(number.value, number) });
    line.classList.toggle("changed", key in settings[side].values);
    line.append(element("label", { for: id, title: key }, row.description), slider, number, element("span", { class: "unit" }, unit));
    return line;
  }

  /* Arrow keys move a slider by a hundredth of its range. */
  step(event, slider, low, high, write) {
    const sign = { ArrowLeft: -1, ArrowDown: -1, ArrowRight: 1, ArrowUp: 1 }[event.key];
    if (!sign) return;
    event.preventDefault();
    slider.value = Number(slider.value) + (sign * (high - low)) / 100;
    write(slider.value, slider);
  }
}
