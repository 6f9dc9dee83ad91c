/* The FMUs, live: they step in the page, and can be disturbed, changed and exchanged while they run. */

const TRACES = [["roll_angle", "roll [deg]"], ["steer_angle", "steer [deg]"], ["torso_angle", "torso [deg]"], ["lean_angle", "lean [deg]"]];
const TRACE_INKS = ["--weave", "--wobble", "--rider-wobble", "--rear-wobble"];
const SECONDS = 6, PULSE = 0.05, FALLEN = 60 / DEGREES;
const KICKS = { bar: ["steer_torque", 30, "Kick the bar"], frame: ["roll_torque", 400, "Push the frame"] };

class Live {
  constructor(page) {
    Object.assign(this, { page, running: false, pulses: {}, rows: [], place: document.getElementById("live") });
    this.place.innerHTML = `<h2>The FMUs, live</h2><p class="note" id="live-text"></p>
      <div class="buttons"><button type="button" id="run">Run</button>${Object.entries(KICKS).map(([key, [, , label]]) => `<button type="button" data-kick="${key}">${label}</button>`).join("")}
      <button type="button" id="restart">Restart</button><div class="choice" id="live-side" role="group" aria-label="Configuration that runs"></div></div>
      <canvas id="traces" width="1000" height="330" role="img" aria-label="Roll, steer, torso and lean over the last ${SECONDS} seconds"></canvas><p class="note" id="live-state" aria-live="polite"></p>`;
    document.getElementById("run").addEventListener("click", () => this.toggle());
    document.getElementById("restart").addEventListener("click", () => this.restart(false));
    for (const button of this.place.querySelectorAll("[data-kick]")) button.addEventListener("click", () => this.kick(button.dataset.kick));
    this.side = "B";
    this.restart(false);
  }

  /* New instances from the settings; with `keep` they continue from the present states. */
  restart(keep) {
    const { settings, libraries } = this.page, states = keep && this.run ? this.run.states() : {}, time = keep && this.run ? this.run.time : 0;
    const parts = settings.parts(this.side, libraries), initial = {};
    this.run?.free();
    this.run = null;
    this.shown = JSON.stringify(settings[this.side]);
    const able = Object.values(parts).every(({ library }) => library.wasm);
    for (const button of this.place.querySelectorAll(".buttons > button")) button.disabled = !able;
    if (able) {
      for (const [part, { library }] of Object.entries(parts))
        initial[part] = Object.fromEntries(library.states.filter((n) => Number.isFinite(states[part]?.[n])).map((n) => [n, states[part][n]]));
      this.run = new CoSimulation(parts, settings.speed, initial, time);
    } else {
      this.running = false;
      document.getElementById("live-state").textContent = "";
    }
    if (!keep || !able) this.rows = [];
    const fmus = this.run ? [this.run.vehicle, ...this.run.devices.map((d) => d.stepped)].map(({ fmu }) => fmu) : [];
    const owners = TRACES.map(([name]) => [name, fmus.find(({ library }) => library.states.includes(name))]).filter(([, fmu]) => fmu);
    this.names = owners.map(([name]) => name);
    this.read = () => owners.map(([name, fmu]) => fmu.get([name])[0]);
    this.describe();
    this.paint();
  }

  /* The settings have changed: parameters and components are exchanged, the speed is set. */
  update() {
    const { settings } = this.page;
    pressed(document.getElementById("live-side"), SIDES.map((s) => [s, s]), this.side, (s) => { this.side = s; this.restart(true); this.update(); });
    if (this.shown !== JSON.stringify(settings[this.side])) this.restart(true);
    else this.run?.disturb({ speed: settings.speed });
    this.describe();
  }

  describe() {
    const { settings } = this.page;
    const posture = this.run?.devices.some(({ stepped }) => changesInertia(stepped.fmu));
    const how = this.run ? `The compiled FMUs in WebAssembly step by ${1e3 * this.run.step} ms, one after the other: the torque continues as a parabola, then the angle as a Hermite cubic. The error of this coupling in the modes is below 0.01 %.${posture ? " The change of the rider's inertia at the handlebar with the posture, of third order in the angles, is neglected here." : ""}`
      : "It contains an FMU of another tool, which the page has as a linear system and cannot step: motofmi cosimulate steps it.";
    document.getElementById("live-text").textContent = `${this.side}: ${settings.title(this.side)} at ${settings.speed.toFixed(1)} m/s. ${how}`;
    document.getElementById("run").textContent = this.running ? "Pause" : "Run";
  }

  kick(name) {
    this.pulses[KICKS[name][0]] = { until: this.run.time + PULSE, value: KICKS[name][1] };
    if (!this.running) this.toggle();
  }

  toggle() {
    this.running = !this.running;
    this.last = performance.now();
    this.describe();
    if (this.running) requestAnimationFrame((now) => this.frame(now));
  }

  frame(now) {
    if (!this.running) return;
    const passed = Math.min(Math.max((now - this.last) / 1000, 0), 0.1), start = performance.now();
    this.last = now;
    const steps = Math.round(passed / this.run.step);
    for (let k = 0; k < steps && this.running; k++) this.advance(k);
    const spent = (performance.now() - start) / 1000;
    if (steps) this.rate = 0.9 * (this.rate ?? passed / spent) + 0.1 * Math.min(passed / Math.max(spent, 1e-5), 1e4);
    this.paint();
    requestAnimationFrame((next) => this.frame(next));
  }

  advance(k) {
    const now = Object.fromEntries(Object.entries(this.pulses).map(([input, { until, value }]) => [input, this.run.time < until ? value : 0]));
    const known = Object.fromEntries(Object.entries(now).filter(([input]) => this.run.vehicle.fmu.library.inputs.includes(input)));
    if (Object.keys(known).length) this.run.disturb(known);
    for (const input of Object.keys(now)) if (!now[input]) delete this.pulses[input];
    const ok = this.run.advance();
    if (k % 2 === 0) this.rows.push([this.run.time, ...this.read()]);
    const most = SECONDS / (2 * this.run.step);
    if (this.rows.length > most) this.rows.splice(0, this.rows.length - most);
    const roll = Math.abs(this.rows.at(-1)?.[1] ?? 0);
    if (!ok || !Number.isFinite(roll) || roll > FALLEN) this.stop(ok);
  }

  stop(ok) {
    this.running = false;
    document.getElementById("live-state").textContent = ok ? "It has leant by more than 60 degrees, where the linear model ends. Restart it." : "A step was refused. Restart it.";
    this.describe();
  }

  paint() {
    document.getElementById("traces").hidden = !this.run;
    if (!this.run) return;
    const canvas = document.getElementById("traces"), pen = canvas.getContext("2d"), style = getComputedStyle(document.documentElement), colour = (n) => style.getPropertyValue(n).trim();
    const ratio = Math.min(devicePixelRatio, 2), width = canvas.clientWidth * ratio || 1000, height = 110 * this.names.length * ratio;
    if (canvas.width !== Math.round(width) || canvas.height !== Math.round(height)) Object.assign(canvas, { width, height });
    pen.clearRect(0, 0, width, height);
    const end = Math.max(this.run.time, SECONDS), left = 74 * ratio, tall = 110 * ratio;
    pen.font = `${12 * ratio}px system-ui, sans-serif`;
    this.names.forEach((name, i) => {
      const label = TRACES.find(([n]) => n === name)[1], top = i * tall + 8 * ratio, inner = tall - 20 * ratio;
      const limit = Math.max(0.5, ...this.rows.map((r) => Math.abs(r[i + 1] ?? 0) * DEGREES)), y = (v) => top + inner / 2 - (v / limit) * (inner / 2), x = (t) => left + ((t - end + SECONDS) / SECONDS) * (width - left);
      pen.strokeStyle = colour("--line");
      pen.strokeRect(left, top, width - left - 1, inner);
      pen.fillStyle = colour("--soft");
      pen.fillText(label, 0, top + inner / 2 + 4);
      pen.fillText(limit.toPrecision(2), left + 4, top + 13 * ratio);
      pen.beginPath();
      pen.strokeStyle = colour(TRACE_INKS[i]);
      pen.lineWidth = 1.6 * ratio;
      this.rows.forEach((r) => (r[0] >= end - SECONDS && r.length > i + 1 ? pen.lineTo(x(r[0]), y(r[i + 1] * DEGREES)) : 0));
      pen.stroke();
    });
    if (this.running && this.rows.length) document.getElementById("live-state").textContent = `${this.run.time.toFixed(1)} s; the steps alone run ${Math.round(this.rate ?? 0)} times faster than real time.`;
  }
}
