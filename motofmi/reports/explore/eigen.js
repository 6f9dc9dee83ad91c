/* Eigenvalues and eigenvectors of real matrices (n, n) in rows, with ml-matrix (MIT licence) after balancing.

   Balancing scales the states by powers of two until rows and columns have similar norms (Parlett and Reinsch 1969), as
   LAPACK does: forces in newtons stand beside angles in radians. */

/* {B, scale}: scale D from a guess, B = D^-1 A D. */
function balance(A, n, guess) {
  const scale = guess ? Float64Array.from(guess) : new Float64Array(n).fill(1), B = Float64Array.from(A);
  if (guess) for (let i = 0; i < n; i++) for (let j = 0; j < n; j++) B[i * n + j] *= scale[j] / scale[i];
  for (let changed = true; changed; ) {
    changed = false;
    for (let i = 0; i < n; i++) {
      let column = 0, row = 0;
      for (let j = 0; j < n; j++) if (j !== i) {
        column += Math.abs(B[j * n + i]);
        row += Math.abs(B[i * n + j]);
      }
      if (!column || !row) continue;
      const factor = 2 ** Math.round(Math.log2(row / column) / 2);
      if (column * factor + row / factor >= 0.95 * (column + row)) continue;
      changed = true;
      scale[i] *= factor;
      for (let j = 0; j < n; j++) {
        B[i * n + j] /= factor;
        B[j * n + i] *= factor;
      }
    }
  }
  return { B, scale };
}

/* {re, im, vectorRe, vectorIm}: eigenvalues, complex pairs adjacent with the positive imaginary part first, and the
   eigenvectors (n, n) in columns. */
function eigen(A, n) {
  const { B, scale } = balance(A, n), rows = [];
  for (let i = 0; i < n; i++) rows.push(B.subarray(i * n, (i + 1) * n));
  const found = new mlMatrix.EigenvalueDecomposition(rows, { assumeSymmetric: false });
  const re = Float64Array.from(found.realEigenvalues), im = Float64Array.from(found.imaginaryEigenvalues);
  const V = found.eigenvectorMatrix, vectorRe = new Float64Array(n * n), vectorIm = new Float64Array(n * n);
  for (let j = 0; j < n; j++) {
    const lower = im[j] < 0, first = lower ? j - 1 : j;
    for (let i = 0; i < n; i++) {
      vectorRe[i * n + j] = scale[i] * V.get(i, first);
      if (im[j] !== 0) vectorIm[i * n + j] = scale[i] * V.get(i, first + 1) * (lower ? -1 : 1);
    }
  }
  return { re, im, vectorRe, vectorIm };
}

/* |(V^-1)^T o V|, the share of every state (row) in every mode (column), not normalised. */
function participation(shapes, n) {
  const inverse = complexInverse(shapes.vectorRe, shapes.vectorIm, n), part = new Float64Array(n * n);
  for (let i = 0; i < n; i++)
    for (let j = 0; j < n; j++) {
      const left = 2 * (j * n + i), right = i * n + j;
      part[right] = Math.hypot(inverse[left], inverse[left + 1]) * Math.hypot(shapes.vectorRe[right], shapes.vectorIm[right]);
    }
  return part;
}

/* The inverse by Gauss-Jordan elimination with row pivots, real and imaginary parts interleaved. */
function complexInverse(re, im, n) {
  const w = 2 * n, a = new Float64Array(2 * n * w);
  for (let i = 0; i < n; i++) {
    for (let j = 0; j < n; j++) {
      a[2 * (i * w + j)] = re[i * n + j];
      a[2 * (i * w + j) + 1] = im[i * n + j];
    }
    a[2 * (i * w + n + i)] = 1;
  }
  for (let k = 0; k < n; k++) {
    let pivot = k;
    const size = (i) => Math.hypot(a[2 * (i * w + k)], a[2 * (i * w + k) + 1]);
    for (let i = k + 1; i < n; i++) if (size(i) > size(pivot)) pivot = i;
    if (pivot !== k)
      for (let j = 0; j < 2 * w; j++) [a[2 * k * w + j], a[2 * pivot * w + j]] = [a[2 * pivot * w + j], a[2 * k * w + j]];
    const pr = a[2 * (k * w + k)], pi = a[2 * (k * w + k) + 1], square = pr * pr + pi * pi;
    for (let j = 0; j < w; j++) {
      const at = 2 * (k * w + j), r = a[at], m = a[at + 1];
      a[at] = (r * pr + m * pi) / square;
      a[at + 1] = (m * pr - r * pi) / square;
    }
    for (let i = 0; i < n; i++) {
      const fr = a[2 * (i * w + k)], fi = a[2 * (i * w + k) + 1];
      if (i === k || (fr === 0 && fi === 0)) continue;
      for (let j = k; j < w; j++) {
        const at = 2 * (i * w + j), from = 2 * (k * w + j);
        a[at] -= fr * a[from] - fi * a[from + 1];
        a[at + 1] -= fr * a[from + 1] + fi * a[from];
      }
    }
  }
  const inverse = new Float64Array(2 * n * n);
  for (let i = 0; i < n; i++) inverse.set(a.subarray(2 * (i * w + n), 2 * (i + 1) * w), 2 * i * n);
  return inverse;
}
