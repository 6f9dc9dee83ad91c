/* Shared by the files of FMI 3.0: the importer's callbacks, and statuses. */

#ifndef FMI3_HOST_H
#define FMI3_HOST_H

#include "call.h"
#if defined(__clang__) && __clang_major__ >= 15 /* which warns of `()` in the header of the standard */
#pragma clang diagnostic ignored "-Wdeprecated-non-prototype"
#pragma clang diagnostic ignored "-Wstrict-prototypes"
#endif
#include "fmi3Functions.h"

/* Callbacks and environment of the importer. */
typedef struct {
    fmi3InstanceEnvironment environment;
    fmi3LogMessageCallback log;
    fmi3IntermediateUpdateCallback intermediate_update; /* NULL: not given, or no input can be set by it */
    int exchange, early_return;
} Host;

fmi3Status as_fmi3(Status status);

#endif
