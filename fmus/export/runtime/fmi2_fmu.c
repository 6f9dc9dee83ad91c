/* The whole FMU of FMI 2.0 as one translation unit: only this file is compiled. */

#include "runtime.c"

#include "fmi2.c"
