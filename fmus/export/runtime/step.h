/* One step in time. */

#ifndef STEP_H
#define STEP_H

#include "instance.h"

/* From a time, which must be the instance's own, on by a step, with the inputs as their polynomials say. On
   anything but OK the instance is as it was and the reason has been reported. */
Status step_from(Instance *s, double time, double step);

/* Whether such a step may be asked for; reports why not. */
Status check_step(Instance *s, double time, double step);

/* Whether the states at a time are finite and where the model holds; reports which is not. */
Status states_in_bounds(Instance *s, double time, const double *states);

/* The two methods: new states (n_states) from the present values, which they leave alone. */
Status exact_step(Instance *s, double step, unsigned order, double *states);
Status rosenbrock_step(Instance *s, double step, double *states);

/* The inputs after a time tau, written into z. */
void inputs_after(const Instance *s, double tau, double *z);

#endif
