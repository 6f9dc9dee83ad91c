/* The model and the runtime without the functions of FMI. In one unit of translation the compiler knows the sizes of
   the model where they are used. */

#include "model.c"

#include "linear_algebra.c"

#include "instance.c"
#include "snapshot.c"
#include "derivatives.c"
#include "exact_step.c"
#include "rosenbrock.c"
#include "step.c"

#include "call.c"
