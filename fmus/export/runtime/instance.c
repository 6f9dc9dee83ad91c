/* One instance of the model: see instance.h. */

#include <math.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "instance.h"
#include "linear_algebra.h"
#include "snapshot.h"

static size_t work_size(void)
{
    const size_t n = model.n_states, nu = model.n_inputs, columns = n + nu + 1;
    return model.n_values + model.n_terms + (n + model.n_outputs) * columns + 2 * n * n + n * columns + 16 * n + 4 * nu;
}

Instance *instance_new(const char *name, Logger *logger, void *host)
{
    const size_t n = model.n_states, nu = model.n_inputs;
    Instance *s = calloc(1, sizeof *s);
    if (!s) return NULL;
    s->n_kept = N_SCALARS + model.n_values + MAX_ORDER * model.n_inputs;
    s->kept = calloc(s->n_kept + model.n_terms, sizeof *s->kept);
    s->jacobian = calloc((n + model.n_outputs) * (n + nu + 1) + 1, sizeof(double));
    s->lu = calloc(n * n + 1, sizeof(double));
    s->pivot = calloc(2 * n + 1, sizeof *s->pivot);
    s->work = calloc(work_size() + 1, sizeof(double));
    s->phi = calloc((MAX_ORDER + 2) * n * n + 1, sizeof(double));
    s->propagator = calloc(n * (n + (MAX_ORDER + 1) * (nu + 1)) + 1, sizeof(double));
    s->matrices_held = calloc(nu + 1, sizeof(double));
    s->name = malloc(strlen(name) + 1);
    if (!s->kept || !s->jacobian || !s->lu || !s->pivot || !s->work || !s->phi || !s->propagator || !s->matrices_held || !s->name) {
        instance_free(s);
        return NULL;
    }
    strcpy(s->name, name);
    s->slopes = s->kept + N_SCALARS;
    s->z = s->slopes + MAX_ORDER * model.n_inputs;
    s->logger = logger;
    s->host = host;
    instance_reset(s);
    return s;
}

void instance_free(Instance *s)
{
    while (s->snapshots) snapshot_free(s, s->snapshots);
    free(s->kept);
    free(s->jacobian);
    free(s->lu);
    free(s->pivot);
    free(s->work);
    free(s->phi);
    free(s->propagator);
    free(s->matrices_held);
    free(s->name);
    free(s);
}

void instance_reset(Instance *s)
{
    memset(s->kept, 0, s->n_kept * sizeof *s->kept);
    for (unsigned i = 0; i < model.n_variables; i++) s->z[i] = model.variables[i].start;
    s->kept[STOP_TIME] = HUGE_VAL;
    enter(s, INSTANTIATED);
    values_changed(s, 1);
}

Status report(Instance *s, Status status, const char *format, ...)
{
    char message[512];
    va_list arguments;
    va_start(arguments, format);
    vsnprintf(message, sizeof message, format, arguments);
    va_end(arguments);
    for (char *c = message; *c; c++) /* importers may use the message as a format string */
        if (*c == '%') *c = '/';
    s->logger(s, status, message);
    if (status == ERROR) enter(s, FAILED);
    return status;
}

Phase phase(const Instance *s) { return (Phase)s->kept[PHASE]; }

void enter(Instance *s, Phase new_phase) { s->kept[PHASE] = new_phase; }

void values_changed(Instance *s, int parameters)
{
    s->rates_changed = s->outputs_changed = s->jacobian_changed = 1;
    if (parameters) {
        s->parameters_changed = 1;
        s->matrices_order = 0;
        s->kept[INNER_STEP] = 0;
    }
}

/* The reason why this variable may not be set now; NULL when it may. */
static const char *refusal(const Instance *s, const Variable *v)
{
    const int starting = phase(s) & (INSTANTIATED | INITIALIZING);
    switch (v->role) {
    case TIME: return "is the time, which the steps set";
    case FIXED: return starting ? NULL : "is a fixed parameter: it can be set only before initialisation is over";
    case TUNABLE: return starting || phase(s) & (STEPPING | EVENT) ? NULL : "is a tunable parameter: it can be set only between steps and at events";
    case INPUT: return phase(s) == TERMINATED ? "cannot be set after termination" : NULL;
    case STATE: return starting ? NULL : "is a state: it can be set only before initialisation is over";
    default: return "is calculated and cannot be set";
    }
}

/* False for NaN; infinity exceeds every bound. */
static int within(const Variable *v, double value) { return value >= v->min && value <= v->max; }

static Status check_value(Instance *s, unsigned reference, double value)
{
    if (reference >= model.n_variables) return report(s, ERROR, "there is no variable with value reference %u (valid: 0 to %u)", reference, model.n_variables - 1);
    const Variable *v = &model.variables[reference];
    const char *reason = refusal(s, v);
    if (reason) return report(s, ERROR, "%s %s", v->name, reason);
    if (!isfinite(value)) return report(s, DISCARD, "%s = %g %s is not a finite number", v->name, value, v->unit);
    if (!within(v, value))
        return report(s, DISCARD, "%s = %g %s is outside its bounds [%g, %g]", v->name, value, v->unit, v->min, v->max);
    return OK;
}

Status set_values(Instance *s, const unsigned *references, size_t n, const double *values)
{
    int parameters = 0;
    const int may_set_inputs = phase(s) != TERMINATED;
    for (size_t i = 0; i < n; i++) {
        /* Values that are set in every step pass here; all others are examined in detail. */
        const unsigned input = references[i] - model.first_input;
        if (may_set_inputs && input < model.n_inputs && within(&model.variables[references[i]], values[i])) continue;
        const Status status = check_value(s, references[i], values[i]);
        if (status != OK) return status;
        parameters |= references[i] < model.first_input; /* time, which cannot be set, and the parameters */
    }
    for (size_t i = 0; i < n; i++) s->z[references[i]] = values[i];
    if (n > 0) values_changed(s, parameters);
    return OK;
}

Status get_values(Instance *s, const unsigned *references, size_t n, double *values)
{
    if (n > 0) update_outputs(s);
    for (size_t i = 0; i < n; i++) {
        const unsigned r = references[i];
        if (r >= model.first_derivative) {
            if (r >= model.n_variables) return report(s, ERROR, "there is no variable with value reference %u (valid: 0 to %u)", r, model.n_variables - 1);
            if (!update_rates(s)) return report(s, ERROR, "the mass matrix is singular at %g s", s->z[0]);
        }
        values[i] = s->z[r];
    }
    return OK;
}

Status get_block(Instance *s, unsigned first, size_t n, double *values)
{
    if (n != model.n_states) return report(s, ERROR, "%u states were asked for, the model has %u", (unsigned)n, model.n_states);
    if (!update_rates(s)) return report(s, ERROR, "the mass matrix is singular at %g s", s->z[0]);
    if (n > 0) memcpy(values, s->z + first, n * sizeof *values);
    return OK;
}

Status set_time(Instance *s, double time)
{
    if (!isfinite(time)) return report(s, ERROR, "time = %g s is not a finite number", time);
    s->z[0] = time;
    values_changed(s, 0);
    return OK;
}

Status set_states(Instance *s, const double *states, size_t n)
{
    if (n != model.n_states) return report(s, ERROR, "%u states were given, the model has %u", (unsigned)n, model.n_states);
    for (size_t i = 0; i < n; i++)
        if (!isfinite(states[i]))
            return report(s, DISCARD, "%s = %g is not a finite number", model.variables[model.first_state + i].name, states[i]);
    if (n > 0) memcpy(s->z + model.first_state, states, n * sizeof *states);
    values_changed(s, 0);
    return OK;
}

static void update_parameters(Instance *s)
{
    if (s->parameters_changed) model.parameters(s->z);
    s->parameters_changed = 0;
}

int rates_at(Instance *s, double *z, double *rates)
{
    model.terms(z);
    model.rates(z, rates);
    if (!model.has_mass) return 1;
    memset(s->lu, 0, model.n_states * model.n_states * sizeof *s->lu);
    model.mass(z, s->lu);
    if (!lu_factor(s->lu, s->pivot, model.n_states)) return 0;
    lu_solve(s->lu, s->pivot, model.n_states, rates, 1);
    return 1;
}

void jacobian_at(Instance *s, const double *z, const double *rates, double *jacobian)
{
    const unsigned n = model.n_states, columns = n + model.n_inputs + 1;
    memset(jacobian, 0, (n + model.n_outputs) * columns * sizeof *jacobian);
    model.jacobian(z, rates, jacobian);
    if (model.has_mass) lu_solve(s->lu, s->pivot, n, jacobian, columns);
}

int update_rates(Instance *s)
{
    update_parameters(s);
    if (s->rates_changed && !rates_at(s, s->z, s->z + model.first_derivative)) return 0;
    s->rates_changed = 0;
    return 1;
}

void update_outputs(Instance *s)
{
    update_parameters(s);
    if (!s->outputs_changed) return;
    model.terms(s->z);
    model.outputs(s->z);
    s->outputs_changed = 0;
}

int update_jacobian(Instance *s)
{
    if (!s->jacobian_changed) return 1;
    /* Repeated, because the factors of the mass matrix must belong to the present values. */
    s->rates_changed = 1;
    if (!update_rates(s)) return 0;
    jacobian_at(s, s->z, s->z + model.first_derivative, s->jacobian);
    s->jacobian_changed = 0;
    return 1;
}
