/* Small dense linear algebra, matrices by rows: LU factors, and the functions phi_k of a matrix. */

#ifndef LINEAR_ALGEBRA_H
#define LINEAR_ALGEBRA_H

/* LU factors of a (n, n) in place with partial pivoting; 0 when a is singular. */
int lu_factor(double *a, unsigned *pivot, unsigned n);

/* Solves for the columns of b (n, columns) in place. */
void lu_solve(const double *lu, const unsigned *pivot, unsigned n, double *b, unsigned columns);

/* phi_0 to phi_{count-1} of a (n, n), one after the other in phi; a is overwritten.
       phi_0(a) = exp(a),   phi_{k+1}(a) = (phi_k(a) - I/k!) / a
   work has n n + n places. 0 when a is not finite or far too large for its exponential. */
int phi_functions(double *a, unsigned n, unsigned count, double *phi, double *work);

#endif
