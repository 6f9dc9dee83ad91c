/* Names of the modes of a vehicle with further freedoms (twist of head and frame, a rider who rolls): the method of
   vehicle_fmu/flexible_mode_names.py, where it is explained. */

const NAMING_STEP = 5, NAMING_LOWEST = 30; // m/s: between speeds at which modes may be named, and the lowest of them

/* Of the speeds in steps below the reference speed the one at which every pair is most clearly one of further states or
   none of them. */
function distinctSpeed(system, branches) {
  const speeds = Array.from({ length: (REFERENCE_SPEED - NAMING_LOWEST) / NAMING_STEP + 1 }, (_, i) => REFERENCE_SPEED - NAMING_STEP * i);
  return sortedBy(speeds, (speed) => {
    const { foreign, upper } = shapesAt(system, branches, speed);
    return Math.max(...upper.map((i) => Math.min(foreign[i], 1 - foreign[i])));
  })[0];
}

/* [[mode, branches], ...] at a speed, and whether names are mixed. */
function flexibleCharacter(shapes, above) {
  const { foreign, column, upper } = shapes, [roll, steer] = ["roll", "steer"].map(shapes.motion), excess = roll.map((r, i) => r - steer[i]);
  const part = (of, columns) => Math.max(-1, ...column.map((c, i) => (columns.includes(c) ? of[i] : -1)));
  const names = Object.fromEntries(FRONT.filter((mode) => above[mode]).map((mode) => [mode, above[mode]]));
  if (names.wobble?.length === 2) {
    const others = Object.entries(above).filter(([mode, c]) => c.length === 2 && mode.startsWith(OTHER)).map(([, c]) => c);
    const rivals = others.filter((c) => c.every((one) => column.includes(one)) && part(excess, c) < 0);
    [names.wobble] = sortedBy([names.wobble, ...rivals], (c) => part(foreign, c));
  }
  Object.assign(names, slowModes(shapes, roll, excess, above.weave ?? []));
  if (names.rear_wobble && above.weave?.length === 2 && !sameBranches(names.weave, above.weave)) names.rear_wobble = above.weave;
  const slow = [...names.weave, ...names.capsize];
  for (const mode of FRONT)
    if (names[mode]?.length && (part(foreign, names[mode]) > MAJORITY || names[mode].some((c) => slow.includes(c)))) names[mode] = [];
  const [first, second] = sortedBy(upper.map((i) => excess[i]), (e) => -e);
  return [sortedByName(names), second > MIXED * first && MIXED * first > 0];
}

/* The branches of weave and capsize, from the branch of weave at the naming speed. */
function slowModes({ foreign, column, upper, pair, re, im, n }, roll, excess, branch) {
  const pairs = upper.filter((i) => foreign[i] <= MAJORITY), mean = roll.reduce((a, b) => a + b, 0) / n;
  const real = sortedBy(Array.from({ length: n }, (_, i) => i).filter((i) => im[i] === 0), (i) => -roll[i]);
  const [weave] = sortedBy(pairs, (i) => -roll[i] - Math.min(excess[i], 0));
  if (weave !== undefined) {
    const kept = sameBranches(pair(weave), branch), rival = real[kept ? 2 : 1];
    const least = Math.max(mean / 2, rival === undefined ? 0 : roll[rival]);
    if ((kept && excess[weave] > 0) || real.length < 3 || roll[weave] > least)
      return { weave: pair(weave), capsize: real.slice(0, 1).map((i) => column[i]) };
  }
  const columns = sortedBy(real.slice(0, 3), (i) => -re[i]).map((i) => column[i]);
  return { weave: columns.slice(0, 2), capsize: columns.slice(2) };
}

function sameBranches(a, b) { return a.length === b.length && a.every((c) => b.includes(c)); }
