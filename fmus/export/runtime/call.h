/* Checks at the entry of every FMI function: a valid instance, a phase in which the call is allowed, valid pointers.
   A call that is refused is logged and changes no value; the instance is then in the phase FAILED. */

#ifndef CALL_H
#define CALL_H

#include "instance.h"

enum {
    STARTING = INSTANTIATED | INITIALIZING,
    RUNNING = STEPPING | EVENT | CONTINUOUS,
    SOUND = STARTING | RUNNING | TERMINATED,
    ANY = SOUND | FAILED,
    EVALUABLE = ANY & ~INSTANTIATED
};

/* The instance; NULL when the call is refused. */
Instance *called(void *instance, const char *function, unsigned allowed, int pointers);

/* Moves from one of the allowed phases to the next. */
Status change_phase(void *instance, const char *function, unsigned allowed, Phase next);

/* The reason why no instance can be made; NULL when it can. */
const char *refused_identity(const char *name, const char *identifier);

/* Start, stop and tolerance of an experiment. */
Status set_experiment(Instance *s, int tolerance_defined, double tolerance, double start, int stop_defined, double stop);

/* Selects the categories that are logged. A category has the name that the model description lists. */
Status choose_categories(Instance *s, int on, size_t n, const char *const *names);
const char *category_of(Status status);
int is_logged(const Instance *s, Status status);

Status get_nominals(Instance *s, size_t n, double *nominals);

/* FMU states; `function` is the name of the FMI function in the version. */
Status take_state(void *instance, const char *function, void **state);
Status restore_state(void *instance, const char *function, void *state);
Status free_state(void *instance, const char *function, void **state);
Status size_of_state(void *instance, const char *function, void *state, size_t *size);
Status write_state(void *instance, const char *function, void *state, unsigned char *bytes, size_t size);
Status read_state(void *instance, const char *function, const unsigned char *bytes, size_t size, void **state);

#endif
