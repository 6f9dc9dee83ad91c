/* Derivatives with respect to variables (from the symbolic Jacobian) and to time. */

#include <math.h>
#include <string.h>

#include "instance.h"

/* Row of an unknown in the Jacobian; -1 when it has none. */
static int row_of(unsigned reference)
{
    if (reference >= model.n_variables) return -1;
    if (model.variables[reference].role == DERIVATIVE) return (int)(reference - model.first_derivative);
    for (unsigned i = 0; i < model.n_outputs; i++)
        if (model.output_references[i] == reference) return (int)(model.n_states + i);
    return -1;
}

/* Column of a known in the Jacobian; -1 when it has none. */
static int column_of(unsigned reference)
{
    if (reference >= model.n_variables) return -1;
    switch (model.variables[reference].role) {
    case STATE: return (int)(reference - model.first_state);
    case INPUT: return (int)(model.n_states + reference - model.first_input);
    case TIME: return (int)(model.n_states + model.n_inputs);
    default: return -1;
    }
}

static Status check_references(Instance *s, const unsigned *references, size_t n, int (*place)(unsigned), const char *expected)
{
    for (size_t i = 0; i < n; i++)
        if (place(references[i]) < 0)
            return report(s, ERROR, "%s (value reference %u) is no %s", references[i] < model.n_variables ? model.variables[references[i]].name : "unknown variable", references[i], expected);
    return OK;
}

static Status prepare(Instance *s, const unsigned *unknowns, size_t n_unknowns, const unsigned *knowns, size_t n_knowns)
{
    if (check_references(s, unknowns, n_unknowns, row_of, "output or derivative that could be differentiated") != OK) return ERROR;
    if (check_references(s, knowns, n_knowns, column_of, "state or input with respect to which one could differentiate") != OK) return ERROR;
    return update_jacobian(s) ? OK : report(s, ERROR, "the mass matrix is singular at %g s", s->z[0]);
}

static double entry(const Instance *s, unsigned unknown, unsigned known)
{
    return s->jacobian[(unsigned)row_of(unknown) * (model.n_states + model.n_inputs + 1) + (unsigned)column_of(known)];
}

Status directional_derivative(Instance *s, const unsigned *unknowns, size_t n_unknowns, const unsigned *knowns,
                              size_t n_knowns, const double *seed, double *sensitivity)
{
    if (prepare(s, unknowns, n_unknowns, knowns, n_knowns) != OK) return ERROR;
    for (size_t i = 0; i < n_unknowns; i++) {
        sensitivity[i] = 0;
        for (size_t j = 0; j < n_knowns; j++) sensitivity[i] += entry(s, unknowns[i], knowns[j]) * seed[j];
    }
    return OK;
}

Status adjoint_derivative(Instance *s, const unsigned *unknowns, size_t n_unknowns, const unsigned *knowns,
                          size_t n_knowns, const double *seed, double *sensitivity)
{
    if (prepare(s, unknowns, n_unknowns, knowns, n_knowns) != OK) return ERROR;
    for (size_t j = 0; j < n_knowns; j++) {
        sensitivity[j] = 0;
        for (size_t i = 0; i < n_unknowns; i++) sensitivity[j] += entry(s, unknowns[i], knowns[j]) * seed[i];
    }
    return OK;
}

int held_input_moves(const Instance *s)
{
    for (unsigned i = 0; i < model.n_inputs; i++)
        for (unsigned k = 0; model.held[i] && k < MAX_ORDER; k++)
            if (s->slopes[k * model.n_inputs + i] != 0) return 1;
    return 0;
}

static Status check_slope(Instance *s, unsigned reference, int order, double value)
{
    if (reference >= model.n_variables || model.variables[reference].role != INPUT)
        return report(s, ERROR, "value reference %u is no input: only inputs have derivatives that can be set", reference);
    const char *name = model.variables[reference].name;
    if (order < 1 || order > MAX_ORDER) return report(s, ERROR, "derivative of order %d of %s: orders 1 to %d can be set", order, name, MAX_ORDER);
    if (!isfinite(value)) return report(s, ERROR, "derivative of order %d of %s = %g is not a finite number", order, name, value);
    return OK;
}

Status set_slopes(Instance *s, const unsigned *references, size_t n, const int *orders, const double *values)
{
    const unsigned nu = model.n_inputs, first = model.first_input;
    for (size_t i = 0; i < n; i++) {
        /* Valid calls pass here; all others are examined in detail. */
        if (references[i] - first < nu && (unsigned)orders[i] - 1 < MAX_ORDER && isfinite(values[i])) continue;
        if (check_slope(s, references[i], orders[i], values[i]) != OK) return ERROR;
    }
    if (n == 0) return OK;
    if (s->kept[SLOPES] == SLOPES_OF_LAST_STEP) memset(s->slopes, 0, MAX_ORDER * nu * sizeof *s->slopes);
    for (size_t i = 0; i < n; i++) s->slopes[((unsigned)orders[i] - 1) * nu + references[i] - first] = values[i];
    s->kept[SLOPES] = SLOPES_FOR_NEXT_STEP;
    return OK;
}

/* y^(k) of the output in a row of the Jacobian (C D g_t): C x^(k) + D u^(k) + g_t, the last for k = 1. */
static double output_slope(const Instance *s, unsigned row, unsigned order, const double *x_slope)
{
    const unsigned n = model.n_states, nu = model.n_inputs;
    const double *jacobian = s->jacobian + row * (n + nu + 1), *u_slope = s->slopes + (order - 1) * nu;
    double sum = order == 1 ? jacobian[n + nu] : 0;
    for (unsigned j = 0; j < n; j++) sum += jacobian[j] * x_slope[j];
    for (unsigned j = 0; j < nu; j++) sum += jacobian[n + j] * u_slope[j];
    return sum;
}

Status get_slopes(Instance *s, const unsigned *references, size_t n, const int *orders, double *values)
{
    const unsigned nx = model.n_states;
    for (size_t i = 0; i < n; i++) {
        if (references[i] >= model.n_variables || row_of(references[i]) < (int)nx)
            return report(s, ERROR, "value reference %u is no output: only outputs have derivatives that can be read", references[i]);
        if (orders[i] < 1 || orders[i] > (int)model.output_order)
            return report(s, ERROR, "derivative of order %d of %s: orders 1 to %u can be read", orders[i], model.variables[references[i]].name, model.output_order);
    }
    for (size_t i = 0; i < n; i++)
        if (orders[i] > 1 && held_input_moves(s))
            return report(s, DISCARD, "derivative of order %d of %s: not while the inputs that must be held move", orders[i], model.variables[references[i]].name);
    if (!update_jacobian(s)) return report(s, ERROR, "the mass matrix is singular at %g s", s->z[0]);
    double *x_slope = s->work, *next = x_slope + nx;
    if (nx > 0) memcpy(x_slope, s->z + model.first_derivative, nx * sizeof *x_slope);
    for (unsigned order = 1; order <= model.output_order; order++) {
        for (size_t i = 0; i < n; i++)
            if (orders[i] == (int)order) values[i] = output_slope(s, (unsigned)row_of(references[i]), order, x_slope);
        for (unsigned i = 0; i < nx; i++) { /* x^(k+1) = A x^(k) + B u^(k), a row of the Jacobian like any other */
            next[i] = output_slope(s, i, order, x_slope);
        }
        if (nx > 0) memcpy(x_slope, next, nx * sizeof *x_slope);
    }
    return OK;
}
