/* What the files of FMI 3.0 share: the importer's callbacks, and statuses. */

#ifndef FMI3_HOST_H
#define FMI3_HOST_H

#include "call.h"
#if defined(__clang__) && __clang_major__ >= 15 /* which has something against `()` in the header of the standard */
#pragma clang diagnostic ignored "-Wdeprecated-non-prototype"
#pragma clang diagnostic ignored "-Wstrict-prototypes"
#endif
#include "fmi3Functions.h"

/* What the importer gave. */
typedef struct {
    fmi3InstanceEnvironment environment;
    fmi3LogMessageCallback log;
    fmi3IntermediateUpdateCallback intermediate_update; /* NULL: none, or no input that it could set */
    int exchange, early_return;
} Host;

fmi3Status as_fmi3(Status status);

#endif
