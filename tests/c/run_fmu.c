/* Loads the shared library of an FMU (FMI 2.0) on whatever platform this runs, drives its inputs, prints its outputs.
   run_fmu LIBRARY GUID STEPS INPUTS... -- OUTPUTS...   (value references) */

#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "fmi2Functions.h"

#ifdef _WIN32
#include <windows.h>
static void *load(const char *path) { return (void *)LoadLibraryA(path); }
static void *find(void *library, const char *name) { return (void *)GetProcAddress((HMODULE)library, name); }
#else
#include <dlfcn.h>
static void *load(const char *path) { return dlopen(path, RTLD_NOW | RTLD_LOCAL); }
static void *find(void *library, const char *name) { return dlsym(library, name); }
#endif

static void logger(fmi2ComponentEnvironment environment, fmi2String name, fmi2Status status, fmi2String category, fmi2String message, ...)
{
    (void)environment, (void)name, (void)status, (void)category;
    fprintf(stderr, "%s\n", message);
}

#define FUNCTION(name) name##TYPE *name##_ = (name##TYPE *)find(library, #name)

int main(int argc, char **argv)
{
    fmi2ValueReference references[64];
    fmi2Real values[64] = {0};
    unsigned n_inputs = 0, n_all = 0;
    if (argc < 5) return 2;
    for (int i = 4; i < argc && n_all < 64; i++) {
        if (strcmp(argv[i], "--") == 0) n_inputs = n_all;
        else references[n_all++] = (fmi2ValueReference)strtoul(argv[i], NULL, 10);
    }
    void *library = load(argv[1]);
    if (!library) return 3;
    FUNCTION(fmi2Instantiate);
    FUNCTION(fmi2SetupExperiment);
    FUNCTION(fmi2EnterInitializationMode);
    FUNCTION(fmi2ExitInitializationMode);
    FUNCTION(fmi2SetReal);
    FUNCTION(fmi2GetReal);
    FUNCTION(fmi2DoStep);
    FUNCTION(fmi2FreeInstance);
    const fmi2CallbackFunctions callbacks = {logger, calloc, free, NULL, NULL};
    fmi2Component c = fmi2Instantiate_("instance", fmi2CoSimulation, argv[2], NULL, &callbacks, 0, 1);
    if (!c) return 4;
    fmi2SetupExperiment_(c, 0, 0, 0, 0, 0);
    fmi2EnterInitializationMode_(c);
    fmi2ExitInitializationMode_(c);
    for (int step = 0; step < atoi(argv[3]); step++) {
        for (unsigned i = 0; i < n_inputs; i++) values[i] = 1 + (double)((step * 7 + (int)i * 3) % 11) / 16;
        if (fmi2SetReal_(c, references, n_inputs, values) != fmi2OK || fmi2DoStep_(c, step / 128.0, 1 / 128.0, 1) != fmi2OK) return 5;
    }
    fmi2GetReal_(c, references + n_inputs, n_all - n_inputs, values);
    for (unsigned i = 0; i < n_all - n_inputs; i++) printf("%.17g\n", values[i]);
    fmi2FreeInstance_(c);
    return 0;
}
