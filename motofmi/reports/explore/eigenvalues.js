/* Eigenvalues alone, which a slider needs at hundreds of speeds: five times faster than with ml-matrix, which computes
   the vectors as well. Hessenberg form by reflections, then the QR steps of Francis with double shift
   (Golub, Van Loan, Matrix Computations, sect. 7.4 and 7.5; Wilkinson, Reinsch 1971, contribution II/14). */

const EPSILON = 2 ** -52;

/* A (n, n) in rows is overwritten. {re, im}, complex pairs adjacent with the positive imaginary part first. */
function eigenvalues(A, n) {
  toHessenberg(A, n);
  const re = new Float64Array(n), im = new Float64Array(n);
  let last = n - 1, shift = 0, rounds = 0;
  while (last >= 0) {
    const first = smallSubdiagonal(A, n, last), end = last * n + last;
    if (first === last) {
      re[last--] = A[end] + shift;
      rounds = 0;
    } else if (first === last - 1) {
      ofTwo(A, n, last, shift, re, im);
      last -= 2;
      rounds = 0;
    } else {
      if (++rounds > 60) return { re: re.fill(NaN), im };
      if (rounds % 10 === 0) {
        shift = exceptional(A, n, last, shift);
        const size = Math.abs(A[end - 1]) + Math.abs(A[end - n - 2]);
        francis(A, n, first, last, 0.75 * size, 0.75 * size, -0.4375 * size * size);
      } else francis(A, n, first, last, A[end], A[end - n - 1], A[end - 1] * A[end - n]);
    }
  }
  return { re, im };
}

/* Reflections I - beta v v^T from both sides, one for each column. They give the order of the eigenvalues that LAPACK
   gives, by which equal distances in the tracking are decided. */
function toHessenberg(A, n) {
  const v = new Float64Array(n);
  for (let k = 0; k < n - 2; k++) {
    let square = 0;
    for (let i = k + 2; i < n; i++) square += A[i * n + k] ** 2;
    if (square === 0) continue;
    const alpha = A[(k + 1) * n + k], norm = Math.sqrt(alpha * alpha + square), head = alpha > 0 ? -norm : norm;
    v[k + 1] = 1;
    for (let i = k + 2; i < n; i++) v[i] = A[i * n + k] / (alpha - head);
    const beta = (head - alpha) / head;
    for (let j = k; j < n; j++) {
      let sum = 0;
      for (let i = k + 1; i < n; i++) sum += v[i] * A[i * n + j];
      for (let i = k + 1; i < n; i++) A[i * n + j] -= beta * sum * v[i];
    }
    for (let i = 0; i < n; i++) {
      let sum = 0;
      for (let j = k + 1; j < n; j++) sum += A[i * n + j] * v[j];
      for (let j = k + 1; j < n; j++) A[i * n + j] -= beta * sum * v[j];
    }
    for (let i = k + 2; i < n; i++) A[i * n + k] = 0;
  }
}

/* The first row of the last block that does not decouple. */
function smallSubdiagonal(A, n, last) {
  for (let i = last; i > 0; i--) {
    const around = Math.abs(A[(i - 1) * n + i - 1]) + Math.abs(A[i * n + i]);
    if (Math.abs(A[i * n + i - 1]) <= EPSILON * around) {
      A[i * n + i - 1] = 0;
      return i;
    }
  }
  return 0;
}

/* The eigenvalues of the last two rows and columns. */
function ofTwo(A, n, last, shift, re, im) {
  const end = last * n + last, x = A[end], half = (A[end - n - 1] - x) / 2, product = A[end - 1] * A[end - n], square = half * half + product;
  const root = Math.sqrt(Math.abs(square)), i = last - 1;
  if (square >= 0) {
    const far = half + (half < 0 ? -root : root);
    re[i] = x + far + shift;
    re[last] = far === 0 ? re[i] : x - product / far + shift;
    im[i] = im[last] = 0;
  } else {
    re[i] = re[last] = x + half + shift;
    im[i] = root;
    im[last] = -root;
  }
}

/* A shift of all eigenvalues where the usual ones do not converge. */
function exceptional(A, n, last, shift) {
  const by = A[last * n + last];
  for (let i = 0; i <= last; i++) A[i * n + i] -= by;
  return shift + by;
}

/* One double step with the shifts of sum x + y and product x y - w, by reflections of three rows and columns. */
function francis(A, n, first, last, x, y, w) {
  let m = last - 2, p = 0, q = 0, r = 0;
  for (; m >= first; m--) {
    const at = m * n + m, z = A[at], a = x - z, b = y - z, c = A[at + n];
    p = (a * b - w) / c + A[at + 1];
    q = A[at + n + 1] - z - a - b;
    r = A[at + 2 * n + 1];
    const size = Math.abs(p) + Math.abs(q) + Math.abs(r);
    p /= size;
    q /= size;
    r /= size;
    if (m === first) break;
    const before = Math.abs(A[at - 1]) * (Math.abs(q) + Math.abs(r));
    if (before <= EPSILON * Math.abs(p) * (Math.abs(A[at - n - 1]) + Math.abs(z) + Math.abs(A[at + n + 1]))) break;
  }
  for (let i = m + 2; i <= last; i++) {
    A[i * n + i - 2] = 0;
    if (i > m + 2) A[i * n + i - 3] = 0;
  }
  for (let k = m; k < last; k++) {
    const three = k < last - 1, at = k * n + k;
    let size = 1;
    if (k !== m) {
      p = A[at - 1];
      q = A[at + n - 1];
      r = three ? A[at + 2 * n - 1] : 0;
      size = Math.abs(p) + Math.abs(q) + Math.abs(r);
      if (size === 0) continue;
      p /= size;
      q /= size;
      r /= size;
    }
    const norm = Math.sqrt(p * p + q * q + r * r), s = p < 0 ? -norm : norm;
    if (k !== m) A[at - 1] = -s * size;
    else if (first !== m) A[at - 1] = -A[at - 1];
    p += s;
    const u = p / s, v = q / s, t = r / s;
    q /= p;
    r /= p;
    for (let j = k; j < n; j++) {
      const here = k * n + j, sum = A[here] + q * A[here + n] + (three ? r * A[here + 2 * n] : 0);
      A[here] -= sum * u;
      A[here + n] -= sum * v;
      if (three) A[here + 2 * n] -= sum * t;
    }
    const bottom = Math.min(last, k + 3);
    for (let i = 0; i <= bottom; i++) {
      const here = i * n + k, sum = u * A[here] + v * A[here + 1] + (three ? t * A[here + 2] : 0);
      A[here] -= sum;
      A[here + 1] -= sum * q;
      if (three) A[here + 2] -= sum * r;
    }
  }
}
