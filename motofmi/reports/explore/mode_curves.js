/* The eigenvalue of each mode from its branches: the method of vehicle_fmu/mode_curves.py, where it is explained. */

const PARTNER = 1e-6; // relative distance from the conjugate up to which two eigenvalues are a pair

/* {mode: {re, im}} at all points, NaN where a mode is absent. */
function modeCurves(system, branches, { distinct, above, below }) {
  const { points, spectra } = branches, given = [above, ...below.map(([, modes]) => modes)], curves = {};
  const present = MODES.filter((mode) => given.some((modes) => mode in modes));
  for (const mode of present) curves[mode] = { re: new Float64Array(points.length).fill(NaN), im: new Float64Array(points.length).fill(NaN) };
  const own = { ...above }, changes = [...below];
  for (let k = points.length - 1; k >= 0; k--) {
    while (changes.length && points[k] <= changes[0][0] + 1e-9) Object.assign(own, changes.shift()[1]);
    let found = present.map((mode) => alone(spectra[k], own[mode] ?? []));
    if (isShared(found)) found = oneEach(spectra[k], present.map((mode) => own[mode] ?? []), found, shapesAt(system, branches, points[k]), present.map((mode) => factors(distinct, above[mode] ?? [])));
    present.forEach((mode, m) => { if (found[m]) [curves[mode].re[k], curves[mode].im[k]] = found[m]; });
  }
  return curves;
}

/* The eigenvalue [re, |im|] of a mode by itself: the oscillatory one, otherwise the least stable; null without branches. */
function alone({ re, im }, columns) {
  let best = null, swing = 0, growth = -Infinity;
  for (const c of columns) {
    const size = Math.hypot(re[c], im[c]), paired = columns.some((d) => Math.hypot(re[c] - re[d], im[c] + im[d]) <= PARTNER * size);
    const own = paired ? Math.abs(im[c]) : 0, rate = paired ? re[c] : -Infinity;
    if (own > swing || (swing === 0 && (best === null || rate > growth))) best = c;
    [swing, growth] = [Math.max(swing, own), Math.max(growth, rate)];
  }
  return best === null ? null : [re[best], Math.abs(im[best])];
}

function isEqual(a, b) { return a !== null && b !== null && a[0] === b[0] && a[1] === b[1]; }

function isShared(found) { return found.some((a, i) => found.some((b, j) => j < i && isEqual(a, b))); }

/* The participation of every state in the modes of given branches. */
function factors({ part, column, n }, columns) {
  return Array.from({ length: n }, (_, i) => column.reduce((sum, c, j) => sum + (columns.includes(c) ? part[i * n + j] : 0), 0));
}

/* The eigenvalue of each mode where modes share one: the assignment with the largest sum of agreements. Modes that share
   none keep theirs, unless one that shares has no other. */
function oneEach({ re, im }, own, found, shapes, typical) {
  const { n, part } = shapes, values = [];
  re.forEach((r, i) => { if (!values.some((v) => isEqual(v, [r, Math.abs(im[i])]))) values.push([r, Math.abs(im[i])]); });
  const scores = own.map((columns, m) => {
    const settled = found.filter((f) => isEqual(f, found[m])).length === 1;
    return values.map((value) => {
      if (!columns.some((c) => isEqual(value, [re[c], Math.abs(im[c])]))) return -Infinity;
      const j = sortedBy(Array.from({ length: n }, (_, i) => i), (i) => Math.hypot(shapes.re[i] - value[0], Math.abs(shapes.im[i]) - value[1]))[0];
      return cosine(typical[m], typical[m].map((_, i) => part[i * n + j])) + (settled && isEqual(value, found[m]) ? own.length : 0);
    });
  });
  return bestAssignment(scores).map((e) => (e < 0 ? null : values[e]));
}

function cosine(a, b) {
  const dot = (u, v) => u.reduce((sum, x, i) => sum + x * v[i], 0), size = Math.sqrt(dot(a, a) * dot(b, b));
  return size > 0 ? dot(a, b) / size : 0;
}

/* The column of each row, -1 for none: as many as possible, then the largest sum. */
function bestAssignment(scores) {
  const nothing = -scores.length * scores.length - 1;
  const search = (row, used) => {
    if (row === scores.length) return [0, []];
    const choices = [-1, ...scores[row].map((_, e) => e)].filter((e) => e < 0 || (!used.includes(e) && scores[row][e] > -Infinity));
    return choices.map((e) => {
      const [sum, rest] = search(row + 1, e < 0 ? used : [...used, e]);
      return [sum + (e < 0 ? nothing : scores[row][e]), [e, ...rest]];
    }).reduce((a, b) => (b[0] > a[0] ? b : a));
  };
  return search(0, [])[1];
}
