/* Snapshots of an instance, in memory and as bytes. */

#ifndef SNAPSHOT_H
#define SNAPSHOT_H

#include "instance.h"

/* Saves to *snapshot if it belongs to this instance, or to a new one if *snapshot is NULL. */
Status snapshot_take(Instance *s, Snapshot **snapshot);
Status snapshot_restore(Instance *s, const Snapshot *snapshot);
Status snapshot_free(Instance *s, Snapshot *snapshot);

/* The bytes begin with the identifier of the model; they can be read by another process. */
size_t serialised_size(const Instance *s);
Status serialise(Instance *s, const Snapshot *snapshot, unsigned char *bytes, size_t size);
Status deserialise(Instance *s, const unsigned char *bytes, size_t size, Snapshot **snapshot);

#endif
