/* The page: settings, modes of both configurations, and everything that shows them. */

const SETTLED = 150; // ms without a change, after which the fine grid is computed

const REDRAWN = 100; // ms between two shapes of the animated mode while a slider moves

const REFUSED = `<p class="note">These values are outside the bounds of a component, or leave no rear frame without the rider: what is drawn are the last ones that are possible.</p>`;

class Page {
  static async open() {
    const data = JSON.parse(document.getElementById("data").textContent);
    return new Page(data, await Library.load(data.modules));
  }

  constructor(data, libraries) {
    Object.assign(this, { data, libraries, settings: new Settings(data), systems: {}, found: {}, refused: {}, moved: 0, axes: {}, waiting: new Set(), coarse: new Set() });
    SIDES.forEach((side) => this.compute(side));
    this.controls = new Controls(this.settings, (sides) => this.later(sides));
    this.motion = new Motion(this);
    this.live = new Live(this);
    this.listen();
    this.draw();
    this.settle();
    document.getElementById("about").textContent = `motofmi ${data.version}. Eigenvalues with ml-matrix 6.15.1 (MIT licence). Nothing is loaded from a network.`;
  }

  /* The modes of a side; the last ones stay where a value is refused. */
  compute(side, step = FINE) {
    const system = new Coupled(this.settings.parts(side, this.libraries));
    this.refused[side] = !system.valid;
    if (!system.valid && this.systems[side]) return system.free();
    this.systems[side]?.free();
    this.systems[side] = system;
    this.found[side] = namedModes(system, step);
  }

  /* Draws once for several changes within one frame, with a coarse grid of speeds; `settle` follows when the changes
     have ended. */
  later(sides) {
    sides.forEach((side) => this.waiting.add(side));
    this.frame ??= requestAnimationFrame(() => {
      this.frame = undefined;
      this.waiting.forEach((side) => { this.compute(side, COARSE); this.coarse.add(side); });
      this.waiting.clear();
      this.draw();
      clearTimeout(this.timer);
      this.timer = setTimeout(() => this.settle(), SETTLED);
    });
  }

  /* Draws with the fine grid what is drawn with the coarse one, and writes the address. */
  settle() {
    clearTimeout(this.timer);
    const sides = new Set([...this.coarse, ...this.waiting]);
    this.waiting.clear();
    this.coarse.clear();
    sides.forEach((side) => this.compute(side));
    if (sides.size) this.draw();
    this.live.update();
    this.settings.write();
  }

  listen() {
    const by = (id) => document.getElementById(id), { settings } = this;
    by("speed").addEventListener("input", () => { settings.speed = Number(by("speed").value); this.later([]); });
    by("copy").addEventListener("click", () => { settings.B = structuredClone(settings.A); this.refresh(["B"]); });
    by("reset").addEventListener("click", () => { settings[settings.edit].values = {}; this.refresh([settings.edit]); });
    by("csv").addEventListener("click", () => { this.settle(); download("modes.csv", "text/csv", table(this)); });
    by("svg").addEventListener("click", () => { this.settle(); download("modes.svg", "image/svg+xml", drawing()); });
    addEventListener("hashchange", () => { settings.read(location.hash.slice(1)); this.refresh(SIDES); });
    const charts = by("charts");
    charts.addEventListener("pointermove", (event) => this.point(event, false));
    charts.addEventListener("click", (event) => this.point(event, true));
    charts.addEventListener("pointerleave", () => document.querySelector(".tip")?.remove());
  }

  refresh(sides) {
    this.controls.build();
    this.later(sides);
  }

  draw() {
    const { settings, found } = this, all = SIDES.map((side) => found[side]), { view, speed } = settings;
    const own = view === "locus" ? locusLimits(all) : speedLimits(all), last = this.limits?.view === view && this.coarse.size ? this.limits : null;
    const { limits } = (this.limits = { view, limits: last ? joined(own, last.limits) : own }), chart = view === "locus" ? locusChart : speedChart;
    document.getElementById("speed").value = speed;
    document.getElementById("speed-value").textContent = `${speed.toFixed(1)} m/s`;
    pressed(document.getElementById("view"), [["locus", "Root locus"], ["speed", "Frequency and damping over speed"]], view, (v) => { settings.view = v; this.later([]); });
    for (const side of SIDES) this.panel(side, chart, limits);
    document.getElementById("published").textContent = this.published();
    for (const side of SIDES) written(document.querySelector(`#readings [data-side=${side}]`), this.readings(side));
    if (!this.coarse.size || performance.now() - this.moved > REDRAWN) this.drawMotion();
    if (this.live.running) this.live.update();
  }

  drawMotion() {
    this.moved = performance.now();
    this.motion.update();
  }

  /* The chart of a side, drawn again where something in it has changed. */
  panel(side, chart, limits) {
    const { settings, found } = this, panel = document.querySelector(`.chart[data-side=${side}]`), key = JSON.stringify([settings.view, settings.speed, settings[side], limits, this.coarse.has(side), this.refused[side]]);
    if (panel.dataset.key === key) return;
    const { axes, label, parts } = chart(found[side], limits, settings.speed, marksOf(this.data.published, settings[side]), `clip-${side}`);
    const frame = JSON.stringify([settings.view, limits, settings.title(side), this.refused[side]]);
    this.axes[side] = axes;
    panel.dataset.key = key;
    if (panel.dataset.frame !== frame) {
      panel.dataset.frame = frame;
      const text = svg(parts.map((part) => part.axes.draw(part.x, part.y, part.id)).join(""), label);
    panel.innerHTML = `<h2><span>${side}</span>${escaped(settings.title(side))}</h2>${this.refused[side] ? REFUSED : ""}${text}`;
    }
    for (const { id, content } of parts) document.getElementById(`${id}-content`).innerHTML = content;
  }

  published() {
    const sources = new Set(SIDES.flatMap((side) => marksOf(this.data.published, this.settings[side]).map((p) => p.source)));
    return sources.size ? `Crosses: published values (${[...sources].join("; ")}).` : "";
  }

  readings(side) {
    const found = this.found[side], at = nearestIndex(found.points, this.settings.speed);
    const rows = Object.keys(found.curves).map((mode) => {
      const here = reading(found, mode, at), cell = (value, digits) => (here && Number.isFinite(value) ? value.toFixed(digits) : "-");
      const unstable = found.unstable[mode].length ? "bad" : "";
      return `<tr><td><span class="dot" style="--ink:${INK[mode]}"></span>${shown(mode)}</td><td>${cell(here?.frequency, 2)}</td><td>${cell(here?.ratio, 3)}</td><td class="wide">${cell(here?.re, 2)}</td><td class="${unstable}">${bandsText(found, mode)}</td></tr>`;
    });
    const mixed = found.mixed.some(([a, b]) => a <= this.settings.speed && this.settings.speed <= b) ? `<p class="note">Two modes have exchanged so much of their shapes that the names of either apply to both at this speed.</p>` : "";
    return `<h2><span class="tag">${side}</span>at ${this.settings.speed.toFixed(1)} m/s</h2><table><thead><tr><th>mode</th><th>frequency [Hz]</th><th>damping ratio</th><th class="wide">real part [1/s]</th><th>unstable [m/s]</th></tr></thead><tbody>${rows.join("")}</tbody></table>${mixed}`;
  }

  /* The reading at the pointer; a click moves the speed there and selects the mode. */
  point(event, chosen) {
    document.querySelector(".tip")?.remove();
    const chart = event.target.closest(".chart"), drawn = event.target.closest("svg");
    if (!chart || !drawn) return;
    const side = chart.dataset.side, box = drawn.getBoundingClientRect(), scale = WIDTH / box.width, { view } = this.settings;
    const near = nearestPoint(this.found[side], this.axes[side], view, (event.clientX - box.left) * scale, (event.clientY - box.top) * scale);
    if (near.apart > 30) return;
    const { speed, frequency, ratio, re } = reading(this.found[side], near.mode, near.index);
    if (chosen) {
      Object.assign(this.settings, { speed: Number(speed.toFixed(1)), mode: near.mode, side });
      this.later([]);
      return;
    }
    const tip = element("div", { class: "tip" }, `${shown(near.mode)}: ${speed.toFixed(1)} m/s, ${frequency.toFixed(2)} Hz, ${Number.isFinite(ratio) ? `damping ratio ${ratio.toFixed(3)}` : `real part ${re.toFixed(2)} 1/s`}`);
    const outer = chart.getBoundingClientRect();
    chart.append(tip);
    tip.style.top = `${near.py / scale + box.top - outer.top}px`;
    tip.style.left = `${Math.min(Math.max(near.px / scale + box.left - outer.left, tip.offsetWidth / 2), outer.width - tip.offsetWidth / 2)}px`;
  }
}

function escaped(text) { return text.replace(/[&<>"]/g, (c) => `&#${c.charCodeAt(0)};`); }

function table({ found, settings }) {
  const rows = [["configuration", "mode", "speed [m/s]", "real [1/s]", "imag [rad/s]", "frequency [Hz]", "damping ratio [1]"]];
  for (const side of SIDES)
    for (const mode of Object.keys(found[side].curves))
      found[side].points.forEach((_, i) => {
        const here = reading(found[side], mode, i);
        if (here) rows.push([`${side} ${settings.title(side).replaceAll(",", ";")}`, mode, here.speed, here.re, here.im, here.frequency, Number.isFinite(here.ratio) ? here.ratio : ""]);
      });
  return rows.map((row) => row.join(",")).join("\n") + "\n";
}

/* Both charts as one file, with the styles and colours of the page. */
function drawing() {
  const style = getComputedStyle(document.documentElement), names = ["paper", "panel", "ink-text", "soft", "line", "weave", "wobble", "capsize", "rear-wobble", "rider-wobble", "shade"];
  const colours = `svg{${names.map((n) => `--${n}:${style.getPropertyValue(`--${n}`).trim()}`).join(";")};font-family:sans-serif}`;
  const rules = [...document.styleSheets[0].cssRules].filter((r) => /^\.(grid|frame|tick|label|curve|mark|unstable|band|cursor)/.test(r.selectorText ?? "")).map((r) => r.cssText).join("");
  const charts = [...document.querySelectorAll("#charts svg")].map((s, i) => `<g transform="translate(${i * WIDTH} 24)"><text x="56" y="-6" class="label">${SIDES[i]}: ${escaped(s.parentElement.querySelector("h2").textContent.slice(1))}</text>${s.innerHTML}</g>`);
  return `<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 ${2 * WIDTH} ${HEIGHT + 24}"><style>${colours}${rules}</style><rect width="100%" height="100%" fill="var(--paper)"/>${charts.join("")}</svg>`;
}

function download(name, type, text) {
  const link = element("a", { href: URL.createObjectURL(new Blob([text], { type })), download: name });
  link.click();
  URL.revokeObjectURL(link.href);
}

addEventListener("DOMContentLoaded", async () => { window.page = await Page.open(); });
