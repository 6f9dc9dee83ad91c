/* The error-controlled step: Rosenbrock method of order 4 with an embedded one of order 3, stiffly accurate.

       (I/(gamma h) - J) k_i = f(t + alpha_i h, x + sum_j a_ij k_j) + sum_j (c_ij/h) k_j + delta_i h f_t
       x(h) = x + sum_j a_6j k_j + k_6,   error estimate k_6

   RODAS: Hairer, Wanner, Solving Ordinary Differential Equations II, 2nd ed. (1996), section IV.10. J is the
   symbolic Jacobian, so stiffness costs nothing; where the equations have a kink the error estimate shortens
   the step. */

#include <math.h>
#include <stdio.h>
#include <string.h>

#include "linear_algebra.h"
#include "step.h"

enum { STAGES = 6, MAX_STEPS = 100000 };

static const double GAMMA = 0.25;
static const double ALPHA[STAGES] = {0, 0.386, 0.21, 0.63, 1, 1};
static const double DELTA[STAGES] = {0.25, -0.1043, 0.1035, -0.0362, 0, 0};
static const double A[STAGES][STAGES - 1] = {
    {0},
    {1.544},
    {0.9466785280815826, 0.2557011698983284},
    {3.314825187068521, 2.896124015972201, 0.9986419139977817},
    {1.221224509226641, 6.019134481288629, 12.53708332932087, -0.6878860361058950},
    {1.221224509226641, 6.019134481288629, 12.53708332932087, -0.6878860361058950, 1},
};
static const double C[STAGES][STAGES - 1] = {
    {0},
    {-5.6688},
    {-2.430093356833875, -0.2063599157091915},
    {-0.1073529058151375, -9.594562251023355, -20.47028614809616},
    {7.496443313967647, -10.24680431464352, -33.99990352819905, 11.70890893206160},
    {8.083246795921522, -7.981132988064893, -31.52159432874371, 16.31930543123136, -6.058818238834054},
};

/* Arrays in the instance's work memory. */
typedef struct {
    double *z, *rates, *time_slope, *k, *jacobian, *lu;
} Scratch;

/* J, f_t and x' at the present z of the work memory; u' after tau joins f_t. These hold until the step is accepted. */
static int linearise(Instance *s, double tau, Scratch *w)
{
    const unsigned n = model.n_states, nu = model.n_inputs, columns = n + nu + 1;
    const double *d = s->slopes;
    if (!rates_at(s, w->z, w->rates)) return 0;
    jacobian_at(s, w->z, w->rates, w->jacobian);
    for (unsigned i = 0; i < n; i++) {
        const double *row = w->jacobian + i * columns;
        w->time_slope[i] = row[n + nu];
        for (unsigned j = 0; j < nu; j++)
            w->time_slope[i] += row[n + j] * (d[j] + tau * (d[nu + j] + tau / 2 * d[2 * nu + j]));
    }
    return 1;
}

/* The scaled error of one inner step from x after tau; its result in `states`. Infinite when the step fails. */
static double attempt(Instance *s, double tau, double h, double tolerance, const double *x, double *states, Scratch *w)
{
    const unsigned n = model.n_states, columns = n + model.n_inputs + 1;
    unsigned *pivot = s->pivot + n;
    for (unsigned i = 0; i < n; i++)
        for (unsigned j = 0; j < n; j++) w->lu[i * n + j] = (i == j) / (GAMMA * h) - w->jacobian[i * columns + j];
    if (!lu_factor(w->lu, pivot, n)) return HUGE_VAL;
    for (unsigned stage = 0; stage < STAGES; stage++) {
        double *k = w->k + stage * n;
        memcpy(states, x, n * sizeof *x);
        for (unsigned j = 0; j < stage; j++)
            for (unsigned i = 0; i < n; i++) states[i] += A[stage][j] * w->k[j * n + i];
        memcpy(w->z + model.first_state, states, n * sizeof *states);
        w->z[0] = s->z[0] + tau + ALPHA[stage] * h;
        inputs_after(s, tau + ALPHA[stage] * h, w->z);
        if (stage == 0)
            memcpy(k, w->rates, n * sizeof *k); /* the first stage is at x */
        else if (!rates_at(s, w->z, k))
            return HUGE_VAL;
        for (unsigned i = 0; i < n; i++) {
            k[i] += DELTA[stage] * h * w->time_slope[i];
            for (unsigned j = 0; j < stage; j++) k[i] += C[stage][j] / h * w->k[j * n + i];
        }
        lu_solve(w->lu, pivot, n, k, 1);
    }
    double sum = 0;
    for (unsigned i = 0; i < n; i++) {
        const double error = w->k[(STAGES - 1) * n + i];
        states[i] += error;
        /* The absolute part: a hundredth of what is nominal for the state. */
        const double size = fmax(fabs(x[i]), fabs(states[i])) + 0.01 * model.variables[model.first_state + i].nominal;
        sum += error * error / (size * size);
    }
    const double scaled = sqrt(sum / n) / tolerance;
    return isfinite(scaled) ? scaled : HUGE_VAL;
}

static Scratch scratch_in(double *work)
{
    const unsigned n = model.n_states, columns = n + model.n_inputs + 1;
    Scratch w;
    w.z = work;
    w.rates = w.z + model.n_values + model.n_terms;
    w.time_slope = w.rates + n;
    w.k = w.time_slope + n;
    w.jacobian = w.k + STAGES * n;
    w.lu = w.jacobian + (n + model.n_outputs) * columns;
    return w;
}

/* The reason why the step fails: a state out of its bounds, or arguments for which the equations are undefined. */
static Status give_up(Instance *s, Scratch *w, double tau, double used, int count)
{
    char values[256] = "";
    size_t length = 0;
    unsigned wrong = 0;
    if (states_in_bounds(s, w->z[0], w->z + model.first_state) != OK) return DISCARD;
    if (rates_at(s, w->z, w->rates))
        while (wrong < model.n_states && isfinite(w->rates[wrong])) wrong++;
    if (wrong == model.n_states)
        return report(s, DISCARD, "the relative tolerance %g cannot be met at %g s: inner step %g s after %d steps", s->z[model.tolerance], s->z[0] + tau, used, count);
    for (unsigned r = model.first_input; r < model.first_state + model.n_states && length < sizeof values; r++)
        length += (size_t)snprintf(values + length, sizeof values - length, ", %s = %g %s", model.variables[r].name, w->z[r], model.variables[r].unit);
    return report(s, DISCARD, "%s has no value at time = %g s%s", model.variables[model.first_derivative + wrong].name, w->z[0], values);
}

Status rosenbrock_step(Instance *s, double step, double *states)
{
    const unsigned n = model.n_states;
    double *x = states + n;
    Scratch w = scratch_in(x + n);
    const double tolerance = s->z[model.tolerance];
    double tau = 0, h = s->kept[INNER_STEP] > 0 ? s->kept[INNER_STEP] : step;
    int rejected = 0, stale = 1;
    memcpy(x, s->z + model.first_state, n * sizeof *x);
    memcpy(w.z, s->z, model.n_values * sizeof *w.z);
    for (int count = 0; tau < step; count++) {
        const int last = h >= (step - tau) * (1 - 1e-12);
        const double used = last ? step - tau : h;
        if (count == MAX_STEPS || !(used > 1e-14 * step))
            return give_up(s, &w, tau, used, count);
        memcpy(w.z + model.first_state, x, n * sizeof *x);
        w.z[0] = s->z[0] + tau;
        inputs_after(s, tau, w.z);
        if (stale && !linearise(s, tau, &w)) return report(s, DISCARD, "the mass matrix is singular at %g s", w.z[0]);
        const double error = attempt(s, tau, used, tolerance, x, states, &w);
        double factor = fmin(fmax(0.9 * pow(error, -0.25), 0.1), rejected ? 1 : 5);
        stale = !(rejected = !(error <= 1));
        if (!rejected) {
            memcpy(x, states, n * sizeof *x);
            tau = last ? step : tau + used;
            if (last && h > used) factor = fmax(factor, h / used); /* the last inner step was shortened by the end of the step */
        }
        h = used * factor;
    }
    memcpy(states, x, n * sizeof *x);
    s->kept[INNER_STEP] = h;
    return OK;
}
