/* The whole FMU of FMI 2.0 as one unit of translation: this file alone is compiled. */

#include "runtime.c"

#include "fmi2.c"
