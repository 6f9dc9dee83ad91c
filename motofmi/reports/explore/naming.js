/* Names of modes along the branches of the eigenvalues: the method of vehicle_fmu/mode_names.py and named_modes.py,
   where it is explained. A mode is a list of branches: a pair, or real roots. */

const MODES = ["weave", "wobble", "capsize", "rear_wobble", "rider_wobble"];
const FRONT = ["wobble", "rider_wobble", "rear_wobble"], OTHER = "other";
const LOWEST = 1, REFERENCE_SPEED = 60, FINE = 0.1, COARSE = 1, MIXED = 0.5, MAJORITY = 0.5, SHARE = 0.25;

/* While a slider moves: intervals of the speed are divided to 0.5 m/s, the ends of unstable speeds are found to 0.1 m/s,
   and names are looked up every 4 m/s. Of 45 random settings 2 had another eigenvalue for a mode at 1 or 2 speeds until
   the slider stopped. */
const WHILE_MOVING = { smallest: 0.5, bound: 0.1, stride: 4 };

/* The modes of a coupled system from LOWEST to REFERENCE_SPEED on a grid of FINE or COARSE steps:
   {points, spectra, curves, unstable, mixed, exchanges}. */
function namedModes(system, step = FINE) {
  const isFine = step === FINE;
  let scale; // that of the last speed is near
  const spectrum = (speed) => {
    const balanced = balance(system.matrix(speed), system.n, scale);
    scale = balanced.scale;
    return eigenvalues(balanced.B, system.n);
  };
  const first = Math.round(LOWEST / step), last = Math.round(REFERENCE_SPEED / step);
  const branches = track(spectrum, Array.from({ length: last - first + 1 }, (_, i) => step * (first + i)), ...(isFine ? [] : [2, WHILE_MOVING.smallest]));
  const { points, spectra } = branches, names = nameModes(system, branches, step), unstable = {};
  const curves = modeCurves(system, branches, names);
  for (const [mode, { re }] of Object.entries(curves)) unstable[mode] = unstableIntervals(spectrum, points, re, isFine ? undefined : WHILE_MOVING.bound);
  return { points, spectra, curves, unstable, mixed: names.mixed, exchanges: names.below.map(([speed]) => speed) };
}

function sortedBy(list, key) { return [...list].sort((a, b) => key(a) - key(b)); }

/* {distinct, above, below, mixed}: the shapes at the naming speed, the branches of each mode there, and from each speed
   in `below` downward. */
function nameModes(system, branches, step) {
  const flexible = furtherStates(system.states).includes("vehicle");
  const namingSpeed = flexible ? distinctSpeed(system, branches) : REFERENCE_SPEED, distinct = shapesAt(system, branches, namingSpeed);
  const above = namedAt(distinct), { formation, another } = formationOfAnotherPair(system, branches, above, namingSpeed);
  if (!another.length && !flexible) return { distinct, above, below: [], mixed: [] };
  const named = new Set(Object.entries(above).flatMap(([mode, columns]) => (mode.startsWith(OTHER) ? [] : columns)));
  if (another.length && !another.some((c) => named.has(c))) above.rear_wobble = another;
  const look = flexible ? flexibleCharacter : character, top = flexible ? REFERENCE_SPEED : formation;
  return { distinct, above, ...along(branches.points[0], top, step, (speed) => look(shapesAt(system, branches, speed), above)) };
}

/* The changes of names from the top speed downward, and the intervals of mixed names. */
function along(lowest, top, step, look) {
  const high = Math.floor(top / step + 1e-9), low = Math.ceil(lowest / step - 1e-9);
  const speeds = Array.from({ length: high - low + 1 }, (_, i) => step * (high - i)), stride = step === FINE ? Math.round(COARSE / step) : WHILE_MOVING.stride;
  const coarse = speeds.map((_, k) => k).filter((k) => k % stride === 0 || k === speeds.length - 1);
  const characters = new Map(), text = (k) => JSON.stringify(characters.get(k));
  coarse.forEach((k) => characters.set(k, look(speeds[k])));
  const lookAtAll = (a, b) => { for (let k = a + 1; k < b; k++) characters.set(k, look(speeds[k])); };
  const lookForChange = (a, b) => {
    if (b - a < 2) return;
    const middle = (a + b) >> 1;
    characters.set(middle, look(speeds[middle]));
    if (text(a) !== text(middle)) lookForChange(a, middle);
    else lookForChange(middle, b);
  };
  for (let i = 1; i < coarse.length; i++)
    if (text(coarse[i - 1]) !== text(coarse[i])) (step === FINE ? lookAtAll : lookForChange)(coarse[i - 1], coarse[i]);
  const below = [], mixed = [];
  let last = null;
  for (const k of sortedBy(characters.keys(), (k) => k)) {
    const [modes, isMixed] = characters.get(k), latest = mixed[mixed.length - 1];
    if (JSON.stringify(modes) !== last) below.push([speeds[k], Object.fromEntries(modes)]);
    last = JSON.stringify(modes);
    if (isMixed && latest && latest[0] - speeds[k] < COARSE + FINE) latest[0] = speeds[k];
    else if (isMixed) mixed.push([speeds[k], speeds[k]]);
  }
  return { below, mixed: mixed.reverse() };
}

/* The branches of weave, wobble, rider-wobble and capsize by their shapes at the naming speed. */
function namedAt(shapes) {
  const { column, upper, pair, n } = shapes;
  const [steer, roll, torso] = ["steer", "roll", "torso"].map(shapes.motion), other = shapes.foreign.map((f) => f > MAJORITY);
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
    rest.slice(1 + hasTorso).forEach((i, k) => (names[`${OTHER} ${k}`] = pair(i)));
  }
  const ofDevices = upper.filter((i) => other[i]).map(pair);
  all.forEach((i) => { if (other[i] && !inPairs.has(column[i])) ofDevices.push([column[i]]); });
  ofDevices.forEach((columns, k) => (names[`${OTHER} of device ${k}`] = columns));
  return names;
}

/* The highest speed below the naming speed with a pair of the vehicle that has not one name, and its branches. */
function formationOfAnotherPair(system, branches, named, namingSpeed) {
  const n = system.n, partner = Array.from({ length: n }, (_, i) => i);
  for (const [a, b] of Object.values(named).filter((c) => c.length === 2)) [partner[a], partner[b]] = [b, a];
  const apart = (s, i) => {
    const p = partner[i];
    const one = p !== i && Math.hypot(s.re[p] - s.re[i], s.im[p] + s.im[i]) <= 1e-6 * Math.hypot(s.re[i], s.im[i]);
    return s.im[i] > 0 && !one;
  };
  let formed = [];
  branches.spectra.forEach((s, k) => {
    if (branches.points[k] < namingSpeed && partner.some((_, i) => apart(s, i))) formed.push(k);
  });
  if (!formed.length) return { formation: 0, another: [] };
  if (!Object.keys(named).some((mode) => mode.startsWith(OTHER))) formed = formed.slice(-1);
  for (const k of formed.reverse()) {
    const shapes = shapesAt(system, branches, branches.points[k]);
    for (const i of shapes.upper)
      if (apart(branches.spectra[k], shapes.column[i]) && shapes.foreign[i] < SHARE) return { formation: branches.points[k], another: shapes.pair(i) };
  }
  return { formation: 0, another: [] };
}

/* At a speed below the formation: [[mode, branches], ...], and whether names are mixed. */
function character(shapes, above) {
  const rivals = Object.entries(above).filter(([m, c]) => c.length === 2 && (m === "weave" || m.startsWith(OTHER))).map(([, c]) => c);
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
