/* Small dense linear algebra: see linear_algebra.h. */

#include <math.h>
#include <string.h>

#include "linear_algebra.h"

int lu_factor(double *a, unsigned *pivot, unsigned n)
{
    for (unsigned k = 0; k < n; k++) {
        unsigned p = k;
        for (unsigned i = k + 1; i < n; i++)
            if (fabs(a[i * n + k]) > fabs(a[p * n + k])) p = i;
        pivot[k] = p;
        if (!(fabs(a[p * n + k]) > 0) || !isfinite(a[p * n + k])) return 0;
        if (p != k)
            for (unsigned j = 0; j < n; j++) {
                const double kept = a[k * n + j];
                a[k * n + j] = a[p * n + j];
                a[p * n + j] = kept;
            }
        for (unsigned i = k + 1; i < n; i++) {
            if (a[i * n + k] == 0) continue;
            const double factor = a[i * n + k] /= a[k * n + k];
            for (unsigned j = k + 1; j < n; j++) a[i * n + j] -= factor * a[k * n + j];
        }
    }
    return 1;
}

/* Row i of b less a factor times row j; most factors of a mass matrix with many rows of the identity are 0. */
static void subtract(double *restrict row, const double *restrict other, double factor, unsigned columns)
{
    if (factor == 0) return;
    for (unsigned c = 0; c < columns; c++) row[c] -= factor * other[c];
}

void lu_solve(const double *lu, const unsigned *pivot, unsigned n, double *b, unsigned columns)
{
    for (unsigned k = 0; k < n; k++) {
        if (pivot[k] == k) continue;
        for (unsigned c = 0; c < columns; c++) {
            const double kept = b[pivot[k] * columns + c];
            b[pivot[k] * columns + c] = b[k * columns + c];
            b[k * columns + c] = kept;
        }
    }
    for (unsigned i = 1; i < n; i++)
        for (unsigned j = 0; j < i; j++) subtract(b + i * columns, b + j * columns, lu[i * n + j], columns);
    for (unsigned i = n; i-- > 0;) {
        for (unsigned j = i + 1; j < n; j++) subtract(b + i * columns, b + j * columns, lu[i * n + j], columns);
        for (unsigned c = 0; c < columns; c++) b[i * columns + c] /= lu[i * n + i];
    }
}

static void multiply(const double *a, const double *b, double *c, unsigned n)
{
    memset(c, 0, n * n * sizeof *c);
    for (unsigned i = 0; i < n; i++)
        for (unsigned k = 0; k < n; k++) {
            const double factor = a[i * n + k];
            for (unsigned j = 0; j < n; j++) c[i * n + j] += factor * b[k * n + j];
        }
}

/* Similarity with powers of two that makes rows and columns alike in size: exact, and it keeps forces and
   angles from forcing needless squarings. Parlett, Reinsch, Numer. Math. 13 (1969) 293-304. */
static void balance(double *a, unsigned n, double *scale)
{
    for (unsigned i = 0; i < n; i++) scale[i] = 1;
    for (int sweep = 0; sweep < 20; sweep++) {
        int changed = 0;
        for (unsigned i = 0; i < n; i++) {
            double row = 0, column = 0;
            for (unsigned j = 0; j < n; j++)
                if (j != i) row += fabs(a[i * n + j]), column += fabs(a[j * n + i]);
            if (row == 0 || column == 0 || !isfinite(row / column)) continue;
            const double factor = ldexp(1, (int)floor(0.5 * log2(row / column) + 0.5));
            if (factor == 1) continue;
            changed = 1;
            scale[i] *= factor;
            for (unsigned j = 0; j < n; j++) {
                a[i * n + j] /= factor;
                a[j * n + i] *= factor;
            }
        }
        if (!changed) return;
    }
}

static double largest_column_sum(const double *a, unsigned n)
{
    double largest = 0;
    for (unsigned j = 0; j < n; j++) {
        double sum = 0;
        for (unsigned i = 0; i < n; i++) sum += fabs(a[i * n + j]);
        if (!(sum <= largest)) largest = sum;
    }
    return largest;
}

static void add_identity(double *a, unsigned n, double factor)
{
    for (unsigned i = 0; i < n; i++) a[i * n + i] += factor;
}

/* Taylor series of the last phi for a small matrix, the others by phi_k = I/k! + a phi_{k+1}, then doubling:
       phi_k(2a) = 2^-k (phi_0(a) phi_k(a) + sum_{j=1..k} phi_j(a) / (k - j)!)
   Skaflestad, Wright, Appl. Numer. Math. 59 (2009) 783-799. */
int phi_functions(double *a, unsigned n, unsigned count, double *phi, double *work)
{
    enum { TERMS = 14 }; /* norm at most 1/2: the first term left out is below 1e-17 of the sum */
    const unsigned size = n * n;
    double *scale = work + size;
    double factorial[TERMS + 6] = {1};
    for (unsigned k = 1; k < TERMS + 6; k++) factorial[k] = k * factorial[k - 1];
    if (!isfinite(largest_column_sum(a, n))) return 0;
    balance(a, n, scale);
    const double norm = largest_column_sum(a, n);
    if (norm > 1e6) return 0;
    int doublings = 0;
    while (ldexp(norm, -doublings) > 0.5) doublings++;
    for (unsigned i = 0; i < size; i++) a[i] = ldexp(a[i], -doublings);

    double *last = phi + (count - 1) * size;
    memset(last, 0, size * sizeof *last);
    for (unsigned term = TERMS + 1; term-- > 0;) {
        multiply(a, last, work, n);
        memcpy(last, work, size * sizeof *last);
        add_identity(last, n, 1 / factorial[term + count - 1]);
    }
    for (unsigned k = count - 1; k-- > 0;) {
        multiply(a, phi + (k + 1) * size, phi + k * size, n);
        add_identity(phi + k * size, n, 1 / factorial[k]);
    }
    while (doublings-- > 0)
        for (unsigned k = count; k-- > 0;) {
            double *p = phi + k * size;
            multiply(phi, p, work, n);
            for (unsigned j = 1; j <= k; j++)
                for (unsigned i = 0; i < size; i++) work[i] += phi[j * size + i] / factorial[k - j];
            for (unsigned i = 0; i < size; i++) p[i] = ldexp(work[i], -(int)k);
        }
    for (unsigned k = 0; k < count; k++)
        for (unsigned i = 0; i < n; i++)
            for (unsigned j = 0; j < n; j++) phi[k * size + i * n + j] *= scale[i] / scale[j];
    return 1;
}
