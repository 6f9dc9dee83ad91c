/* The whole FMU of FMI 3.0 for WebAssembly as one translation unit: the functions of FMI in C, and the interface of
   fmi-ls-wasm on top of them. */

#include "fmi3_fmu.c"

#include "fmi3_component.c"
