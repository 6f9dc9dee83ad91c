/* What the generated files provide to the runtime: the equations of one component (model.c), and the table of its
   variables (variables.c).

       M(z) x' = f(z),   y = g(z)

   z is the vector of all values in the order of the value references: time, parameters, calculated
   parameters, inputs, states, other outputs, derivatives of the states; after them come numbers computed
   from the parameters, then terms that several functions use. All matrices are stored by rows. */

#ifndef MODEL_H
#define MODEL_H

typedef enum { TIME, FIXED, TUNABLE, CALCULATED, INPUT, STATE, OUTPUT, DERIVATIVE } Role;

typedef struct {
    const char *name;
    const char *unit;
    Role role;
    double start, min, max, nominal;
} Variable;

typedef struct {
    const char *guid;
    unsigned n_variables;                /* value references */
    unsigned n_values;                   /* length of z without the terms */
    unsigned n_terms;
    unsigned n_inputs, n_states, n_outputs;
    unsigned first_input, first_state, first_output, first_derivative; /* references */
    unsigned tolerance;                  /* reference of the solver's tolerance; 0 where there is none */
    unsigned output_order;               /* derivatives of the outputs with respect to time that can be read */
    int exact;                           /* linear while the held inputs are constant */
    int has_mass;                        /* M is not the identity */
    int has_held;
    const unsigned char *held;           /* by input */
    const unsigned *output_references;   /* the outputs in the order of the rows of the Jacobian */
    const Variable *variables;
    void (*parameters)(double *z);
    void (*terms)(double *z);            /* to be called before the functions below */
    void (*rates)(const double *z, double *f);
    void (*mass)(const double *z, double *m);
    void (*outputs)(double *z);
    /* d(f - M x', g)/d(x, u, t), n_states + n_outputs rows, n_states + n_inputs + 1 columns */
    void (*jacobian)(const double *z, const double *rates, double *j);
} Model;

extern const char guid[];
extern const Variable variables[];

extern const Model model;

#endif
