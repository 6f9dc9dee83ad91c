/* A rider FMU (FMI 2, co-simulation) holds a bar that has been struck: I s' = T_h, delta' = s. Needs nothing but the archive.
 *
 *     unzip -d rider rider_mean_2011.fmu && cc -std=c99 -I rider/sources rider_on_a_bar.c -o rider_on_a_bar -ldl
 *     ./rider_on_a_bar rider 0.6 0.001 1 > run.csv        (folder, kg.m2, step and duration in s)
 *
 * Torque and its slope give the bar's motion over the step, which is set at the rider as polynomials:
 *     delta(t+h) = delta + s h + T h^2/2I + T' h^3/6I,   s(t+h) = s + T h/I + T' h^2/2I */
#include <dlfcn.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include "fmi2Functions.h"

static void stop(const char *what) { fprintf(stderr, "rider_on_a_bar: %s\n", what); exit(1); }
static void logger(fmi2ComponentEnvironment env, fmi2String instance, fmi2Status status, fmi2String category, fmi2String text, ...)
{ (void)env; fprintf(stderr, "%s: %s (status %d, %s)\n", instance, text, status, category); }

/* the value of an attribute in the text after the first `where` */
static char *attribute(const char *xml, const char *where, const char *name) {
    const char *from = strstr(xml, where), *start = from ? strstr(from, name) : NULL;
    if (!start) stop(where);
    start = strchr(start, '"') + 1;
    size_t length = strcspn(start, "\"");
    return memcpy(calloc(length + 1, 1), start, length);
}

int main(int argc, char **argv) {
    if (argc != 5) stop("give FOLDER INERTIA STEP DURATION");
    const double inertia = atof(argv[2]), h = atof(argv[3]), duration = atof(argv[4]);
    static char path[4096], xml[1 << 20];
    snprintf(path, sizeof path, "%s/modelDescription.xml", argv[1]);
    FILE *file = fopen(path, "r");
    if (!file || !fread(xml, 1, sizeof xml - 1, file)) stop(path);
    snprintf(path, sizeof path, "%s/binaries/linux64/%s.so", argv[1], attribute(xml, "<CoSimulation", "modelIdentifier"));
    void *library = dlopen(path, RTLD_NOW);
    if (!library) stop(dlerror());
#define LOAD(name) name##TYPE *name; *(void **)&name = dlsym(library, #name); if (!name) stop(#name)
    LOAD(fmi2Instantiate); LOAD(fmi2SetupExperiment); LOAD(fmi2EnterInitializationMode); LOAD(fmi2ExitInitializationMode);
    LOAD(fmi2SetReal); LOAD(fmi2GetReal); LOAD(fmi2SetRealInputDerivatives); LOAD(fmi2GetRealOutputDerivatives);
    LOAD(fmi2DoStep); LOAD(fmi2Terminate); LOAD(fmi2FreeInstance);
#define CALL(name, ...) if (name(rider, __VA_ARGS__) > fmi2Warning) stop(#name)

    const char *names[] = {"\"steer_angle\"", "\"steer_rate\"", "\"torso_angle\"", "\"torso_rate\"", "\"handlebar_torque\""};
    fmi2ValueReference is[5];
    for (int i = 0; i < 5; i++) is[i] = (fmi2ValueReference)atoi(attribute(xml, names[i], "valueReference"));
    const fmi2ValueReference motion[] = {is[0], is[1], is[0], is[1], is[0]};
    const fmi2Integer order[] = {1, 1, 2, 2, 3};
    const fmi2CallbackFunctions callbacks = {logger, calloc, free, NULL, NULL};
    fmi2Component rider = fmi2Instantiate("rider", fmi2CoSimulation, attribute(xml, "<fmiModelDescription", "guid"), "", &callbacks, fmi2False, fmi2False);
    if (!rider) stop("fmi2Instantiate");
    CALL(fmi2SetupExperiment, fmi2False, 0, 0, fmi2False, 0);
    if (fmi2EnterInitializationMode(rider) > fmi2Warning || fmi2ExitInitializationMode(rider) > fmi2Warning) stop("initialisation");

    double bar[2] = {0, 1}, output[3], slope; /* angle and rate of the bar; it has been struck */
    puts("time [s],steer_angle [rad],steer_rate [rad/s],torso_angle [rad],torso_rate [rad/s],handlebar_torque [N.m]");
    for (long k = 0; k * h < duration + h / 2; k++) {
        CALL(fmi2SetReal, is, 2, bar);
        CALL(fmi2GetReal, is + 2, 3, output);
        printf("%.17g,%.17g,%.17g,%.17g,%.17g,%.17g\n", k * h, bar[0], bar[1], output[0], output[1], output[2]);
        double a = output[2] / inertia, rates[] = {bar[1], a, a, 0, 0};
        CALL(fmi2SetRealInputDerivatives, motion, 2, order, rates);
        CALL(fmi2GetRealOutputDerivatives, is + 4, 1, order, &slope);
        rates[3] = rates[4] = slope / inertia;
        CALL(fmi2SetRealInputDerivatives, motion, 5, order, rates);
        CALL(fmi2DoStep, k * h, h, fmi2True);
        bar[0] += h * (bar[1] + h * (a / 2 + h * rates[4] / 6));
        bar[1] += h * (a + h * rates[4] / 2);
    }
    fmi2Terminate(rider);
    fmi2FreeInstance(rider);
    return 0;
}
