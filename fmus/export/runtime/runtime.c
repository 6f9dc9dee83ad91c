/* The model and the runtime without the functions of FMI. In one translation unit the compiler knows the model's
   sizes at compile time. */

#include "model.c"

#include "linear_algebra.c"

#include "instance.c"
#include "snapshot.c"
#include "derivatives.c"
#include "exact_step.c"
#include "rosenbrock.c"
#include "step.c"

#include "call.c"
