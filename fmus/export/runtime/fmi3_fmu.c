/* The whole FMU of FMI 3.0 as one unit of translation: this file alone is compiled. */

#include "runtime.c"

#include "fmi3.c"
#include "fmi3_absent.c"
#include "fmi3_step.c"
