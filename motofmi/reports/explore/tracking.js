/* Tracking of eigenvalues over the speed: the method of fmus/linear_analysis/eigenvalue_tracking.py. */

const SAFE_MOVE = 0.35, DIVIDED_BY = 5, SMALLEST_STEP = 5e-3, TILT = 1e-6;

/* {points, spectra}: eigenvalues over ascending points, column i of every row is branch i. An interval in which a match is
   not unique is divided. */
function track(spectrum, grid, dividedBy = DIVIDED_BY, smallest = SMALLEST_STEP) {
  const points = [grid[0]], spectra = [spectrum(grid[0])], orders = [];
  const append = (from, left, to, right) => {
    const { order, sure } = match(left, right);
    if (!sure && to - from > smallest) {
      const inner = Array.from({ length: dividedBy - 1 }, (_, i) => from + ((i + 1) * (to - from)) / dividedBy);
      const between = inner.map(spectrum), ends = [...inner, to], found = [...between, right];
      ends.forEach((end, i) => append(i ? ends[i - 1] : from, i ? found[i - 1] : left, end, found[i]));
      return;
    }
    points.push(to);
    spectra.push(right);
    orders.push(sure ? order : assignment(left, right));
  };
  for (let k = 1; k < grid.length; k++) append(grid[k - 1], spectra[spectra.length - 1], grid[k], spectrum(grid[k]));
  return { points, spectra: inBranchOrder(spectra, orders) };
}

function distance(a, i, b, j) {
  const re = a.re[i] - b.re[j], im = a.im[i] - b.im[j];
  return re * re + im * im;
}

/* The index in `right` of every eigenvalue of `left`, and whether the match is unique. */
function match(left, right) {
  const n = right.re.length, isolation = new Float64Array(n).fill(Infinity), order = new Int32Array(n);
  for (let i = 0; i < n; i++)
    for (let j = 0; j < i; j++) {
      const apart = distance(right, i, right, j);
      isolation[i] = Math.min(isolation[i], apart);
      isolation[j] = Math.min(isolation[j], apart);
    }
  let same = true;
  for (let i = 0; i < n; i++) {
    order[i] = i;
    same &&= distance(left, i, right, i) <= SAFE_MOVE ** 2 * isolation[i];
  }
  if (same) return { order, sure: true };
  const used = new Uint8Array(n);
  let sure = true;
  for (let i = 0; i < n; i++) {
    let nearest = 0, least = Infinity;
    for (let j = 0; j < n; j++) {
      const apart = distance(left, i, right, j);
      if (apart < least) [least, nearest] = [apart, j];
    }
    order[i] = nearest;
    sure &&= !used[nearest] && least <= SAFE_MOVE ** 2 * isolation[nearest];
    used[nearest] = 1;
  }
  return { order, sure };
}

/* The assignment with the least total distance: shortest augmenting paths (Jonker and Volgenant 1987). */
function assignment(before, after) {
  const left = tilted(before, -1), right = tilted(after, 1);
  const n = left.re.length, u = new Float64Array(n + 1), v = new Float64Array(n + 1), cost = new Float64Array(n * n);
  const least = new Float64Array(n + 1), done = new Uint8Array(n + 1);
  for (let i = 0; i < n; i++) for (let j = 0; j < n; j++) cost[i * n + j] = Math.sqrt(distance(left, i, right, j));
  const owner = new Int32Array(n + 1), previous = new Int32Array(n + 1);
  for (let i = 1; i <= n; i++) {
    least.fill(Infinity);
    done.fill(0);
    let column = 0;
    owner[0] = i;
    do {
      done[column] = 1;
      let delta = Infinity, next = 0;
      for (let j = 1; j <= n; j++) {
        if (done[j]) continue;
        const reduced = cost[(owner[column] - 1) * n + j - 1] - u[owner[column]] - v[j];
        if (reduced < least[j]) [least[j], previous[j]] = [reduced, column];
        if (least[j] < delta) [delta, next] = [least[j], j];
      }
      for (let j = 0; j <= n; j++) {
        if (done[j]) {
          u[owner[j]] += delta;
          v[j] -= delta;
        } else least[j] -= delta;
      }
      column = next;
    } while (owner[column]);
    while (column) {
      owner[column] = owner[previous[column]];
      column = previous[column];
    }
  }
  const order = new Int32Array(n);
  for (let j = 1; j <= n; j++) order[owner[j] - 1] = j - 1;
  return order;
}

/* Both eigenvalues of a pair have the same distance to each of two real roots: real roots that form a pair and part
   again continue as if they had passed through each other. */
function tilted({ re, im }, side) {
  return { re: re.map((r, i) => r + side * TILT * Math.sign(im[i]) * Math.hypot(r, im[i])), im };
}

function inBranchOrder(spectra, orders) {
  const n = spectra[0].re.length, sorted = new Array(spectra.length), place = new Int32Array(n), back = new Int32Array(n);
  for (let i = 0; i < n; i++) place[i] = i;
  for (let k = spectra.length - 1; k >= 0; k--) {
    const { re, im } = spectra[k], own = { re: new Float64Array(n), im: new Float64Array(n) };
    for (let i = 0; i < n; i++) {
      own.re[i] = re[place[i]];
      own.im[i] = im[place[i]];
    }
    sorted[k] = own;
    if (k === 0) break;
    for (let i = 0; i < n; i++) back[orders[k - 1][i]] = i;
    for (let i = 0; i < n; i++) place[i] = back[place[i]];
  }
  return sorted;
}

/* The intervals [from, to] in which the growth is positive, with ends refined by false position. */
function unstableIntervals(spectrum, points, growth, tolerance = 1e-2) {
  const ends = [];
  if (growth[0] > 0) ends.push(points[0]);
  for (let k = 1; k < points.length; k++)
    if (growth[k] > 0 !== growth[k - 1] > 0) ends.push(zero(spectrum, points[k - 1], points[k], growth[k - 1], growth[k], tolerance));
  if (growth[growth.length - 1] > 0) ends.push(points[points.length - 1]);
  return ends.filter((_, i) => i % 2 === 0).map((from, i) => [from, ends[2 * i + 1]]);
}

function zero(spectrum, a, b, fa, fb, tolerance) {
  while (b - a > tolerance) {
    const middle = Math.min(Math.max((a * fb - b * fa) / (fb - fa), a + tolerance / 2), b - tolerance / 2);
    const expected = fa + ((fb - fa) * (middle - a)) / (b - a);
    const value = spectrum(middle).re.reduce((best, r) => (Math.abs(r - expected) < Math.abs(best - expected) ? r : best), Infinity);
    if (value === 0) return middle;
    if (value > 0 === fa > 0) [a, fa] = [middle, value];
    else [b, fb] = [middle, value];
  }
  return (a * fb - b * fa) / (fb - fa);
}
