/* Names of modes along the branches of the eigenvalues: the method of vehicle_fmu/mode_names.py and named_modes.py,
   where it is explained. A mode is a list of branches: a pair, or real roots. */

const MODES = ["weave", "wobble", "capsize", "rear_wobble", "rider_wobble"];
const FRONT = ["wobble", "rider_wobble", "rear_wobble"];
const LOWEST = 1, REFERENCE_SPEED = 60, FINE = 0.1, COARSE = 1, MIXED = 0.5, MAJORITY = 0.5, SHARE = 0.25;

/* The modes of a coupled system from LOWEST to REFERENCE_SPEED: {points, spectra, curves, unstable, mixed, exchanges}. */
function namedModes(system) {
  const spectrum = (speed) => eigenvalues(balance(system.matrix(speed), system.n).B, system.n);
  const first = Math.round(LOWEST / FINE), last = Math.round(REFERENCE_SPEED / FINE);
  const branches = track(spectrum, Array.from({ length: last - first + 1 }, (_, i) => FINE * (first + i)));
  const { points, spectra } = branches, names = nameModes(system, branches), curves = {}, unstable = {};
  const fill = (mode, columns, count) => {
    curves[mode] ??= { re: new Float64Array(points.length).fill(NaN), im: new Float64Array(points.length).fill(NaN) };
    follow(curves[mode], spectra, columns, count);
  };
  for (const [mode, columns] of Object.entries(names.above)) fill(mode, columns, points.length);
  for (const [below, modes] of names.below) {
    let count = points.length;
    while (count > 0 && points[count - 1] > below + 1e-9) count--;
    for (const [mode, columns] of Object.entries(modes)) fill(mode, columns, count);
  }
  const shown = Object.fromEntries(MODES.filter((m) => curves[m]).map((m) => [m, curves[m]]));
  for (const [mode, { re }] of Object.entries(shown)) unstable[mode] = unstableIntervals(spectrum, points, re);
  return { points, spectra, curves: shown, unstable, mixed: names.mixed, exchanges: names.below.map(([speed]) => speed) };
}

/* The eigenvalue of a mode from its branches, at the first `count` points: the oscillatory one, otherwise the least
   stable. Where one root of a mode forms a pair with a root of another mode, the other root counts. */
function follow(curve, spectra, columns, count) {
  for (let k = 0; k < count; k++) {
    const { re, im } = spectra[k];
    let swinging = -1, growing = -1, swing = 0, growth = -Infinity;
    for (const c of columns) {
      let least = Infinity;
      for (const d of columns) least = Math.min(least, (re[c] - re[d]) ** 2 + (im[c] + im[d]) ** 2);
      const apart = least > 1e-12 * (re[c] ** 2 + im[c] ** 2), own = apart ? -1 : Math.abs(im[c]), rate = apart ? -Infinity : re[c];
      if (own > swing) [swing, swinging] = [own, c];
      if (growing < 0 || rate > growth) [growth, growing] = [rate, c];
    }
    const best = swinging >= 0 ? swinging : growing;
    curve.re[k] = best < 0 ? NaN : re[best];
    curve.im[k] = best < 0 ? NaN : Math.abs(im[best]);
  }
}

/* The mode shapes at a speed of the grid: eigenvalues and vectors with the branch of each, participation factors. */
function shapesAt(system, branches, speed) {
  const { n } = system, shapes = eigen(system.matrix(speed), n), here = branches.spectra[indexOf(branches.points, speed)];
  const part = participation(shapes, n), total = new Float64Array(n);
  for (let i = 0; i < n; i++) for (let j = 0; j < n; j++) total[j] += part[i * n + j];
  const column = Array.from({ length: n }, (_, i) => {
    let best = 0;
    for (let j = 1; j < n; j++) if (distance(shapes, i, here, j) < distance(shapes, i, here, best)) best = j;
    return best;
  });
  const places = system.states.map((s) => [s.slice(0, s.lastIndexOf(".")), s.slice(s.lastIndexOf(".") + 1)]);
  const owner = places.find(([, name]) => name.startsWith("steer"))?.[0];
  const share = (chosen) => Array.from({ length: n }, (_, j) => places.reduce((sum, place, i) => sum + (chosen(place) ? part[i * n + j] : 0), 0) / total[j]);
  const signal = (name) => places.findLastIndex((place) => place[1] === name);
  const size = (row, j) => (row < 0 ? 0 : Math.hypot(shapes.vectorRe[row * n + j], shapes.vectorIm[row * n + j]));
  const torso = signal("torso_angle"), steer = signal("steer_angle"), rear = signal("rear_side_force"), front = signal("front_side_force");
  return {
    ...shapes, column, n, share,
    foreign: share(([place, name]) => owner !== undefined && place !== owner && !name.startsWith("torso")),
    upper: column.map((_, i) => i).filter((i) => shapes.im[i] > 0),
    pair: (i) => [column[i], column[i + 1]],
    tyres: column.map((_, j) => (size(front, j) > 0 ? size(rear, j) / size(front, j) : 0)),
    together: column.map((_, j) => {
      const sum = size(torso, j) ** 2 + size(steer, j) ** 2;
      if (torso < 0 || steer < 0 || !(sum > 0)) return 0;
      const at = (row) => [shapes.vectorRe[row * n + j], shapes.vectorIm[row * n + j]], [a, b] = at(torso), [c, d] = at(steer);
      return (a * c + b * d) / sum;
    }),
  };
}

function indexOf(points, speed) {
  let low = 0, high = points.length;
  while (low < high) {
    const middle = (low + high) >> 1;
    if (points[middle] < speed - 1e-9) low = middle + 1;
    else high = middle;
  }
  return low;
}

function sortedBy(list, key) { return [...list].sort((a, b) => key(a) - key(b)); }

function nameModes(system, branches) {
  const above = namedAt(system, branches), { formation, another } = formationOfAnotherPair(system, branches, above);
  if (!another.length) return { above, below: [], mixed: [] };
  const named = new Set(Object.entries(above).flatMap(([mode, columns]) => (mode.startsWith("other") ? [] : columns)));
  if (!another.some((c) => named.has(c))) above.rear_wobble = another;
  const high = Math.floor(formation / FINE + 1e-9), low = Math.ceil(branches.points[0] / FINE - 1e-9);
  const tenths = Array.from({ length: high - low + 1 }, (_, i) => FINE * (high - i)), stride = Math.round(COARSE / FINE);
  const coarse = tenths.map((_, k) => k).filter((k) => k % stride === 0 || k === tenths.length - 1);
  const characters = new Map(), look = (k) => characters.set(k, character(shapesAt(system, branches, tenths[k]), above));
  const text = (k) => JSON.stringify(characters.get(k));
  coarse.forEach(look);
  for (let i = 1; i < coarse.length; i++)
    if (text(coarse[i - 1]) !== text(coarse[i])) for (let k = coarse[i - 1] + 1; k < coarse[i]; k++) look(k);
  const below = [], mixed = [];
  let last = null;
  for (const k of sortedBy(characters.keys(), (k) => k)) {
    const [modes, isMixed] = characters.get(k), latest = mixed[mixed.length - 1];
    if (JSON.stringify(modes) !== last) below.push([tenths[k], Object.fromEntries(modes)]);
    last = JSON.stringify(modes);
    if (isMixed && latest && latest[0] - tenths[k] < COARSE + FINE) latest[0] = tenths[k];
    else if (isMixed) mixed.push([tenths[k], tenths[k]]);
  }
  return { above, below, mixed: mixed.reverse() };
}

/* The branches of weave, wobble, rider-wobble and capsize by their shapes at the naming speed. */
function namedAt(system, branches) {
  const shapes = shapesAt(system, branches, REFERENCE_SPEED), { column, upper, pair, n } = shapes;
  const motion = (start) => shapes.share(([, name]) => name.startsWith(start));
  const [steer, roll, torso] = ["steer", "roll", "torso"].map(motion), other = shapes.foreign.map((f) => f > MAJORITY);
  const inPairs = new Set(upper.flatMap(pair)), names = {};
  const all = Array.from({ length: n }, (_, i) => i), real = all.filter((i) => !inPairs.has(column[i]) && !other[i]);
  if (real.length) {
    const [capsize] = sortedBy(real, (i) => Math.hypot(shapes.re[i], shapes.im[i]));
    names.capsize = [column[capsize]];
    real.splice(real.indexOf(capsize), 1);
  }
  const pairs = upper.filter((i) => !other[i]);
  if (pairs.length) {
    const [weave] = sortedBy(pairs, (i) => -(roll[i] - steer[i]));
    names.weave = pair(weave);
    const rest = sortedBy(pairs.filter((i) => i !== weave), (i) => -steer[i] - torso[i]), hasTorso = torso.some((t) => t !== 0) ? 1 : 0;
    const front = sortedBy(rest.slice(0, 1 + hasTorso), (i) => shapes.together[i]);
    if (hasTorso && front.length === 1 && shapes.together[front[0]] > 0) {
      names.rider_wobble = pair(front[0]);
      names.wobble = sortedBy(real, (i) => -steer[i]).slice(0, 2).map((i) => column[i]);
    } else front.forEach((i, k) => (names[["wobble", "rider_wobble"][k]] = pair(i)));
    rest.slice(1 + hasTorso).forEach((i, k) => (names[`other ${k}`] = pair(i)));
  }
  const ofDevices = upper.filter((i) => other[i]).map(pair);
  all.forEach((i) => { if (other[i] && !inPairs.has(column[i])) ofDevices.push([column[i]]); });
  ofDevices.forEach((columns, k) => (names[`other of device ${k}`] = columns));
  return names;
}

/* The highest speed below the naming speed with a pair of the vehicle that has not one name, and its branches. */
function formationOfAnotherPair(system, branches, named) {
  const n = system.n, partner = Array.from({ length: n }, (_, i) => i);
  for (const [a, b] of Object.values(named).filter((c) => c.length === 2)) [partner[a], partner[b]] = [b, a];
  const apart = (s, i) => {
    const p = partner[i];
    const one = p !== i && Math.hypot(s.re[p] - s.re[i], s.im[p] + s.im[i]) <= 1e-6 * Math.hypot(s.re[i], s.im[i]);
    return s.im[i] > 0 && !one;
  };
  let formed = [];
  branches.spectra.forEach((s, k) => {
    if (branches.points[k] < REFERENCE_SPEED && partner.some((_, i) => apart(s, i))) formed.push(k);
  });
  if (!formed.length) return { formation: 0, another: [] };
  if (!Object.keys(named).some((mode) => mode.startsWith("other"))) formed = formed.slice(-1);
  for (const k of formed.reverse()) {
    const shapes = shapesAt(system, branches, branches.points[k]);
    for (const i of shapes.upper)
      if (apart(branches.spectra[k], shapes.column[i]) && shapes.foreign[i] < SHARE) return { formation: branches.points[k], another: shapes.pair(i) };
  }
  return { formation: 0, another: [] };
}

/* At a speed below the formation: [[mode, branches], ...] of the front modes, and whether they are mixed. */
function character(shapes, above) {
  const rivals = Object.entries(above).filter(([m, c]) => c.length === 2 && (m === "weave" || m.startsWith("other"))).map(([, c]) => c);
  const elsewhere = new Set(rivals.flat()), { foreign, column, tyres, together } = shapes, pairs = new Map();
  for (const i of shapes.upper) {
    const columns = shapes.pair(i);
    if (foreign[i] < SHARE || columns.some((c) => elsewhere.has(c))) pairs.set(i, columns);
  }
  const names = {};
  if (above.weave) {
    const sum = (columns) => column.reduce((total, c, i) => total + (columns.includes(c) ? foreign[i] : 0), 0);
    [names.weave] = sortedBy(rivals, sum);
  }
  const front = sortedBy([...pairs.keys()].filter((i) => !pairs.get(i).some((c) => elsewhere.has(c))), (i) => -tyres[i]);
  if (!front.length) {
    FRONT.forEach((mode) => { if (above[mode]) names[mode] = above[mode]; });
    return [Object.entries(names), false];
  }
  const ratios = front.map((i) => tyres[i]);
  if (tyres[front[0]] > 1) names.rear_wobble = pairs.get(front.shift());
  const rest = sortedBy(front, (i) => together[i]);
  if (rest.length === 1 && above.rider_wobble && (names.rear_wobble || together[rest[0]] > 0)) names.rider_wobble = pairs.get(rest[0]);
  else rest.slice(0, 2).forEach((i, k) => (names[["wobble", "rider_wobble"][k]] = pairs.get(i)));
  const used = new Set([...pairs.values()].flat()), left = FRONT.flatMap((mode) => above[mode] ?? []).filter((c) => !used.has(c));
  FRONT.forEach((mode) => { if (above[mode] && !names[mode]) names[mode] = left; });
  const isMixed = Boolean(above.rider_wobble && names.rear_wobble && ratios.length > 1 && ratios[1] > MIXED * ratios[0]);
  return [sortedByName(names), isMixed];
}

function sortedByName(names) { return Object.entries(names).sort(([a], [b]) => (a < b ? -1 : 1)); }
