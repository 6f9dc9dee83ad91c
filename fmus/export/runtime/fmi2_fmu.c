/* The FMU of FMI 2.0 as one translation unit, except the table of the variables (variables.c). */

#include "runtime.c"

#include "fmi2.c"
