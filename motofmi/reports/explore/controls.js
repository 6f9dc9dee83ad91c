/* The controls of the configuration that is edited: vehicle, device, and a slider with a number for every parameter. */

const PROMINENT = ["trail", "ground_trail", "caster_angle", "front_cornering_stiffness", "rear_cornering_stiffness", "front_cornering_stiffness_0", "rear_cornering_stiffness_0", "front_pKy1", "rear_pKy1", "gravity", "steering_damping"];

const MOST_DEVICES = 3, MOST_OPEN = 12; // devices that act together; parameters of a device that are not folded

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

/* Buttons of which one is pressed; they are made again where the options have changed. */
function pressed(parent, options, chosen, choose) {
  const key = JSON.stringify(options);
  if (parent.dataset.options === key) {
    for (const button of parent.querySelectorAll("button")) if ((button.dataset.value === chosen) !== (button.getAttribute("aria-pressed") === "true")) button.setAttribute("aria-pressed", String(button.dataset.value === chosen));
    return;
  }
  parent.dataset.options = key;
  parent.querySelectorAll("button").forEach((b) => b.remove());
  for (const [value, label] of options)
    parent.append(element("button", { type: "button", "aria-pressed": String(value === chosen), "data-value": value, onclick: () => choose(value) }, label));
}

/* Write an element's content where it has changed: cell by cell if nothing but the text of table cells differs. */
function written(place, html) {
  const last = place.lastWritten;
  if (last?.html === html) return;
  const split = (text) => text.split(/(?<=<td[^>]*>)([^<]*)(?=<\/td>)/), now = split(html), before = last ? last.parts : [];
  place.lastWritten = { html, parts: now };
  if (now.length !== before.length || now.some((text, i) => i % 2 === 0 && text !== before[i])) {
    place.innerHTML = html;
    return;
  }
  const cells = [...place.querySelectorAll("td")].filter((cell) => !cell.firstElementChild);
  cells.forEach((cell, k) => { if (now[2 * k + 1] !== before[2 * k + 1]) cell.textContent = now[2 * k + 1]; });
}

class Controls {
  constructor(settings, changed) {
    Object.assign(this, { settings, changed, place: document.getElementById("parameters") });
    this.build();
  }

  build() {
    const { settings } = this, side = settings.edit, open = [...this.place.querySelectorAll("details[open]")].map((d) => d.id);
    pressed(document.getElementById("edit"), SIDES.map((s) => [s, s]), side, (s) => { settings.edit = s; this.build(); this.changed([]); });
    const devices = devicesOf(settings[side].device), slots = [...devices, ...(devices.length < MOST_DEVICES ? ["none"] : [])];
    this.refused = {};
    this.place.replaceChildren(
      this.select("choose-vehicle", "Motorcycle", Object.keys(settings.data.vehicles), settings[side].vehicle, (vehicle) => ({ vehicle })),
      ...slots.map((name, k) => this.select(k ? `choose-device-${k + 1}` : "choose-device", k ? `Device ${k + 1}` : "Device: rider or damper",
        ["none", ...Object.keys(settings.data.choices)], name, (chosen) => ({ device: slots.with(k, chosen).filter((n) => n !== "none").join(",") || "none" }))),
      ...Object.entries(this.refused).map(([reason, names]) => element("p", { class: "note" }, `Not offered, because ${reason}: ${names.length > 4 ? `${names.slice(0, 3).join(", ")} and ${names.length - 3} others` : names.join(", ")}.`)),
      ...Object.entries(settings.components(side)).reverse().flatMap(([part, component]) => [...(devices.length > 1 ? [element("h2", {}, part === "vehicle" ? settings[side].vehicle : devices[Number(part.slice(7) || 1) - 1])] : []), ...this.group(side, part, component)]));
    for (const id of open) document.getElementById(id)?.setAttribute("open", "");
  }

  /* A list of which some names may be refused beside the others that are chosen. */
  select(id, label, names, chosen, change) {
    const { settings, settings: { edit } } = this;
    const options = names.map((n) => {
      const { vehicle, device } = { ...settings[edit], ...change(n) }, reason = settings.refusal(vehicle, device);
      if (reason) this.refused[reason] = [...new Set([...(this.refused[reason] ?? []), n])];
      return element("option", { value: n, selected: n === chosen, disabled: reason !== "" }, n);
    });
    const list = element("select", { id, onchange: () => { settings.choose(edit, change(list.value)); this.build(); this.changed([edit]); } }, ...options);
    return element("p", {}, element("label", { for: id }, label), list);
  }

  group(side, part, component) {
    const names = Object.keys(component.values), isDevice = part !== "vehicle", { settings } = this;
    if (!settings.data.modules[component.module].wasm) return [element("p", { class: "note" }, `${component.title} is an FMU of another tool, linearised at its start values: its parameters cannot be changed here.`)];
    const first = isDevice ? names.slice(0, MOST_OPEN) : names.filter((n) => PROMINENT.includes(n)), more = names.filter((n) => !first.includes(n));
    const made = [...first.map((n) => this.slider(side, `${part}.${n}`))];
    if (more.length) made.push(element("details", { id: `more-${part}` }, element("summary", {}, `${more.length} more parameters of the ${isDevice ? component.title : part}`), ...more.map((n) => this.slider(side, `${part}.${n}`))));
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
    const number = element("input", { type: "number", step: "any", value: text(now), "aria-label": `${row.description}, value`, onchange: () => { write(number.value, number); number.value = text(settings.value(side, key)); } });
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
