/* The FMU of FMI 3.0 as one translation unit, except the table of the variables (variables.c). */

#include "runtime.c"

#include "fmi3.c"
#include "fmi3_absent.c"
#include "fmi3_step.c"
