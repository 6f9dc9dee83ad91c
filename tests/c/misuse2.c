/* Drives every function of FMI 2.0 out of order and with wrong arguments. To be compiled with the sources of an FMU
   under the sanitisers: misuse2 GUID VARIABLES CALLS SEED. Prints how many calls succeeded, how many were refused, and how many steps were done. */

#include "fmi2Functions.h"
#include "random_values.h"

static unsigned long counts[6], steps;

static void logger(fmi2ComponentEnvironment environment, fmi2String name, fmi2Status status, fmi2String category, fmi2String message, ...)
{
    char text[600];
    va_list arguments;
    (void)environment, (void)status, (void)category;
    va_start(arguments, message);
    vsnprintf(text, sizeof text, message, arguments); /* as importers do: a stray percent sign would be undefined */
    va_end(arguments);
    if (!name || !*text) abort();
}

static fmi2Component component;
static fmi2Real now;

static fmi2Status one_call(const char *guid, unsigned n, fmi2FMUstate *slots, fmi2Byte *bytes, size_t *stored)
{
    static const fmi2CallbackFunctions callbacks = {logger, calloc, free, NULL, NULL};
    static const fmi2String categories[] = {"logAll", "logStatusError", "nothing", NULL};
    unsigned references[MOST], others[MOST];
    double values[MOST], results[MOST];
    int orders[MOST];
    const size_t many = below(MOST), few = below(4);
    fmi2FMUstate *slot = &slots[below(SLOTS)];
    fmi2Boolean flags[2];
    fmi2EventInfo info;
    fmi2Status status = fmi2OK;
    size_t size = 0;
    fill(references, values, orders, n);
    fill(others, results, orders, n);
    const fmi2ValueReference *vr = rarely() ? NULL : references;
    double *out = rarely() ? NULL : results;
    const double *in = rarely() ? NULL : values;
    fmi2Component c = rarely() ? NULL : component;
    switch (below(44)) {
    case 0:
        if (below(50)) return fmi2OK;
        fmi2FreeInstance(component);
        for (unsigned i = 0; i < SLOTS; i++) slots[i] = NULL;
        component = fmi2Instantiate(rarely() ? NULL : "instance", rarely() ? (fmi2Type)7 : (fmi2Type)below(2), rarely() ? "wrong" : guid, NULL, rarely() ? NULL : &callbacks, 0, (int)below(2));
        return component ? fmi2OK : fmi2Error;
    case 1: return fmi2SetDebugLogging(c, (int)below(2), few, rarely() ? NULL : categories);
    case 2: return fmi2SetupExperiment(c, below(8) == 0, values[0], now = 0, below(8) == 0, values[1]);
    case 3: case 4: return fmi2EnterInitializationMode(c);
    case 5: case 6: return fmi2ExitInitializationMode(c);
    case 7: return below(10) ? fmi2OK : fmi2Terminate(c);
    case 8: return below(4) ? fmi2OK : (now = 0, fmi2Reset(c));
    case 9: case 10: case 11: return fmi2GetReal(c, vr, many, out);
    case 12: case 13: case 14: return fmi2SetReal(c, vr, few, in);
    case 15: return fmi2GetInteger(c, vr, few, orders);
    case 16: return fmi2GetBoolean(c, vr, few, orders);
    case 17: return fmi2GetString(c, vr, few, NULL);
    case 18: return fmi2SetInteger(c, vr, few, orders);
    case 19: return fmi2SetBoolean(c, vr, few, orders);
    case 20: return fmi2SetString(c, vr, few, NULL);
    case 21: return fmi2GetFMUstate(c, rarely() ? NULL : slot);
    case 22: return fmi2SetFMUstate(c, rarely() ? (fmi2FMUstate)values : *slot);
    case 23: {
        fmi2FMUstate wild = values;
        return fmi2FreeFMUstate(c, rarely() ? &wild : slot);
    }
    case 24: return fmi2SerializedFMUstateSize(c, *slot, rarely() ? NULL : &size);
    case 25:
        status = fmi2SerializeFMUstate(c, *slot, bytes, *stored = below(10000));
        return status;
    case 26:
        if (rarely()) bytes[below(200)] ^= (fmi2Byte)(1u << below(7));
        if (c && *slot && fmi2SerializedFMUstateSize(c, *slot, &size) == fmi2OK && size < 10000) fmi2SerializeFMUstate(c, *slot, bytes, *stored = size);
        return fmi2DeSerializeFMUstate(c, bytes, *stored, slot);
    case 27: case 28: return fmi2GetDirectionalDerivative(c, vr, few, rarely() ? NULL : others, below(4), in, out);
    case 29: return fmi2SetRealInputDerivatives(c, vr, few, orders, in);
    case 30: return fmi2GetRealOutputDerivatives(c, vr, few, orders, out);
    case 31: case 32: case 33: {
        const double h = step_size();
        status = fmi2DoStep(c, rarely() ? number() : now, h, 1);
        steps += status == fmi2OK;
        if (component) fmi2GetRealStatus(component, fmi2LastSuccessfulTime, &now);
        return status;
    }
    case 34: return fmi2CancelStep(c);
    case 35: return fmi2GetStatus(c, fmi2DoStepStatus, &status), fmi2GetIntegerStatus(c, fmi2PendingStatus, orders), fmi2GetStringStatus(c, fmi2PendingStatus, NULL);
    case 36: return fmi2GetBooleanStatus(c, (fmi2StatusKind)below(4), rarely() ? NULL : flags);
    case 37: return fmi2EnterEventMode(c);
    case 38: return fmi2EnterContinuousTimeMode(c);
    case 39: return fmi2NewDiscreteStates(c, rarely() ? NULL : &info);
    case 40: return fmi2CompletedIntegratorStep(c, 1, flags, rarely() ? NULL : flags + 1);
    case 41: return fmi2SetTime(c, number()), fmi2SetContinuousStates(c, in, few);
    case 42: return fmi2GetDerivatives(c, out, few), fmi2GetContinuousStates(c, out, few);
    default: return fmi2GetNominalsOfContinuousStates(c, out, few), fmi2GetEventIndicators(c, out, few);
    }
}

/* After an error an instance refuses nearly everything: now and then it is reset, initialised and stepped, so that calls
   reach the inside of the functions again. An instance for model exchange refuses the first step. */
static void recover(void)
{
    if (!component || !below(3)) return;
    now = 0;
    if (fmi2Reset(component) != fmi2OK || fmi2EnterInitializationMode(component) != fmi2OK) abort();
    if (!below(8)) return;
    if (fmi2ExitInitializationMode(component) != fmi2OK) abort();
    for (unsigned i = below(4); i && fmi2DoStep(component, now, 0.002, 1) == fmi2OK; i--) now += 0.002, steps++;
}

int main(int argc, char **argv)
{
    if (argc < 5) return 2;
    const unsigned n = (unsigned)atoi(argv[2]);
    const unsigned long calls = strtoul(argv[3], NULL, 10);
    fmi2FMUstate slots[SLOTS] = {NULL};
    static fmi2Byte bytes[10000];
    size_t stored = 0;
    seed = 88172645463325252u + (uint64_t)atoi(argv[4]);
    for (unsigned long i = 0; i < calls; i++) {
        const fmi2Status status = one_call(argv[1], n, slots, bytes, &stored);
        counts[status]++;
        if (status == fmi2Error) recover();
    }
    fmi2FreeInstance(component);
    printf("ok %lu discard %lu error %lu steps %lu\n", counts[fmi2OK], counts[fmi2Discard], counts[fmi2Error], steps);
    return 0;
}
