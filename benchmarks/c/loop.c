/* The loop of an importer in C: set inputs, step, get outputs, through function pointers; and two FMUs to compare with.

   `bare` does the arithmetic of a linear component's step and outputs and nothing else, `empty` does nothing. Both are
   called as an FMU is. It knows the component's equations as the FMU does. */

#include "fmi2Functions.h"
#include "model.c"
#include "variables.c"

void loop(fmi2SetRealTYPE *set, fmi2DoStepTYPE *step, fmi2GetRealTYPE *get, fmi2Component c, const unsigned *inputs, unsigned n_inputs,
          const unsigned *outputs, unsigned n_outputs, double *values, double h, double start, long steps)
{
    for (long i = 0; i < steps; i++) {
        for (unsigned j = 0; j < n_inputs; j++) values[j] += (i & 1) ? 1e-3 : -1e-3;
        set(c, inputs, n_inputs, values);
        step(c, start + (double)i * h, h, 1);
        get(c, outputs, n_outputs, values + n_inputs);
    }
}

typedef struct {
    double *z, *columns; /* of x, u and 1, each of n_states */
} Bare;

fmi2Status bare_set(fmi2Component c, const fmi2ValueReference vr[], size_t n, const fmi2Real values[])
{
    const Bare *b = c;
    for (size_t i = 0; i < n; i++) b->z[vr[i]] = values[i];
    return fmi2OK;
}

static void add_columns(const double *restrict columns, const double *restrict factors, unsigned count, double *restrict sum)
{
    const unsigned n = model.n_states;
    for (unsigned j = 0; j < count; j++)
        for (unsigned i = 0; i < n; i++) sum[i] += columns[j * n + i] * factors[j];
}

fmi2Status bare_step(fmi2Component c, fmi2Real time, fmi2Real h, fmi2Boolean no_set)
{
    const Bare *b = c;
    const unsigned n = model.n_states, nu = model.n_inputs;
    double *x = b->z + model.first_state, next[64];
    (void)no_set;
    for (unsigned i = 0; i < n; i++) next[i] = b->columns[(n + nu) * n + i];
    add_columns(b->columns, x, n, next);
    add_columns(b->columns + n * n, b->z + model.first_input, nu, next);
    for (unsigned i = 0; i < n; i++) x[i] = next[i];
    b->z[0] = time + h;
    return fmi2OK;
}

fmi2Status bare_get(fmi2Component c, const fmi2ValueReference vr[], size_t n, fmi2Real values[])
{
    const Bare *b = c;
    model.terms(b->z);
    model.outputs(b->z);
    for (size_t i = 0; i < n; i++) values[i] = b->z[vr[i]];
    return fmi2OK;
}

void bare_parameters(Bare *b) { model.parameters(b->z); }

fmi2Status empty_set(fmi2Component c, const fmi2ValueReference vr[], size_t n, const fmi2Real values[])
{
    (void)c, (void)vr, (void)n, (void)values;
    return fmi2OK;
}

fmi2Status empty_step(fmi2Component c, fmi2Real time, fmi2Real h, fmi2Boolean no_set)
{
    (void)c, (void)time, (void)h, (void)no_set;
    return fmi2OK;
}

fmi2Status empty_get(fmi2Component c, const fmi2ValueReference vr[], size_t n, fmi2Real values[])
{
    (void)c, (void)vr, (void)n, (void)values;
    return fmi2OK;
}
