/* Checks at the entry of every FMI function: see call.h. */

#include <math.h>
#include <string.h>

#include "call.h"
#include "snapshot.h"

static const struct {
    const char *name;
    unsigned statuses;
} categories[] = {
    {"logAll", 1u << WARNING | 1u << DISCARD | 1u << ERROR},
    {"logStatusWarning", 1u << WARNING},
    {"logStatusDiscard", 1u << DISCARD},
    {"logStatusError", 1u << ERROR},
};
enum { N_CATEGORIES = sizeof categories / sizeof categories[0] };

static const char *phase_name(Phase p)
{
    switch (p) {
    case INSTANTIATED: return "before initialisation";
    case INITIALIZING: return "during initialisation";
    case STEPPING: return "between steps";
    case EVENT: return "in event mode";
    case CONTINUOUS: return "in continuous-time mode";
    case FAILED: return "after an error; reset the instance or restore a state first";
    case INTERMEDIATE: return "during an intermediate update";
    default: return "after termination";
    }
}

Instance *called(void *instance, const char *function, unsigned allowed, int pointers)
{
    Instance *s = instance;
    if (!s) return NULL;
    if (!(phase(s) & allowed)) {
        report(s, ERROR, "%s may not be called %s", function, phase_name(phase(s)));
        return NULL;
    }
    if (!pointers) {
        report(s, ERROR, "%s was given a null pointer", function);
        return NULL;
    }
    return s;
}

Status change_phase(void *instance, const char *function, unsigned allowed, Phase next)
{
    Instance *s = called(instance, function, allowed, 1);
    if (!s) return ERROR;
    enter(s, next);
    return OK;
}

const char *refused_identity(const char *name, const char *identifier)
{
    if (!name || !*name) return "an instance needs a name";
    if (!identifier || strcmp(identifier, model.guid) != 0)
        return "the identifier given is not that of this model: model description and binary do not belong together";
    return NULL;
}

Status set_experiment(Instance *s, int tolerance_defined, double tolerance, double start, int stop_defined, double stop)
{
    if (stop_defined && !(stop >= start)) return report(s, ERROR, "stop time %g s is before start time %g s", stop, start);
    if (tolerance_defined && model.tolerance > 0) {
        const Status status = set_values(s, &model.tolerance, 1, &tolerance);
        if (status != OK) return status;
    }
    if (set_time(s, start) != OK) return ERROR;
    s->kept[STOP_TIME] = stop_defined ? stop : HUGE_VAL;
    return OK;
}

Status choose_categories(Instance *s, int on, size_t n, const char *const *names)
{
    unsigned chosen = n == 0 ? categories[0].statuses : 0;
    for (size_t i = 0; i < n; i++) {
        size_t k = 0;
        while (k < N_CATEGORIES && !(names[i] && strcmp(names[i], categories[k].name) == 0)) k++;
        if (k == N_CATEGORIES)
            return report(s, ERROR, "unknown log category '%.100s' (valid: logAll, logStatusError, logStatusDiscard, logStatusWarning)", names[i] ? names[i] : "");
        chosen |= categories[k].statuses;
    }
    s->categories = on ? chosen : 0;
    return OK;
}

const char *category_of(Status status) { return categories[status].name; }

int is_logged(const Instance *s, Status status) { return (s->categories & 1u << status) != 0; }

Status get_nominals(Instance *s, size_t n, double *nominals)
{
    if (n != model.n_states) return report(s, ERROR, "the nominals of %u states were asked for, the model has %u", (unsigned)n, model.n_states);
    for (size_t i = 0; i < n; i++) nominals[i] = model.variables[model.first_state + i].nominal;
    return OK;
}

Status take_state(void *instance, const char *function, void **state)
{
    Instance *s = called(instance, function, SOUND, state != NULL);
    if (!s) return ERROR;
    Snapshot *snapshot = *state;
    const Status status = snapshot_take(s, &snapshot);
    *state = snapshot;
    return status;
}

Status restore_state(void *instance, const char *function, void *state)
{
    Instance *s = called(instance, function, ANY, state != NULL);
    return s ? snapshot_restore(s, state) : ERROR;
}

Status free_state(void *instance, const char *function, void **state)
{
    Instance *s = called(instance, function, ANY, 1);
    if (!s) return ERROR;
    if (!state || !*state) return OK;
    const Status status = snapshot_free(s, *state);
    if (status == OK) *state = NULL;
    return status;
}

Status size_of_state(void *instance, const char *function, void *state, size_t *size)
{
    Instance *s = called(instance, function, ANY, state && size);
    if (!s) return ERROR;
    *size = serialised_size(s);
    return OK;
}

Status write_state(void *instance, const char *function, void *state, unsigned char *bytes, size_t size)
{
    Instance *s = called(instance, function, ANY, state && bytes);
    return s ? serialise(s, state, bytes, size) : ERROR;
}

Status read_state(void *instance, const char *function, const unsigned char *bytes, size_t size, void **state)
{
    Instance *s = called(instance, function, ANY, bytes && state);
    if (!s) return ERROR;
    Snapshot *snapshot = *state;
    const Status status = deserialise(s, bytes, size, &snapshot);
    *state = snapshot;
    return status;
}
