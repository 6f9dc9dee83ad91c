/* What the functions of every FMI version do first: is the instance there, may this be called now, are the
   pointers given? A call that is refused is reported and changes nothing. */

#ifndef CALL_H
#define CALL_H

#include "instance.h"

enum {
    STARTING = INSTANTIATED | INITIALIZING,
    RUNNING = STEPPING | EVENT | CONTINUOUS,
    ANY = STARTING | RUNNING | TERMINATED,
    EVALUABLE = ANY & ~INSTANTIATED
};

/* The instance; NULL when the call is refused. */
Instance *called(void *instance, const char *function, unsigned allowed, int pointers);

/* Goes from one of the allowed phases into the next. */
Status change_phase(void *instance, const char *function, unsigned allowed, Phase next);

/* Why no instance can be made of this; NULL when it can. */
const char *refused_identity(const char *name, const char *identifier);

/* Start, stop and tolerance of an experiment. */
Status set_experiment(Instance *s, int tolerance_defined, double tolerance, double start, int stop_defined, double stop);

/* Chooses what is logged. A category has the name that the model description lists. */
Status choose_categories(Instance *s, int on, size_t n, const char *const *names);
const char *category_of(Status status);
int is_logged(const Instance *s, Status status);

Status get_nominals(Instance *s, size_t n, double *nominals);

/* The states of the FMU; `function` is the name that each of these has in the version. */
Status take_state(void *instance, const char *function, void **state);
Status restore_state(void *instance, const char *function, void *state);
Status free_state(void *instance, const char *function, void **state);
Status size_of_state(void *instance, const char *function, void *state, size_t *size);
Status write_state(void *instance, const char *function, void *state, unsigned char *bytes, size_t size);
Status read_state(void *instance, const char *function, const unsigned char *bytes, size_t size, void **state);

#endif
