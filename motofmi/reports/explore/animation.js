/* The motion of one mode: what the eigenvector says of roll, steer, torso, lean, yaw and lateral shift, over time.

   A mode moves as Re(q exp(lambda t)). Yaw and shift follow from psi' = r and y' = v + V psi. */

const ANGLES = ["roll", "steer", "torso", "lean", "yaw"], LEAN = ["upper_body_angle", "rider_lean_position", "lean_angle"]; // of vehicles with a rider who leans, and of such a rider
const LARGEST = 0.22; // rad, of the largest angle; a shift is at most 0.45 m

class Motion {
  constructor(page) {
    Object.assign(this, { page, place: document.getElementById("motion"), playing: !matchMedia("(prefers-reduced-motion: reduce)").matches, clock: 0 });
    const views = Object.entries(VIEWS).map(([key, { label, box }]) => `<figure><svg viewBox="${box.join(" ")}" role="img" aria-label="Motorcycle and rider, ${label}" data-view="${key}" class="motorcycle"></svg><figcaption>${label}</figcaption></figure>`);
    this.place.innerHTML = `<h2>The mode, animated</h2><div class="choice" id="mode" role="group" aria-label="Mode"></div><p class="note" id="motion-text"></p>
      <div class="views">${views.join("")}<figure class="phases"><svg viewBox="-90 -90 180 180" role="img" aria-label="Phasors of roll, steer, torso, lean and yaw" id="phasors"></svg><figcaption>amplitudes and phases:<br><span id="arrows"></span></figcaption></figure></div>
      <button type="button" id="play"></button>`;
    document.getElementById("play").addEventListener("click", () => { this.playing = !this.playing; this.label(); });
    this.label();
    const step = (now) => {
      const passed = Math.min((now - (this.last ?? now)) / 1000, 0.1);
      this.last = now;
      if (this.playing && this.mode) this.clock += passed;
      if (this.mode && !document.hidden && (this.playing || this.changed)) this.show();
      requestAnimationFrame(step);
    };
    requestAnimationFrame(step);
  }

  label() { document.getElementById("play").textContent = this.playing ? "Pause" : "Play"; }

  /* The mode at the speed, of the side and name in the settings. */
  update() {
    const { settings, found, systems } = this.page, names = Object.keys(found[settings.side].curves);
    const choose = (value) => { [settings.side, settings.mode] = value.split(" "); this.page.later([]); };
    const options = SIDES.flatMap((side) => Object.keys(found[side].curves).map((m) => [`${side} ${m}`, `${side}: ${shown(m)}`]));
    pressed(document.getElementById("mode"), options, `${settings.side} ${settings.mode}`, choose);
    if (!names.includes(settings.mode)) settings.mode = names[0];
    const here = found[settings.side], i = nearestIndex(here.points, settings.speed), { re, im } = here.curves[settings.mode];
    this.mode = Number.isFinite(re[i]) ? modeShape(systems[settings.side], here.points[i], re[i], im[i]) : null;
    const { vehicle } = settings.parts(settings.side, this.page.libraries);
    this.geometry = geometry(vehicle.values);
    this.shape = bodies(this.geometry);
    this.changed = true;
    this.describe();
  }

  describe() {
    const text = document.getElementById("motion-text"), { mode } = this, { settings } = this.page;
    if (!mode) {
      text.textContent = `${shown(settings.mode)} is absent at this speed.`;
      document.getElementById("phasors").replaceChildren();
      return;
    }
    const time = Math.log(2) / Math.abs(mode.re), growth = Math.abs(mode.re) < 1e-6 ? "neither grows nor decays" : `${mode.re > 0 ? "doubles" : "halves"} in ${time.toPrecision(2)} s`;
    const slow = mode.im > 0 ? ` Shown ${mode.slower.toFixed(1)} times slower than in reality, again and again over ${mode.cycles} cycles.` : " Shown again and again.";
    const left = this.geometry.generic ? " The lengths in the drawing are those of no motorcycle." : furtherStates(this.page.systems[settings.side].states).includes("vehicle") ? " Twist and bending of the frame are not drawn." : "";
    text.textContent = `${shown(settings.mode)} of ${settings.side}, ${settings.title(settings.side)}, at ${settings.speed.toFixed(1)} m/s: ${mode.im > 0 ? `${(mode.im * TO_HERTZ).toFixed(2)} Hz, ` : "not oscillating, "}${growth}.${slow}${left}`;
    const moving = ANGLES.filter((n) => Math.hypot(...mode.shape[n]) > 0);
    document.getElementById("phasors").innerHTML = phasors(mode.shape, moving);
    written(document.getElementById("arrows"), moving.map((n) => `<span class="arrow ${n}">&#9679; ${n}</span>`).join(" "));
  }

  show() {
    this.changed = false;
    const { mode } = this, time = mode.timeOf(this.clock), pose = {};
    for (const [name, [a, b]] of Object.entries(mode.shape)) pose[name] = Math.exp(mode.re * time) * mode.start * (a * Math.cos(mode.im * time) - b * Math.sin(mode.im * time));
    const lines = posed(this.geometry, this.shape, pose);
    for (const drawn of this.place.querySelectorAll(".motorcycle")) drawView(drawn, lines, VIEWS[drawn.dataset.view], drawn.dataset.view !== "top");
  }
}

/* Eigenvector nearest to re + i im as roll, steer, torso, yaw and shift; how its time runs on the screen. */
function modeShape(system, speed, re, im) {
  const { n } = system, found = eigen(system.matrix(speed), n);
  let best = 0;
  for (let j = 1; j < n; j++) if (Math.hypot(found.re[j] - re, found.im[j] - im) < Math.hypot(found.re[best] - re, found.im[best] - im)) best = j;
  const value = (...names) => {
    const row = system.states.findLastIndex((s) => names.some((name) => s.endsWith(`.${name}`)));
    return row < 0 ? [0, 0] : [found.vectorRe[row * n + best], found.vectorIm[row * n + best]];
  };
  const square = re * re + im * im || 1e-12, integral = ([a, b]) => [(a * re + b * im) / square, (b * re - a * im) / square];
  const yaw = integral(value("yaw_rate")), v = value("lateral_velocity");
  const raw = { roll: value("roll_angle"), steer: value("steer_angle"), torso: value("torso_angle"), lean: value(...LEAN), yaw, shift: integral([v[0] + speed * yaw[0], v[1] + speed * yaw[1]]) };
  const size = ([a, b]) => Math.hypot(a, b), angle = Math.max(...ANGLES.map((k) => size(raw[k]))), scale = Math.min(LARGEST / angle, 0.45 / (size(raw.shift) || 1e-12));
  const lead = raw[Object.keys(raw).reduce((a, b) => (size(raw[b]) > size(raw[a]) && b !== "shift" ? b : a))], phase = Math.atan2(lead[1], lead[0]), c = Math.cos(phase) * scale, s = Math.sin(phase) * scale;
  const shape = Object.fromEntries(Object.entries(raw).map(([k, [a, b]]) => [k, [a * c + b * s, b * c - a * s]]));
  const cycles = 4, slower = im > 0 ? Math.max((im * TO_HERTZ) / 0.8, 1) : 1, span = im > 0 ? (cycles * 2 * Math.PI) / im : Math.min(2 * Math.abs(1 / (re || 1e-3)), 6);
  const pause = im > 0 ? slower : span / 3;
  return { re, im, shape, cycles, slower, start: Math.exp(-Math.max(re, 0) * span), timeOf: (clock) => (clock / pause) % span };
}

/* Arrows for the angles: length and direction are amplitude and phase, the largest has the radius of the circle. */
function phasors(shape, names) {
  const most = Math.max(...names.map((n) => Math.hypot(...shape[n])));
  const arrows = names.map((n) => {
    const [x, y] = shape[n].map((v) => (75 * v) / most);
    return `<g class="arrow ${n}"><line x1="0" y1="0" x2="${x.toFixed(1)}" y2="${(-y).toFixed(1)}"/><circle cx="${x.toFixed(1)}" cy="${(-y).toFixed(1)}" r="5"/></g>`;
  });
  return `<circle r="75" class="grid" fill="none"/><line x1="-75" x2="75" class="grid"/><line y1="-75" y2="75" class="grid"/>${arrows.join("")}`;
}
