/* Snapshots of an instance: see snapshot.h. They belong to the instance, so that an invalid pointer is detected and none leaks. */

#include <stdlib.h>
#include <string.h>

#include "snapshot.h"

struct Snapshot {
    Snapshot *next;
    double kept[];
};

static int known(const Instance *s, const Snapshot *snapshot)
{
    for (const Snapshot *each = s->snapshots; each; each = each->next)
        if (each == snapshot) return 1;
    return 0;
}

static Snapshot *new_snapshot(Instance *s)
{
    Snapshot *snapshot = malloc(sizeof *snapshot + s->n_kept * sizeof *snapshot->kept);
    if (snapshot) {
        snapshot->next = s->snapshots;
        s->snapshots = snapshot;
    }
    return snapshot;
}

static Status refuse(Instance *s) { return report(s, ERROR, "the FMU state given is none of this instance"); }

Status snapshot_take(Instance *s, Snapshot **snapshot)
{
    if (*snapshot && !known(s, *snapshot)) return refuse(s);
    update_outputs(s);
    if (!update_rates(s)) return report(s, ERROR, "the mass matrix is singular at %g s", s->z[0]);
    if (!*snapshot) *snapshot = new_snapshot(s);
    if (!*snapshot) return report(s, ERROR, "out of memory for an FMU state");
    memcpy((*snapshot)->kept, s->kept, s->n_kept * sizeof *s->kept);
    return OK;
}

Status snapshot_restore(Instance *s, const Snapshot *snapshot)
{
    if (!known(s, snapshot)) return refuse(s);
    const double *values = snapshot->kept + (s->z - s->kept), inner_step = snapshot->kept[INNER_STEP];
    /* With the same parameters the matrices of the exact step stay valid: iterative masters restore in every step. */
    const int parameters = s->parameters_changed || memcmp(s->z + 1, values + 1, (model.first_input - 1) * sizeof *values) != 0;
    memcpy(s->kept, snapshot->kept, s->n_kept * sizeof *s->kept);
    values_changed(s, parameters);
    s->kept[INNER_STEP] = inner_step;
    return OK;
}

Status snapshot_free(Instance *s, Snapshot *snapshot)
{
    Snapshot **link = &s->snapshots;
    if (!known(s, snapshot)) return refuse(s);
    while (*link != snapshot) link = &(*link)->next;
    *link = snapshot->next;
    free(snapshot);
    return OK;
}

size_t serialised_size(const Instance *s) { return strlen(model.guid) + s->n_kept * sizeof *s->kept; }

Status serialise(Instance *s, const Snapshot *snapshot, unsigned char *bytes, size_t size)
{
    const size_t header = strlen(model.guid);
    if (!known(s, snapshot)) return refuse(s);
    if (size < serialised_size(s)) return report(s, ERROR, "%lu bytes are too few for an FMU state of %lu", (unsigned long)size, (unsigned long)serialised_size(s));
    memcpy(bytes, model.guid, header);
    memcpy(bytes + header, snapshot->kept, s->n_kept * sizeof *s->kept);
    return OK;
}

Status deserialise(Instance *s, const unsigned char *bytes, size_t size, Snapshot **snapshot)
{
    const size_t header = strlen(model.guid);
    double phase_kept;
    if (size != serialised_size(s) || memcmp(bytes, model.guid, header) != 0)
        return report(s, ERROR, "the bytes given are no FMU state of this model");
    memcpy(&phase_kept, bytes + header + PHASE * sizeof phase_kept, sizeof phase_kept);
    for (unsigned p = INSTANTIATED; phase_kept != p; p *= 2)
        if (p >= TERMINATED) return report(s, ERROR, "the bytes given are no FMU state of this model");
    if (*snapshot && !known(s, *snapshot)) return refuse(s);
    if (!*snapshot) *snapshot = new_snapshot(s);
    if (!*snapshot) return report(s, ERROR, "out of memory for an FMU state");
    memcpy((*snapshot)->kept, bytes + header, s->n_kept * sizeof *s->kept);
    return OK;
}
