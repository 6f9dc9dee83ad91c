/* The loop of a co-simulation: many steps of a coupling on FMI 2.0 instances. See fmus/compiled_master.py.

   Everything is prepared outside: which signal drives which input, in which order outputs are read, and for each
   unit the matrix from what is known (data) to the polynomials of its inputs,

       u(s) = sum_k c_k s^k,   c = matrix data + external,   s = time / step

   The data are, in this order: rows of signals (present, former, derivatives, end of the step), then, where the
   coupling predicts from the linearised units, the rates of the states and the slopes of the external inputs. */

#include <stddef.h>
#include <string.h>

#ifdef _WIN32
#define EXPORT __declspec(dllexport)
#else
#define EXPORT __attribute__((visibility("default")))
#endif

enum { WARNING = 1 };

static double larger(double a, double b) { return a > b ? a : b; }

static double magnitude(double a) { return a < 0 ? -a : a; }

typedef struct {
    void *instance, *saved;
    int (*set)(void *, const unsigned *, size_t, const double *);
    int (*get)(void *, const unsigned *, size_t, double *);
    int (*step)(void *, double, double, int);
    int (*set_slopes)(void *, const unsigned *, size_t, const int *, const double *);
    int (*get_slopes)(void *, const unsigned *, size_t, const int *, double *);
    int (*save)(void *, void **);
    int (*restore)(void *, void *);
    size_t n_inputs, n_outputs, n_states, order, first_input, first_output, first_state;
    const unsigned *inputs, *outputs, *rates, *slope_inputs;
    const int *slope_orders, *output_orders; /* order k of all inputs, of all outputs, one row after the other */
    size_t guess_order, final_order; /* of the polynomials, from what the units answer */
    const size_t *guess_rows, *guess_columns, *final_rows, *final_columns;
    const double *guess, *final; /* the entries that are not zero of the matrix of the first pass and of those after it */
} Unit;

typedef struct {
    size_t n_units, n_inputs, n_outputs, n_signals, n_data;
    Unit *units;
    const size_t *where;                           /* of each signal among the outputs */
    const size_t *wire_start, *wires;              /* the signals that sum to an input */
    const size_t *rounds, *late;                   /* units, see fmus.coupling.network */
    size_t n_rounds, n_late;
    const size_t *past;                            /* rows, the present one first */
    const size_t *slope_rows, *slope_derivatives;  /* of the present */
    const size_t *end_rows, *end_derivatives;
    size_t n_past, n_slopes, n_ends;
    const size_t *free_inputs;                     /* whose slopes are data */
    size_t rates_at, n_free;                       /* place among the data; 0: no rates are needed */
    const double *expected;                        /* (signals, data): how the signals should change, NULL: not known */
    double missed, converged, step_size, time;
    int sequential, iterated, passes;
    double *data, *now, *told, *coefficients, *slopes, *scratch;
    size_t failed_unit; /* after a status that is no success */
    int status, renew;
    const char *function;
} Master;

static int check(Master *m, size_t unit, const char *function, int status)
{
    if (status <= WARNING) return 1;
    m->failed_unit = unit, m->function = function, m->status = status;
    return 0;
}

/* The inputs of a unit (to `inputs`) from values of the signals' owners (ny); external may be NULL. */
static void gather(const Master *m, const Unit *u, const double *outputs, const double *external, double *inputs)
{
    for (size_t i = 0; i < u->n_inputs; i++) {
        const size_t k = u->first_input + i;
        double sum = external ? external[k] : 0;
        for (size_t w = m->wire_start[k]; w < m->wire_start[k + 1]; w++) sum += outputs[m->where[m->wires[w]]];
        inputs[i] = sum;
    }
}

static int set_inputs(Master *m, size_t k, const double *external)
{
    Unit *u = &m->units[k];
    gather(m, u, m->now, external, m->scratch);
    return check(m, k, "fmi2SetReal", u->set(u->instance, u->inputs, u->n_inputs, m->scratch));
}

static int get_outputs(Master *m, size_t k)
{
    Unit *u = &m->units[k];
    return check(m, k, "fmi2GetReal", u->get(u->instance, u->outputs, u->n_outputs, m->now + u->first_output));
}

static int read_outputs(Master *m, const double *external)
{
    for (size_t r = 0; r < m->n_rounds; r++)
        if (!set_inputs(m, m->rounds[r], external) || !get_outputs(m, m->rounds[r])) return 0;
    return 1;
}

static int settle(Master *m, const double *external)
{
    for (size_t r = 0; r < m->n_late; r++)
        if (!set_inputs(m, m->late[r], external)) return 0;
    return 1;
}

/* slopes (order, ny): the derivatives of all outputs with respect to time. */
static int read_slopes(Master *m, size_t order)
{
    memset(m->slopes, 0, order * m->n_outputs * sizeof *m->slopes);
    for (size_t k = 0; k < order; k++)
        for (size_t r = 0; r < m->n_rounds; r++) {
            Unit *u = &m->units[m->rounds[r]];
            for (size_t j = 0; j <= k; j++) gather(m, u, m->slopes + j * m->n_outputs, NULL, m->scratch + j * u->n_inputs);
            const size_t given = k + 1 < u->order ? k + 1 : u->order;
            if (given > 0 && !check(m, m->rounds[r], "fmi2SetRealInputDerivatives", u->set_slopes(u->instance, u->slope_inputs, given * u->n_inputs, u->slope_orders, m->scratch))) return 0;
            if (!check(m, m->rounds[r], "fmi2GetRealOutputDerivatives", u->get_slopes(u->instance, u->outputs, u->n_outputs, u->output_orders + k * u->n_outputs, m->slopes + k * m->n_outputs + u->first_output))) return 0;
        }
    return 1;
}

/* The signals into a row of the data, from outputs or from their derivatives. */
static void fill(const Master *m, size_t row, const double *outputs)
{
    for (size_t j = 0; j < m->n_signals; j++) m->data[row * m->n_signals + j] = outputs[m->where[j]];
}

static int fill_rows(Master *m, const size_t *rows, const size_t *derivatives, size_t n, const double *external)
{
    size_t highest = 0;
    for (size_t r = 0; r < n; r++)
        if (derivatives[r] > highest) highest = derivatives[r];
    if (highest > 0 && (!settle(m, external) || !read_slopes(m, highest))) return 0;
    for (size_t r = 0; r < n; r++) fill(m, rows[r], derivatives[r] ? m->slopes + (derivatives[r] - 1) * m->n_outputs : m->now);
    return 1;
}

static int fill_rates(Master *m, const double *external)
{
    if (!settle(m, external)) return 0;
    for (size_t k = 0; k < m->n_units; k++) {
        Unit *u = &m->units[k];
        if (u->n_states && !check(m, k, "fmi2GetReal", u->get(u->instance, u->rates, u->n_states, m->data + m->rates_at + u->first_state))) return 0;
    }
    for (size_t i = 0; i < m->n_free; i++)
        m->data[m->n_data - m->n_free + i] = (external[m->n_inputs + m->free_inputs[i]] - external[m->free_inputs[i]]) / m->step_size;
    return 1;
}

/* c = matrix data + external: rows k of the inputs' polynomials, up to the order that is returned. */
static size_t polynomials(Master *m, const Unit *u, int first_pass, const double *external)
{
    const size_t n = u->n_inputs, *rows = first_pass ? u->guess_rows : u->final_rows, *columns = first_pass ? u->guess_columns : u->final_columns;
    const double *matrix = first_pass ? u->guess : u->final;
    double *c = m->coefficients;
    size_t order = first_pass ? u->guess_order : u->final_order;
    for (size_t i = 0; i < n && order == 0 && u->order > 0; i++)
        if (external[m->n_inputs + u->first_input + i] != external[u->first_input + i]) order = 1;
    for (size_t i = 0; i < (order + 1) * n; i++) {
        double sum = 0;
        for (size_t e = rows[i]; e < rows[i + 1]; e++) sum += matrix[e] * m->data[columns[e]];
        c[i] = sum;
    }
    for (size_t i = 0; i < n; i++) {
        const double first = external[u->first_input + i], change = external[m->n_inputs + u->first_input + i] - first;
        c[i] += u->order ? first : first + change / 2;
        if (order) c[n + i] += change;
        double end = 0;
        for (size_t k = 0; k <= order; k++) end += c[k * n + i];
        m->told[u->first_input + i] = end;
    }
    return order;
}

static int step_unit(Master *m, size_t k, int first_pass, const double *external)
{
    Unit *u = &m->units[k];
    const size_t n = u->n_inputs;
    double factor = 1;
    const size_t highest = polynomials(m, u, first_pass, external);
    if (!check(m, k, "fmi2SetReal", u->set(u->instance, u->inputs, n, m->coefficients))) return 0;
    for (size_t order = 1; order <= highest; order++) { /* the derivatives with respect to time: k! c_k / step^k */
        factor *= (double)order / m->step_size;
        for (size_t i = 0; i < n; i++) m->coefficients[order * n + i] *= factor;
    }
    if (highest && !check(m, k, "fmi2SetRealInputDerivatives", u->set_slopes(u->instance, u->slope_inputs, highest * n, u->slope_orders, m->coefficients + n))) return 0;
    return check(m, k, "fmi2DoStep", u->step(u->instance, m->time, m->step_size, 0));
}

static int step_all(Master *m, int first_pass, const double *external)
{
    for (size_t k = 0; k < m->n_units; k++) {
        Unit *u = &m->units[k];
        if (!step_unit(m, k, first_pass, external)) return 0;
        if (m->sequential) { /* the next unit is told what this one has reached */
            if (!check(m, k, "fmi2SetReal", u->set(u->instance, u->inputs, u->n_inputs, m->told + u->first_input)) || !get_outputs(m, k)) return 0;
            for (size_t j = 0; j < m->n_signals; j++)
                if (m->where[j] >= u->first_output && m->where[j] < u->first_output + u->n_outputs)
                    m->data[m->end_rows[0] * m->n_signals + j] = m->now[m->where[j]];
        }
    }
    return 1;
}

/* Repeats the step until what the units answer at its end is what they were told. */
static int iterate(Master *m, const double *external)
{
    const double *after = external + m->n_inputs;
    for (size_t k = 0; k < m->n_units; k++)
        if (!check(m, k, "fmi2GetFMUstate", m->units[k].save(m->units[k].instance, &m->units[k].saved))) return 0;
    for (int pass = 0; pass < m->passes; pass++) {
        double largest = 0, moved = 0;
        if (!step_all(m, pass == 0, external) || !read_outputs(m, after)) return 0;
        const size_t first = m->end_rows[0] * m->n_signals, n = m->n_ends * m->n_signals;
        memcpy(m->scratch + 4 * m->n_inputs, m->data + first, n * sizeof *m->data);
        if (!fill_rows(m, m->end_rows, m->end_derivatives, m->n_ends, after)) return 0;
        for (size_t i = 0; i < n; i++) {
            largest = larger(largest, magnitude(m->data[first + i]));
            moved = larger(moved, magnitude(m->data[first + i] - m->scratch[4 * m->n_inputs + i]));
        }
        if (pass > 0 && moved <= m->converged * largest) return 1;
        for (size_t k = 0; k < m->n_units; k++)
            if (!check(m, k, "fmi2SetFMUstate", m->units[k].restore(m->units[k].instance, m->units[k].saved))) return 0;
    }
    m->function = "iteration", m->status = -1;
    return 0;
}

/* Whether the signals have changed otherwise than expected by more than the share `missed`. */
static int has_missed(const Master *m, const double *before)
{
    double largest = 0, off = 0;
    for (size_t j = 0; m->expected && j < m->n_signals; j++) {
        double change = 0;
        for (size_t i = 0; i < m->n_data; i++) change += m->expected[j * m->n_data + i] * m->data[i];
        largest = larger(largest, magnitude(change));
        off = larger(off, magnitude(m->now[m->where[j]] - before[j] - change));
    }
    return off > m->missed * largest;
}

/* n steps: outputs (n, ny) and told (n, nu) are written; external (n + 1, nu). The number of steps made; fewer
   than n when status is no success, or when `renew` asks for another linearisation. */
EXPORT size_t master_run(Master *m, size_t n, const double *external, double *outputs, size_t stride, double *told)
{
    m->status = m->renew = 0;
    for (size_t k = 0; k < n; k++, external += m->n_inputs) {
        fill(m, 0, m->now);
        if (m->n_slopes && !fill_rows(m, m->slope_rows, m->slope_derivatives, m->n_slopes, external)) return k;
        if (m->rates_at && !fill_rates(m, external)) return k;
        if (m->iterated ? !iterate(m, external) : !step_all(m, 1, external) || !read_outputs(m, external + m->n_inputs)) return k;
        m->time += m->step_size;
        memcpy(outputs + k * stride, m->now, m->n_outputs * sizeof *outputs);
        memcpy(told + k * m->n_inputs, m->told, m->n_inputs * sizeof *told);
        if (has_missed(m, m->data)) {
            m->renew = 1;
            return k + 1;
        }
        for (size_t p = m->n_past - 1; p > 0; p--)
            memcpy(m->data + m->past[p] * m->n_signals, m->data + m->past[p - 1] * m->n_signals, m->n_signals * sizeof *m->data);
    }
    return n;
}
