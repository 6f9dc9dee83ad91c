/* The whole FMU of FMI 3.0 as one translation unit: only this file is compiled. */

#include "runtime.c"

#include "fmi3.c"
#include "fmi3_absent.c"
#include "fmi3_step.c"
