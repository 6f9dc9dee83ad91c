/* The exact step of a linear component whose inputs are polynomials in time.

       x' = A x + B u + c,   u = sum_k u_k t^k/k!
       x(h) = phi_0(hA) x + sum_k h^{k+1} phi_{k+1}(hA) B u_k + h phi_1(hA) c

   All of it is one matrix, the propagator, whose columns belong to x, u_0, 1, u_1 (and an empty one), u_2, ...
   It is kept as long as step, parameters and held inputs stay the same. */

#include <math.h>
#include <string.h>

#include "linear_algebra.h"
#include "step.h"

static int matrices_valid(const Instance *s, double h, unsigned order)
{
    if (s->matrices_order <= order || s->matrices_step != h) return 0;
    for (unsigned i = 0; model.has_held && i < model.n_inputs; i++)
        if (model.held[i] && s->matrices_held[i] != s->z[model.first_input + i]) return 0;
    return 1;
}

/* Row-wise (n, nu + 1): the columns of B, those of held inputs zero, then c = x' at x = 0 and u = 0. */
static int input_matrix(Instance *s, double *z, double *a, double *b, double *jacobian)
{
    const unsigned n = model.n_states, nu = model.n_inputs, columns = n + nu + 1;
    double *origin = b + n * (nu + 1);
    memcpy(z, s->z, model.n_values * sizeof *z);
    memset(z + model.first_state, 0, n * sizeof *z);
    for (unsigned i = 0; i < nu; i++)
        if (!model.held[i]) z[model.first_input + i] = 0;
    if (!rates_at(s, z, origin)) return 0;
    jacobian_at(s, z, origin, jacobian);
    for (unsigned i = 0; i < n; i++) {
        memcpy(a + i * n, jacobian + i * columns, n * sizeof *a);
        for (unsigned j = 0; j < nu; j++) b[i * (nu + 1) + j] = model.held[j] ? 0 : jacobian[i * columns + n + j];
        b[i * (nu + 1) + nu] = origin[i];
    }
    return 1;
}

static Status make_matrices(Instance *s, double h, unsigned order, double *work)
{
    const unsigned n = model.n_states, nu = model.n_inputs, width = nu + 1;
    double *z = work, *a = z + model.n_values + model.n_terms, *b = a + n * n, *jacobian = b + n * width + n, *scratch = jacobian;
    s->matrices_order = 0;
    if (!input_matrix(s, z, a, b, jacobian)) return report(s, DISCARD, "the mass matrix is singular at %g s", s->z[0]);
    for (unsigned i = 0; i < n * n; i++) a[i] *= h;
    if (!phi_functions(a, n, order + 2, s->phi, scratch))
        return report(s, DISCARD, "a step of %g s from %g s is too long for the fastest motion of the model", h, s->z[0]);
    for (unsigned i = 0; i < n; i++)
        for (unsigned j = 0; j < n; j++) s->propagator[j * n + i] = s->phi[i * n + j];
    double power = 1;
    for (unsigned k = 0; k <= order; k++) {
        const double *phi = s->phi + (k + 1) * n * n;
        double *columns = s->propagator + (n + k * width) * n;
        power *= h;
        for (unsigned j = 0; j < width; j++)
            for (unsigned i = 0; i < n; i++) {
                double sum = 0;
                for (unsigned l = 0; l < n; l++) sum += phi[i * n + l] * b[l * width + j];
                columns[j * n + i] = power * sum;
            }
    }
    for (unsigned i = 0; i < nu; i++) s->matrices_held[i] = s->z[model.first_input + i];
    s->matrices_step = h;
    s->matrices_order = order + 1;
    return OK;
}

/* sum += columns * factors, row by row: a sum in a register does not wait for memory from column to column. */
static void add_columns(const double *restrict columns, const double *restrict factors, unsigned count, double *restrict sum)
{
    const unsigned n = model.n_states;
    for (unsigned i = 0; i < n; i++) {
        double row = sum[i];
        for (unsigned j = 0; j < count; j++) row += columns[j * n + i] * factors[j];
        sum[i] = row;
    }
}

Status exact_step(Instance *s, double h, unsigned order, double *states)
{
    const unsigned n = model.n_states, nu = model.n_inputs, width = nu + 1;
    if (!matrices_valid(s, h, order)) {
        const Status status = make_matrices(s, h, order, states + n);
        if (status != OK) return status;
    }
    const double *columns = s->propagator, *of_one = columns + (n + nu) * n;
    for (unsigned i = 0; i < n; i++) states[i] = of_one[i];
    add_columns(columns, s->z + model.first_state, n, states);
    add_columns(columns + n * n, s->z + model.first_input, nu, states);
    for (unsigned k = 1; k <= order; k++) add_columns(columns + (n + k * width) * n, s->slopes + (k - 1) * nu, nu, states);
    return OK;
}
