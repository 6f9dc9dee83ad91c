/* The structures that Python fills and the loop in C reads. cffi parses this file as it stands: no preprocessor lines. */

enum { WARNING = 1, STOPPED = 100, ENDED }; /* statuses of FMI; of FMI 3.0: a step ended early, the FMU asks to end */
enum { SET, GET, STEP, SET_SLOPES, GET_SLOPES, SAVE, RESTORE, DIRECTIONAL, CALLS };
enum { BLOCK = 4 }; /* rows of a matrix that are multiplied together */

typedef void (*Function)(void);

/* How the inputs of an FMU of FMI 3.0 move within a step: sum_k c_k s^k, s = (time - begin) / step. */
typedef struct {
    void *instance;
    Function set;
    const unsigned *references;
    size_t n;
    double *coefficients; /* 4 rows of n, then a row for the inputs at a time */
    double begin, step;
} Path;

typedef struct {
    size_t order, n_columns; /* the highest power of time among the rows; the number of columns that are not zero */
    const size_t *columns;   /* the indices of these columns */
    const double *blocks;    /* (rows / BLOCK, n_columns, BLOCK) */
} Matrix;

/* One FMU of FMI 2.0 or 3.0. */
typedef struct {
    void *instance, *saved;
    Path *path; /* NULL: the inputs move by their derivatives, or not at all */
    size_t version;
    Function calls[CALLS];
    size_t n_inputs, n_outputs, n_states, order, first_input, first_output, first_state;
    size_t like;                             /* the first subsystem with the same driven inputs; both share its coefficients */
    double *ended;                           /* the time at which an FMU of FMI 3.0 asks for the end of the simulation */
    double *coefficients;                    /* (4, n_inputs): of the path, else the derivatives with respect to time */
    const unsigned *unknowns, *knowns;       /* rates of the states, then outputs; states, then inputs */
    const unsigned *slope_inputs;            /* the inputs, once for each order */
    const int *slope_orders, *output_orders; /* order k of all inputs, of all outputs, one row after the other */
    Matrix guess, final;                     /* from the data to the inputs' polynomials, in the first pass and in later ones */
} Subsystem;

typedef struct {
    size_t n_subsystems, n_inputs, n_outputs, n_signals, n_data;
    Subsystem *subsystems;
    const size_t *signal_outputs;               /* of each signal its place among the outputs */
    const size_t *wire_start, *wires, *sources; /* the signals that sum to an input, and the outputs that these are */
    const size_t *read_order, *sets_inputs;     /* subsystems in the order of reading; whether their inputs are set before */
    const size_t *rates_too, *unsettled;        /* whether the states' rates are read as well; see fmus/cosimulation/network.py */
    size_t n_reads, n_unsettled;
    const size_t *past;                           /* rows of the data, the present one first */
    const size_t *slope_rows, *slope_derivatives; /* of the present */
    const size_t *end_rows, *end_derivatives;
    size_t n_past, n_slopes, n_ends;
    const size_t *free_inputs; /* whose slopes are data */
    size_t rates_at, n_free;   /* place of the rates among the data; 0: no rates are needed */
    size_t n_expected;
    Matrix expected;              /* expected changes of sums of signals */
    const size_t *expected_inputs; /* those sums, as the inputs that they drive */
    double missed, converged, step_size, time;
    int sequential, iterated, passes;
    size_t row, look, count; /* doubles from one row of external inputs to the next; the expectation is compared every look-th step */
    double *data, *last, *now, *end_inputs, *slopes, *scratch, *former, *rates, *change;
    size_t failed_subsystem; /* with the status and the call that failed */
    int status, call, renew;
} Master;

EXPORT size_t master_run(Master *m, size_t n, const double *external, double *outputs, size_t stride, double *end_inputs);
EXPORT void move_inputs(void *environment, double time, bool set_requested, bool get_allowed, bool finished, bool may_return,
                        bool *return_requested, double *return_time);
