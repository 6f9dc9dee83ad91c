/* One FMU of FMI 2.0 or 3.0: the calls of a co-simulation under one set of names. Statuses are those of FMI. */

#ifndef UNIT_H
#define UNIT_H

#include <stdbool.h>
#include <stddef.h>

enum { WARNING = 1, STOPPED = 100 }; /* STOPPED: an FMU of FMI 3.0 has ended a step early */
enum { SET, GET, STEP, SET_SLOPES, GET_SLOPES, SAVE, RESTORE, DIRECTIONAL, CALLS };

typedef void (*Function)(void);

/* How the inputs move within a step, for an FMU of FMI 3.0, which asks for them: sum_k c_k s^k, s = (time - begin) / step. */
typedef struct {
    void *instance;
    Function set;
    const unsigned *references;
    size_t n;
    double *coefficients; /* 4 rows of n, then a row for the inputs at a time */
    double begin, step;
} Path;

typedef struct {
    size_t order, n_columns; /* the highest power of time among the rows; the columns that are not zero */
    const size_t *columns;   /* which they are */
    const double *blocks;    /* four rows of these columns after the other */
} Matrix;

typedef struct {
    void *instance, *saved;
    Path *path; /* NULL: the inputs move by their derivatives, or not at all */
    size_t version;
    Function calls[CALLS];
    size_t n_inputs, n_outputs, n_states, order, first_input, first_output, first_state;
    size_t like;                                  /* the first unit that is told the same by others, whose coefficients it shares */
    double *coefficients;                         /* (4, n_inputs): of the path, else the derivatives with respect to time */
    const unsigned *unknowns, *knowns;            /* rates of the states, then outputs; states, then inputs */
    const unsigned *slope_inputs;
    const int *slope_orders, *output_orders;      /* order k of all inputs, of all outputs, one row after the other */
    Matrix guess, final;                          /* to the inputs' polynomials, in the first pass and in those after it */
} Unit;

int set_values(const Unit *u, const unsigned *references, size_t n, const double *values);
int get_values(const Unit *u, const unsigned *references, size_t n, double *values);
int do_step(const Unit *u, double time, double step);
int set_slopes(const Unit *u, size_t order, const double *slopes);
int get_slopes(const Unit *u, size_t order, double *slopes);
int save(Unit *u);
int restore(const Unit *u);
/* sensitivity (rates and outputs) along a seed (states and inputs) */
int directional(const Unit *u, const double *seed, double *sensitivity);

#endif
