/* One instance of the model: its values, and how they are set, read, saved and restored. Independent of the FMI version. */

#ifndef INSTANCE_H
#define INSTANCE_H

#include <stddef.h>

#include "model.h"

enum { MAX_ORDER = 3 }; /* of the inputs as polynomials in time */

typedef enum { INSTANTIATED = 1, INITIALIZING = 2, STEPPING = 4, EVENT = 8, CONTINUOUS = 16, TERMINATED = 32, FAILED = 64, INTERMEDIATE = 128 } Phase;

typedef enum { OK, WARNING, DISCARD, ERROR } Status;

/* Whether the derivatives of the inputs are all zero, set for the next step, or left from the end of the last one. */
enum { NO_SLOPES, SLOPES_FOR_NEXT_STEP, SLOPES_OF_LAST_STEP };

/* The part of a snapshot besides the values; numbers only. */
enum { PHASE, STOP_TIME, SLOPES, INNER_STEP, N_SCALARS };

typedef struct Snapshot Snapshot;
typedef struct Instance Instance;
typedef void Logger(Instance *instance, Status status, const char *message);

struct Instance {
    double *kept;      /* scalars, slopes and z in one block */
    double *z;         /* all values in the order of the references */
    double *slopes;    /* derivatives of the inputs at the present time, MAX_ORDER rows of n_inputs */
    unsigned n_kept;   /* without the terms at the end of z, which are computed from the rest */
    int parameters_changed, rates_changed, outputs_changed, jacobian_changed;
    double *jacobian;  /* d(x', y)/d(x, u, t), with the mass matrix solved */
    double *lu;        /* LU factors of the mass matrix */
    unsigned *pivot;   /* two rows of n_states: of the mass matrix and of the solver */
    double *work;      /* scratch of the methods, see WORK in instance.c */

    /* The matrices of the exact step, and for what they are valid. */
    double *phi, *propagator, *matrices_held;
    double matrices_step;
    unsigned matrices_order; /* 0: there are none */

    Snapshot *snapshots;
    char *name;
    Logger *logger;
    void *host;        /* data of the FMI version */
    unsigned categories;
};

Instance *instance_new(const char *name, Logger *logger, void *host);
void instance_free(Instance *s);

/* Every value at its start, time zero, phase INSTANTIATED. */
void instance_reset(Instance *s);

/* Logs a message to the host and returns the status. After an error the phase is FAILED until the instance is reset or a
   state is restored (FMI 2.0.4, 2.1.3; FMI 3.0, 2.3.1). */
Status report(Instance *s, Status status, const char *format, ...);

Phase phase(const Instance *s);
void enter(Instance *s, Phase phase);

/* When one value is refused, none is set. A value outside its bounds is discarded: the instance is as before. */
Status set_values(Instance *s, const unsigned *references, size_t n, const double *values);
Status get_values(Instance *s, const unsigned *references, size_t n, double *values);
/* The states or their derivatives, n_states values from a reference on. */
Status get_block(Instance *s, unsigned first, size_t n, double *values);
Status set_time(Instance *s, double time);
Status set_states(Instance *s, const double *states, size_t n);

/* Update everything that is computed from the values. 0 when the mass matrix is singular. */
int update_rates(Instance *s);
void update_outputs(Instance *s);
int update_jacobian(Instance *s);

/* x' for any vector of values; needs up-to-date parameters in z. 0 when the mass matrix is singular. */
int rates_at(Instance *s, double *z, double *rates);
/* The Jacobian with the mass matrix solved; rates are x' at z, as rates_at has just left them. */
void jacobian_at(Instance *s, const double *z, const double *rates, double *jacobian);

/* To be called after z has changed: marks computed quantities as outdated. */
void values_changed(Instance *s, int parameters);

/* Derivatives of the inputs with respect to time, order 1 to MAX_ORDER, at the start of the next step. */
Status set_slopes(Instance *s, const unsigned *references, size_t n, const int *orders, const double *values);
/* Whether an input moves in this step that must be held for the component to be linear. */
int held_input_moves(const Instance *s);
/* Derivatives of the outputs with respect to time. */
Status get_slopes(Instance *s, const unsigned *references, size_t n, const int *orders, double *values);

/* seed -> d unknowns/d knowns * seed, and the transpose. */
Status directional_derivative(Instance *s, const unsigned *unknowns, size_t n_unknowns, const unsigned *knowns,
                              size_t n_knowns, const double *seed, double *sensitivity);
Status adjoint_derivative(Instance *s, const unsigned *unknowns, size_t n_unknowns, const unsigned *knowns,
                          size_t n_knowns, const double *seed, double *sensitivity);

#endif
