/* The loop of a co-simulation: many steps of a coupling on FMUs. See fmus/cosimulation/master/compiled.py.

   Python prepares everything: which signal drives which input, the order in which outputs are read, and for each
   subsystem the matrix from the data to the polynomials of its inputs,

       u(s) = sum_k c_k s^k,   c = matrix data + external,   s = time / step

   or, for FMI 2.0, to their derivatives k! c_k / step^k.

   The data are, in this order: rows of signals (present, former, derivatives, end of the step), then, where the
   coupling predicts from the linearised subsystems, the rates of the states and the slopes of the external inputs. */

#include "subsystem.c"

#include <string.h>

static double larger(double a, double b) { return a > b ? a : b; }

static double magnitude(double a) { return a < 0 ? -a : a; }

static int check(Master *m, size_t subsystem, int call, int status)
{
    if (status <= WARNING) return 1;
    m->failed_subsystem = subsystem, m->call = call, m->status = status;
    return 0;
}

/* The sum that drives an input, from the values of all outputs. */
static double driven(const Master *m, size_t input, const double *outputs)
{
    double sum = 0;
    for (size_t w = m->wire_start[input]; w < m->wire_start[input + 1]; w++) sum += outputs[m->sources[w]];
    return sum;
}

static int set_inputs(Master *m, size_t k, const double *external)
{
    Subsystem *u = &m->subsystems[k];
    for (size_t i = 0; i < u->n_inputs; i++) m->scratch[i] = external[u->first_input + i] + driven(m, u->first_input + i, m->now);
    return check(m, k, SET, set_values(u, u->knowns + u->n_states, u->n_inputs, m->scratch));
}

static int get_outputs(Master *m, size_t k)
{
    Subsystem *u = &m->subsystems[k];
    return check(m, k, GET, get_values(u, u->unknowns + u->n_states, u->n_outputs, m->now + u->first_output));
}

static int get_rates(Master *m, size_t k)
{
    Subsystem *u = &m->subsystems[k];
    return !u->n_states || check(m, k, GET, get_values(u, u->unknowns, u->n_states, m->rates + u->first_state));
}

/* Both in one call. */
static int get_outputs_and_rates(Master *m, size_t k)
{
    Subsystem *u = &m->subsystems[k];
    if (!check(m, k, GET, get_values(u, u->unknowns, u->n_states + u->n_outputs, m->scratch))) return 0;
    memcpy(m->rates + u->first_state, m->scratch, u->n_states * sizeof *m->rates);
    memcpy(m->now + u->first_output, m->scratch + u->n_states, u->n_outputs * sizeof *m->now);
    return 1;
}

static int read_outputs(Master *m, const double *external)
{
    for (size_t r = 0; r < m->n_reads; r++) {
        const size_t k = m->read_order[r];
        if (m->sets_inputs[r] && !set_inputs(m, k, external)) return 0;
        if (!(m->rates_too[r] ? get_outputs_and_rates(m, k) : get_outputs(m, k))) return 0;
    }
    return 1;
}

static int settle(Master *m, const double *external)
{
    for (size_t r = 0; r < m->n_unsettled; r++)
        if (!set_inputs(m, m->unsettled[r], external) || (m->rates_at && !get_rates(m, m->unsettled[r]))) return 0;
    return 1;
}

/* The outputs' derivative of an order from the inputs' derivatives (order, nu), where the FMU does not take them:
   y^(k) = C x^(k) + D u^(k), x^(k+1) = A x^(k) + B u^(k). */
static int slopes_along(Master *m, size_t k, size_t order, const double *input_slopes, double *slopes)
{
    const Subsystem *u = &m->subsystems[k];
    double *seed = m->scratch + 3 * u->n_inputs, *found = seed + u->n_states + u->n_inputs;
    if (u->n_states && !check(m, k, GET, get_values(u, u->unknowns, u->n_states, seed))) return 0;
    for (size_t j = 0; j < order; j++) {
        memcpy(seed + u->n_states, input_slopes + j * u->n_inputs, u->n_inputs * sizeof *seed);
        if (!check(m, k, DIRECTIONAL, directional(u, seed, found))) return 0;
        memcpy(seed, found, u->n_states * sizeof *seed);
    }
    memcpy(slopes, found + u->n_states, u->n_outputs * sizeof *slopes);
    return 1;
}

/* slopes (order, ny): the derivatives of all outputs with respect to time. */
static int read_slopes(Master *m, size_t order)
{
    memset(m->slopes, 0, order * m->n_outputs * sizeof *m->slopes);
    for (size_t k = 1; k <= order; k++)
        for (size_t r = 0; r < m->n_reads; r++) {
            const size_t subsystem = m->read_order[r];
            const Subsystem *u = &m->subsystems[subsystem];
            double *given = m->scratch, *found = m->slopes + (k - 1) * m->n_outputs + u->first_output;
            for (size_t j = 0; j < k; j++)
                for (size_t i = 0; i < u->n_inputs; i++) given[j * u->n_inputs + i] = driven(m, u->first_input + i, m->slopes + j * m->n_outputs);
            if (u->version == 2) {
                const size_t taken = k < u->order ? k : u->order;
                if (taken && !check(m, subsystem, SET_SLOPES, set_slopes(u, taken, given))) return 0;
                if (!check(m, subsystem, GET_SLOPES, get_slopes(u, k, found))) return 0;
            } else if (!slopes_along(m, subsystem, k, given, found)) {
                return 0;
            }
        }
    return 1;
}

/* The signals into a row of the data, from outputs or from their derivatives. */
static void fill(const Master *m, size_t row, const double *outputs)
{
    for (size_t j = 0; j < m->n_signals; j++) m->data[row * m->n_signals + j] = outputs[m->signal_outputs[j]];
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
    memcpy(m->data + m->rates_at, m->rates, (m->n_data - m->n_free - m->rates_at) * sizeof *m->data);
    for (size_t i = 0; i < m->n_free; i++)
        m->data[m->n_data - m->n_free + i] = (external[m->row + m->free_inputs[i]] - external[m->free_inputs[i]]) / m->step_size;
    return 1;
}

/* product (rows, rounded up to whole blocks) = blocks (rows / BLOCK, n, BLOCK) data[columns]: the sums of a block are independent. */
static void multiply(const double *restrict blocks, size_t rows, size_t n, const size_t *restrict columns, const double *restrict data, double *restrict product)
{
    for (size_t i = 0; i < rows; i += BLOCK) {
        double a = 0, b = 0, c = 0, d = 0;
        for (size_t j = 0; j < n; j++, blocks += BLOCK) {
            const double factor = data[columns[j]];
            a += blocks[0] * factor, b += blocks[1] * factor, c += blocks[2] * factor, d += blocks[3] * factor;
        }
        product[i] = a, product[i + 1] = b, product[i + 2] = c, product[i + 3] = d;
    }
}

/* The coefficients of a subsystem's inputs up to the order that is returned, and what they are at the end of the step. */
static size_t polynomials(Master *m, size_t k, int first_pass, const double *external)
{
    const Subsystem *u = &m->subsystems[k];
    const Matrix *x = first_pass ? &u->guess : &u->final;
    const size_t n = u->n_inputs, i0 = u->first_input;
    const double scale = u->path ? 1 : m->step_size;
    double *c = u->coefficients;
    size_t order = x->order;
    if (u->like == k) multiply(x->blocks, (order + 1) * n, x->n_columns, x->columns, m->data, c);
    for (size_t i = 0; i < n; i++) {
        if (m->wire_start[i0 + i] < m->wire_start[i0 + i + 1]) continue;
        const double first = external[i0 + i], change = external[m->row + i0 + i] - first;
        if (change != 0 && order == 0 && u->order > 0) memset(c + n, 0, n * sizeof *c), order = 1;
        c[i] = u->order ? first : first + change / 2;
        if (order) c[n + i] = change / scale;
    }
    double powers[4] = {1, 1, 1, 1};
    for (size_t j = 1; j <= order && !u->path; j++) powers[j] = powers[j - 1] * m->step_size / (double)j;
    for (size_t i = 0; i < n; i++) {
        double end = c[i];
        for (size_t j = 1; j <= order; j++) end += powers[j] * c[j * n + i];
        m->end_inputs[i0 + i] = end;
    }
    return order;
}

static int step_subsystem(Master *m, size_t k, int first_pass, const double *external)
{
    Subsystem *u = &m->subsystems[k];
    const size_t n = u->n_inputs;
    const size_t highest = polynomials(m, k, first_pass, external);
    if (!check(m, k, SET, set_values(u, u->knowns + u->n_states, n, u->coefficients))) return 0;
    if (u->path) {
        memset(u->coefficients + (highest + 1) * n, 0, (3 - highest) * n * sizeof *u->coefficients);
        u->path->begin = m->time, u->path->step = m->step_size;
    } else if (highest && !check(m, k, SET_SLOPES, set_slopes(u, highest, u->coefficients + n))) {
        return 0;
    }
    return check(m, k, STEP, do_step(u, m->time, m->step_size));
}

static int step_all(Master *m, int first_pass, const double *external)
{
    for (size_t k = 0; k < m->n_subsystems; k++) {
        Subsystem *u = &m->subsystems[k];
        if (!step_subsystem(m, k, first_pass, external)) return 0;
        if (m->sequential) { /* the next subsystem receives the new outputs of this one */
            if (!check(m, k, SET, set_values(u, u->knowns + u->n_states, u->n_inputs, m->end_inputs + u->first_input)) || !get_outputs(m, k)) return 0;
            for (size_t j = 0; j < m->n_signals; j++)
                if (m->signal_outputs[j] >= u->first_output && m->signal_outputs[j] < u->first_output + u->n_outputs)
                    m->data[m->end_rows[0] * m->n_signals + j] = m->now[m->signal_outputs[j]];
        }
    }
    return 1;
}

/* Repeats the step until the outputs at its end agree with the inputs that it was made with. */
static int iterate(Master *m, const double *external)
{
    const double *after = external + m->row;
    const size_t first = m->end_rows[0] * m->n_signals, n = m->n_ends * m->n_signals;
    for (size_t k = 0; k < m->n_subsystems; k++)
        if (!check(m, k, SAVE, save(&m->subsystems[k]))) return 0;
    for (int pass = 0; pass < m->passes; pass++) {
        double largest = 0, moved = 0;
        if (!step_all(m, pass == 0, external) || !read_outputs(m, after)) return 0;
        memcpy(m->former, m->data + first, n * sizeof *m->data);
        if (!fill_rows(m, m->end_rows, m->end_derivatives, m->n_ends, after)) return 0;
        for (size_t i = 0; i < n; i++) {
            largest = larger(largest, magnitude(m->data[first + i]));
            moved = larger(moved, magnitude(m->data[first + i] - m->former[i]));
        }
        if (pass > 0 && moved <= m->converged * largest) return 1;
        for (size_t k = 0; k < m->n_subsystems; k++)
            if (!check(m, k, RESTORE, restore(&m->subsystems[k]))) return 0;
    }
    m->status = -1;
    return 0;
}

/* Whether the sums that drive inputs differ from their prediction by more than the share `missed`. */
static int has_missed(const Master *m)
{
    double largest = 0, off = 0;
    multiply(m->expected.blocks, m->n_expected, m->expected.n_columns, m->expected.columns, m->data, m->change);
    for (size_t j = 0; j < m->n_expected; j++) {
        const size_t input = m->expected_inputs[j];
        double found = 0;
        for (size_t w = m->wire_start[input]; w < m->wire_start[input + 1]; w++) found += m->now[m->sources[w]] - m->data[m->wires[w]];
        largest = larger(largest, magnitude(m->change[j]));
        off = larger(off, magnitude(found - m->change[j]));
    }
    return off > m->missed * largest;
}

/* One step, its outputs to a row of results. 1 when it was made. */
static int advance(Master *m, const double *external, double *outputs)
{
    fill(m, 0, m->now);
    if (m->n_slopes && !fill_rows(m, m->slope_rows, m->slope_derivatives, m->n_slopes, external)) return 0;
    if (m->rates_at && !fill_rates(m, external)) return 0;
    m->now = outputs;
    if (m->iterated ? !iterate(m, external) : !step_all(m, 1, external) || !read_outputs(m, external + m->row)) return 0;
    m->time += m->step_size;
    if (m->n_expected && m->count++ % m->look == 0) m->renew = has_missed(m);
    for (size_t p = m->n_past - 1; p > 0; p--)
        memcpy(m->data + m->past[p] * m->n_signals, m->data + m->past[p - 1] * m->n_signals, m->n_signals * sizeof *m->data);
    return 1;
}

/* n steps: outputs (n, ny) and end_inputs (n, nu) are written; external (n + 1, nu) with `row`
   values from one to the next, 0 where they stay the same. The number of steps made; fewer
   than n when status is no success, or when `renew` asks for another linearisation. */
EXPORT size_t master_run(Master *m, size_t n, const double *external, double *outputs, size_t stride, double *end_inputs)
{
    size_t k = 0;
    m->status = m->renew = 0;
    m->now = m->last;
    if (m->rates_at && !read_outputs(m, external)) return 0; /* for the rates */
    while (k < n && !m->renew) {
        m->end_inputs = end_inputs + k * m->n_inputs;
        if (!advance(m, external + k * m->row, outputs + k * stride)) break;
        k++;
    }
    if (k > 0) memcpy(m->last, outputs + (k - 1) * stride, m->n_outputs * sizeof *outputs);
    return k;
}
