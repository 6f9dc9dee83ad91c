/* The calls of a co-simulation in FMI 2.0 and 3.0 under one set of names. Statuses are those of FMI. */

#include <stdbool.h>
#include <stddef.h>

#ifdef _WIN32
#define EXPORT __declspec(dllexport)
#else
#define EXPORT __attribute__((visibility("default")))
#endif

#include "structures.h"

typedef int Values2(void *, const unsigned *, size_t, double *);
typedef int Values3(void *, const unsigned *, size_t, double *, size_t);
typedef int Step2(void *, double, double, int);
typedef int Step3(void *, double, double, bool, bool *, bool *, bool *, double *);
typedef int Slopes(void *, const unsigned *, size_t, const int *, double *); /* of FMI 2.0 */
typedef int State(void *, void *);
typedef int Directional2(void *, const unsigned *, size_t, const unsigned *, size_t, const double *, double *);
typedef int Directional3(void *, const unsigned *, size_t, const unsigned *, size_t, const double *, size_t, double *, size_t);

static int access(const Subsystem *u, Function f, const unsigned *references, size_t n, double *values)
{
    return u->version == 2 ? ((Values2 *)f)(u->instance, references, n, values) : ((Values3 *)f)(u->instance, references, n, values, n);
}

static int set_values(const Subsystem *u, const unsigned *references, size_t n, const double *values) { return access(u, u->calls[SET], references, n, (double *)values); }

static int get_values(const Subsystem *u, const unsigned *references, size_t n, double *values) { return access(u, u->calls[GET], references, n, values); }

static int do_step(const Subsystem *u, double time, double step)
{
    if (u->version == 2) return ((Step2 *)u->calls[STEP])(u->instance, time, step, 0);
    bool event, terminate, early;
    double last;
    const int status = ((Step3 *)u->calls[STEP])(u->instance, time, step, false, &event, &terminate, &early, &last);
    if (status > WARNING) return status;
    if (terminate) *u->ended = last;
    return terminate ? ENDED : early ? STOPPED : status;
}

static int set_slopes(const Subsystem *u, size_t order, const double *slopes)
{
    return ((Slopes *)u->calls[SET_SLOPES])(u->instance, u->slope_inputs, order * u->n_inputs, u->slope_orders, (double *)slopes);
}

static int get_slopes(const Subsystem *u, size_t order, double *slopes)
{
    return ((Slopes *)u->calls[GET_SLOPES])(u->instance, u->unknowns + u->n_states, u->n_outputs, u->output_orders + (order - 1) * u->n_outputs, slopes);
}

static int save(Subsystem *u) { return ((State *)u->calls[SAVE])(u->instance, &u->saved); }

static int restore(const Subsystem *u) { return ((State *)u->calls[RESTORE])(u->instance, u->saved); }

static int directional(const Subsystem *u, const double *seed, double *sensitivity)
{
    const size_t n = u->n_states + u->n_outputs, m = u->n_states + u->n_inputs;
    const Function f = u->calls[DIRECTIONAL];
    return u->version == 2 ? ((Directional2 *)f)(u->instance, u->unknowns, n, u->knowns, m, seed, sensitivity)
                           : ((Directional3 *)f)(u->instance, u->unknowns, n, u->knowns, m, seed, m, sensitivity, n);
}

/* What an FMU of FMI 3.0 calls within a step (fmi3IntermediateUpdateCallback); its environment is the path. */
EXPORT void move_inputs(void *environment, double time, bool set_requested, bool get_allowed, bool finished, bool may_return, bool *return_requested, double *return_time)
{
    Path *p = environment;
    (void)get_allowed, (void)finished, (void)may_return, (void)return_requested, (void)return_time;
    if (!set_requested || !p->step) return;
    const double s = (time - p->begin) / p->step, *c = p->coefficients;
    double *inputs = p->coefficients + 4 * p->n;
    for (size_t i = 0; i < p->n; i++) inputs[i] = c[i] + s * (c[p->n + i] + s * (c[2 * p->n + i] + s * c[3 * p->n + i]));
    ((Values3 *)p->set)(p->instance, p->references, p->n, inputs, p->n);
}
