/* One step: selects the method, and stores its result only when it is valid. */

#include <math.h>
#include <string.h>

#include "step.h"

/* u(tau) = u + u' tau + u'' tau^2/2 + u''' tau^3/6 */
void inputs_after(const Instance *s, double tau, double *z)
{
    const unsigned n = model.n_inputs;
    const double *u = s->z + model.first_input, *d = s->slopes;
    for (unsigned i = 0; i < n; i++)
        z[model.first_input + i] = u[i] + tau * (d[i] + tau / 2 * (d[n + i] + tau / 3 * d[2 * n + i]));
}

/* The slopes at the end of the step, used for the outputs' derivatives until the next step. */
static void advance_slopes(Instance *s, double tau)
{
    const unsigned n = model.n_inputs;
    for (unsigned i = 0; i < n; i++) {
        double *d = s->slopes + i;
        d[0] += tau * (d[n] + tau / 2 * d[2 * n]);
        d[n] += tau * d[2 * n];
    }
}

static unsigned polynomial_order(const Instance *s)
{
    for (unsigned order = MAX_ORDER; order > 0; order--)
        for (unsigned i = 0; i < model.n_inputs; i++)
            if (s->slopes[(order - 1) * model.n_inputs + i] != 0) return order;
    return 0;
}

/* An input polynomial may exceed the bounds of its variable within the step; only its end is checked. */
static Status inputs_in_bounds(Instance *s, double h)
{
    for (unsigned i = 0; i < model.n_inputs; i++) {
        const Variable *v = &model.variables[model.first_input + i];
        const double *d = s->slopes + i, *u = s->z + model.first_input + i;
        const double end = *u + h * (d[0] + h / 2 * (d[model.n_inputs] + h / 3 * d[2 * model.n_inputs]));
        if (!(end >= v->min && end <= v->max && isfinite(end)))
            return report(s, DISCARD, "%s = %g %s at the end of the step is outside [%g, %g]", v->name, end, v->unit, v->min, v->max);
    }
    return OK;
}

/* Rounding errors of the importer's time are accepted, a gap or an overlap is not. */
Status check_step(Instance *s, double time, double h)
{
    if (!(h > 0) || !isfinite(h)) return report(s, ERROR, "a step of %g s: it must be positive and finite", h);
    if (!(fabs(time - s->z[0]) <= 1e-9 * (fabs(time) + 1) + 1e-3 * h))
        return report(s, ERROR, "a step from %g s, but the instance is at %g s", time, s->z[0]);
    if (time + h > s->kept[STOP_TIME] + 1e-9 * (fabs(time) + 1) + 1e-3 * h)
        return report(s, ERROR, "a step to %g s, but the stop time is %g s", time + h, s->kept[STOP_TIME]);
    return OK;
}

Status states_in_bounds(Instance *s, double time, const double *states)
{
    for (unsigned i = 0; i < model.n_states; i++) {
        const Variable *v = &model.variables[model.first_state + i];
        if (states[i] >= v->min && states[i] <= v->max) continue; /* false for infinity and NaN */
        if (!isfinite(states[i])) return report(s, DISCARD, "%s is no longer finite at %g s", v->name, time);
        return report(s, DISCARD, "%s = %g %s at %g s is outside its bounds [%g, %g]", v->name, states[i], v->unit, time, v->min, v->max);
    }
    return OK;
}

Status step_from(Instance *s, double time, double h)
{
    if (check_step(s, time, h) != OK) return ERROR;
    const unsigned n = model.n_states;
    double *states = s->work;
    if (s->parameters_changed) update_outputs(s);
    if (s->kept[SLOPES] == SLOPES_OF_LAST_STEP) {
        memset(s->slopes, 0, MAX_ORDER * model.n_inputs * sizeof *s->slopes);
        s->kept[SLOPES] = NO_SLOPES;
    }
    const unsigned order = s->kept[SLOPES] == NO_SLOPES ? 0 : polynomial_order(s);
    if (order > 0 && inputs_in_bounds(s, h) != OK) return DISCARD;
    if (n > 0) {
        const int exact = model.exact && !(order > 0 && held_input_moves(s));
        const Status status = exact ? exact_step(s, h, order, states) : rosenbrock_step(s, h, states);
        if (status != OK) return status;
        if (states_in_bounds(s, time + h, states) != OK) return DISCARD;
        for (unsigned i = 0; i < n; i++) s->z[model.first_state + i] = states[i];
    }
    if (order > 0) {
        inputs_after(s, h, s->z);
        advance_slopes(s, h);
        s->kept[SLOPES] = SLOPES_OF_LAST_STEP;
    }
    s->z[0] = time + h;
    values_changed(s, 0);
    return OK;
}
