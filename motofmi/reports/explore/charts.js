/* The two views of the modes of both configurations: root locus over speed, frequency and damping ratio over speed. */

const WIDTH = 440, HEIGHT = 340, TO_HERTZ = 1 / (2 * Math.PI), NAMED = 0.3; // Hz, below which a name would lie on the axis

function dampingRatio(re, im) { return im > 0 ? -re / Math.hypot(re, im) : NaN; }

/* Limits of the root locus that hold the oscillating modes of all found modes, and the axis Im = 0. */
function locusLimits(all) {
  let left = -5, right = 2, top = 10;
  for (const found of all)
    for (const { re, im } of Object.values(found.curves))
      for (let i = 0; i < re.length; i++) {
        if (!(im[i] > 0.5)) continue;
        left = Math.min(left, re[i]);
        right = Math.max(right, re[i]);
        top = Math.max(top, im[i]);
      }
  const step = (value, by) => Math.ceil(value / by) * by;
  return { x: [-step(Math.min(-left * 1.05, 60), 5), step(right * 1.05, 5)], y: [0, step(top * 1.05, 10)] };
}

function speedLimits(all) {
  let top = 2;
  for (const found of all) for (const { im } of Object.values(found.curves)) for (const value of im) if (value > 0) top = Math.max(top, value * TO_HERTZ);
  return { x: [0, 60], frequency: [0, Math.ceil(top * 1.12)], damping: [-0.2, 1] };
}

/* Limits that hold two others of the same view: while a slider moves, axes grow and do not shrink. */
function joined(a, b) { return Object.fromEntries(Object.entries(a).map(([axis, [low, high]]) => [axis, [Math.min(low, b[axis][0]), Math.max(high, b[axis][1])]])); }

function marksOf(published, configuration) {
  const { vehicle, device, values } = configuration;
  return published.filter((p) => p.vehicle === vehicle && p.device === device && !Object.keys(values).length);
}

function locusChart(found, limits, speed, published, id) {
  const axes = new Axes({ left: 56, top: 12, width: WIDTH - 70, height: HEIGHT - 64 }, limits.x, limits.y), at = nearestIndex(found.points, speed);
  const half = `<rect x="${axes.x(0)}" y="0" width="${WIDTH}" height="${HEIGHT}" class="unstable"/>`;
  const gaps = gapsOf(found), curves = Object.entries(found.curves).map(([mode, { re, im }]) => {
    const dots = found.points.map((p, i) => (Math.abs(p / 10 - Math.round(p / 10)) < 1e-9 && Number.isFinite(re[i]) ? `M${axes.x(re[i]).toFixed(1)} ${axes.y(im[i]).toFixed(1)}h0` : "")).join("");
    return `<g style="--ink:${INK[mode]}" class="curve" data-mode="${mode}"><path d="${axes.path(re, im, gaps)}"/><path class="dots" d="${dots}"/>` +
      (Number.isFinite(re[at]) ? `<circle class="here" cx="${axes.x(re[at])}" cy="${axes.y(im[at])}" r="6"/>` +
        nameAt(axes.x(re[at]), axes.y(im[at]), shown(mode)) : "") + "</g>";
  });
  const marks = published.flatMap(({ eigenvalues = {}, source }) => Object.entries(eigenvalues).flatMap(([mode, rows]) => rows.map(([v, re, im]) => cross(axes.x(re), axes.y(im), INK[mode], `${source}: ${shown(mode)} at ${v.toFixed(1)} m/s`))));
  return { axes, label: "Root locus over speed", parts: [{ axes, id, x: "real part [1/s]", y: "imaginary part [rad/s]", content: half + curves.join("") + marks.join("") }] };
}

function speedChart(found, limits, speed, published, id) {
  const third = (HEIGHT - 74) / 2, frame = (top) => ({ left: 56, top, width: WIDTH - 70, height: third });
  const upper = new Axes(frame(12), limits.x, limits.frequency), lower = new Axes(frame(28 + third), limits.x, limits.damping);
  const bands = (axes) => Object.entries(found.unstable).flatMap(([mode, list]) => list.map(([a, b]) =>
    `<rect x="${axes.x(a)}" y="${axes.frame.top}" width="${axes.x(b) - axes.x(a)}" height="${axes.frame.height}" style="fill:${INK[mode]}" class="band"/>`)).join("");
  const gaps = gapsOf(found), line = (axes) => `<line x1="${axes.x(speed)}" x2="${axes.x(speed)}" y1="0" y2="${HEIGHT}" class="cursor"/>`;
  const curves = (axes, value) => Object.entries(found.curves).map(([mode, { re, im }]) =>
    `<g style="--ink:${INK[mode]}" class="curve" data-mode="${mode}"><path d="${axes.path(found.points, found.points.map((_, i) => value(re[i], im[i])), gaps)}"/></g>`).join("");
  const marks = published.flatMap(({ eigenvalues = {}, frequencies = {}, source }) => [
    ...Object.entries(eigenvalues).flatMap(([mode, rows]) => rows.filter((r) => r[2] > 0).map(([v, , im]) => cross(upper.x(v), upper.y(im * TO_HERTZ), INK[mode], `${source}: ${shown(mode)}`))),
    ...Object.entries(frequencies).flatMap(([mode, rows]) => rows.map(([v, low, high]) => cross(upper.x(v), upper.y((low + high) / 2), INK[mode], `${source}: ${shown(mode)} ${low} to ${high} Hz`))),
  ]).join("");
  const parts = [
    { axes: upper, id: `${id}-f`, x: "", y: "frequency [Hz]", content: bands(upper) + curves(upper, (re, im) => im * TO_HERTZ) + line(upper) + marks + namesOver(found, upper) },
    { axes: lower, id: `${id}-d`, x: "speed [m/s]", y: "damping ratio [1]", content: bands(lower) + curves(lower, dampingRatio) + line(lower) },
  ];
  return { axes: upper, label: "Frequency and damping ratio over speed", parts };
}

/* The points behind which a name goes over to another branch. */
function gapsOf(found) { return new Set(found.exchanges.map((speed) => nearestIndex(found.points, speed))); }

/* The name of a mode beside its point, on the side where there is room. */
function nameAt(x, y, name) {
  const right = x < WIDTH - 90;
  return `<text x="${x + (right ? 9 : -9)}" y="${y - 7}" text-anchor="${right ? "start" : "end"}">${name}</text>`;
}

/* The name of each mode over the highest speed at which it oscillates; nearer names are shifted upwards. */
function namesOver(found, axes) {
  const ends = Object.entries(found.curves).map(([mode, { im }]) => [mode, im.findLastIndex((v) => v * TO_HERTZ > NAMED), im]).filter(([, at]) => at >= 0);
  const placed = [];
  return sortedBy(ends, ([, at, im]) => im[at]).map(([mode, at, im]) => {
    const x = Math.max(axes.x(found.points[at]) - 4, axes.frame.left + 70), y = axes.y(Math.max(...im.slice(Math.max(at - 40, 0), at + 1)) * TO_HERTZ) - 5;
    const clear = placed.reduce((lowest, [px, py]) => (Math.abs(px - x) < 75 && Math.abs(py - lowest) < 12 ? py - 12 : lowest), y);
    placed.push([x, clear]);
    return `<g style="--ink:${INK[mode]}" class="curve"><text x="${x.toFixed(1)}" y="${clear.toFixed(1)}" text-anchor="end">${shown(mode)}</text></g>`;
  }).join("");
}

function cross(x, y, ink, text) { return `<path class="mark" style="--ink:${ink}" d="M${x - 4} ${y - 4}l8 8M${x - 4} ${y + 4}l8 -8"><title>${text}</title></path>`; }

function svg(content, label) { return `<svg viewBox="0 0 ${WIDTH} ${HEIGHT}" role="img" aria-label="${label}" xmlns="http://www.w3.org/2000/svg">${content}</svg>`; }

function nearestIndex(points, speed) {
  let best = 0;
  points.forEach((p, i) => { if (Math.abs(p - speed) < Math.abs(points[best] - speed)) best = i; });
  return best;
}

/* The point of a curve nearest to a place in the drawing: {mode, index, apart}. */
function nearestPoint(found, axes, view, x, y) {
  let best = { apart: Infinity };
  for (const [mode, { re, im }] of Object.entries(found.curves))
    for (let i = 0; i < re.length; i++) {
      const px = view === "locus" ? axes.x(re[i]) : axes.x(found.points[i]), py = view === "locus" ? axes.y(im[i]) : axes.y(im[i] * TO_HERTZ);
      const apart = Math.hypot(px - x, py - y);
      if (apart < best.apart) best = { mode, index: i, apart, px, py };
    }
  return best;
}

function reading(found, mode, i) {
  const { re, im } = found.curves[mode], ratio = dampingRatio(re[i], im[i]);
  if (!Number.isFinite(re[i])) return null;
  return { speed: found.points[i], frequency: im[i] * TO_HERTZ, ratio, re: re[i], im: im[i] };
}

function bandsText(found, mode) {
  const list = found.unstable[mode];
  return list.length ? list.map(([a, b]) => `<span class="once">${a.toFixed(1)} to ${b.toFixed(1)}</span>`).join(", ") : "stable";
}
