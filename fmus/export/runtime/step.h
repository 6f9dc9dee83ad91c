/* One step in time. */

#ifndef STEP_H
#define STEP_H

#include "instance.h"

/* Advances by a step from a time, which must be the instance's own, with the inputs as polynomials. If the status is
   not OK, the instance is unchanged and the reason has been logged. */
Status step_from(Instance *s, double time, double step);

/* Whether such a step is allowed; logs the reason if not. */
Status check_step(Instance *s, double time, double step);

/* Whether the states at a time are finite and within their bounds; logs the first that is not. */
Status states_in_bounds(Instance *s, double time, const double *states);

/* The two methods: new states (n_states) from the present values, which are not changed. */
Status exact_step(Instance *s, double step, unsigned order, double *states);
Status rosenbrock_step(Instance *s, double step, double *states);

/* The inputs after a time tau, written into z. */
void inputs_after(const Instance *s, double tau, double *z);

#endif
