/* Drives every function of FMI 3.0 out of order and with wrong arguments. To be compiled with the sources of an FMU
   under the sanitisers: misuse3 TOKEN VARIABLES CALLS SEED. Prints how many calls succeeded, how many were refused, and how many steps were done. */

#include "fmi3Functions.h"
#include "random_values.h"

static unsigned long counts[6], steps;
static fmi3Instance instance;
static fmi3Float64 now;
static unsigned n_variables;

static void log_message(fmi3InstanceEnvironment environment, fmi3Status status, fmi3String category, fmi3String message)
{
    (void)environment, (void)status;
    if (!category || !*message) abort();
}

/* An importer that does what it should not in the middle of a step. */
static void update(fmi3InstanceEnvironment environment, fmi3Float64 time, fmi3Boolean set, fmi3Boolean get, fmi3Boolean finished, fmi3Boolean can_return,
                   fmi3Boolean *requested, fmi3Float64 *wanted)
{
    unsigned references[MOST];
    double values[MOST];
    int orders[MOST];
    fmi3FMUState state = NULL;
    fmi3Boolean flags[3];
    (void)environment, (void)time, (void)set, (void)get, (void)finished, (void)can_return;
    fill(references, values, orders, n_variables);
    fmi3SetFloat64(instance, references, 1, values, 1);
    fmi3GetFloat64(instance, references, 2, values, 2);
    if (rarely()) fmi3DoStep(instance, now, 0.01, 1, flags, flags + 1, flags + 2, values);
    if (rarely()) fmi3Reset(instance), fmi3Terminate(instance), fmi3GetFMUState(instance, &state);
    if (rarely()) *requested = 1, *wanted = number();
}

static fmi3Instance make(const char *token)
{
    static const fmi3ValueReference required[] = {0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15, 16, 17, 18, 19, 20, 30, 31, 32, 33, 34, 35, 4000000};
    const char *name = rarely() ? NULL : "instance", *given = rarely() ? "wrong" : token;
    const size_t n = rarely() ? 0 : sizeof required / sizeof required[0];
    if (below(3) == 0) return fmi3InstantiateModelExchange(name, given, NULL, 0, below(2), NULL, rarely() ? NULL : log_message);
    if (rarely()) return fmi3InstantiateScheduledExecution(name, given, NULL, 0, 1, NULL, log_message, NULL, NULL, NULL);
    return fmi3InstantiateCoSimulation(name, given, NULL, 0, below(2), rarely(), below(2), required, n, NULL, rarely() ? NULL : log_message, below(2) ? update : NULL);
}

static fmi3Status one_call(const char *token, unsigned n, fmi3FMUState *slots, fmi3Byte *bytes, size_t *stored)
{
    static const fmi3String categories[] = {"logAll", "logStatusError", "nothing", NULL};
    unsigned references[MOST], others[MOST];
    double values[MOST], results[MOST];
    int orders[MOST];
    fmi3Boolean flags[6];
    fmi3Int32 integers[MOST] = {0};
    fmi3Clock clocks[MOST] = {0};
    const size_t many = below(MOST), few = below(4);
    fmi3FMUState *slot = &slots[below(SLOTS)];
    size_t size = 0;
    fill(references, values, orders, n);
    fill(others, results, orders, n);
    const fmi3ValueReference *vr = rarely() ? NULL : references;
    double *out = rarely() ? NULL : results;
    const double *in = rarely() ? NULL : values;
    fmi3Instance c = rarely() ? NULL : instance;
    switch (below(36)) {
    case 0:
        if (below(50)) return fmi3OK;
        fmi3FreeInstance(instance);
        for (unsigned i = 0; i < SLOTS; i++) slots[i] = NULL;
        now = 0;
        instance = make(token);
        return instance ? fmi3OK : fmi3Error;
    case 1: return fmi3SetDebugLogging(c, below(2), few, rarely() ? NULL : categories);
    case 2: case 3: return now = 0, fmi3EnterInitializationMode(c, below(8) == 0, values[0], 0, below(8) == 0, values[1]);
    case 4: case 5: return fmi3ExitInitializationMode(c);
    case 6: return below(10) ? fmi3OK : fmi3Terminate(c);
    case 7: return below(4) ? fmi3OK : (now = 0, fmi3Reset(c));
    case 8: case 9: case 10: return fmi3GetFloat64(c, vr, many, out, rarely() ? few : many);
    case 11: case 12: case 13: return fmi3SetFloat64(c, vr, few, in, rarely() ? many : few);
    case 14: return fmi3GetInt32(c, vr, few, integers, few), fmi3SetInt32(c, vr, few, integers, few), fmi3GetBoolean(c, vr, few, clocks, few);
    case 15: return fmi3GetClock(c, vr, few, clocks), fmi3SetClock(c, vr, few, clocks), fmi3GetShiftDecimal(c, vr, few, out);
    case 16: return fmi3GetString(c, vr, few, NULL, few), fmi3GetBinary(c, vr, few, NULL, NULL, few), fmi3GetFloat32(c, vr, few, NULL, few);
    case 17: return fmi3GetFMUState(c, rarely() ? NULL : slot);
    case 18: return fmi3SetFMUState(c, rarely() ? (fmi3FMUState)values : *slot);
    case 19: {
        fmi3FMUState wild = values;
        return fmi3FreeFMUState(c, rarely() ? &wild : slot);
    }
    case 20: return fmi3SerializedFMUStateSize(c, *slot, rarely() ? NULL : &size);
    case 21: return fmi3SerializeFMUState(c, *slot, bytes, *stored = below(10000));
    case 22:
        if (rarely()) bytes[below(200)] ^= (fmi3Byte)(1u << below(7));
        if (c && *slot && fmi3SerializedFMUStateSize(c, *slot, &size) == fmi3OK && size < 10000) fmi3SerializeFMUState(c, *slot, bytes, *stored = size);
        return fmi3DeserializeFMUState(c, bytes, *stored, slot);
    case 23: return fmi3GetDirectionalDerivative(c, vr, few, others, 2, in, rarely() ? few : 2, out, few);
    case 24: return fmi3GetAdjointDerivative(c, vr, few, others, 2, in, rarely() ? 2 : few, out, 2);
    case 25: return fmi3GetOutputDerivatives(c, vr, few, orders, out, few);
    case 26: case 27: case 28: {
        fmi3Float64 last = now;
        const fmi3Status status = fmi3DoStep(c, rarely() ? number() : now, step_size(), 1, flags, flags + 1, flags + 2, rarely() ? NULL : &last);
        now = last;
        steps += status == fmi3OK;
        return status;
    }
    case 29: return fmi3EnterStepMode(c), fmi3EnterConfigurationMode(c), fmi3ExitConfigurationMode(c), fmi3EvaluateDiscreteStates(c);
    case 30: return fmi3EnterEventMode(c);
    case 31: return fmi3EnterContinuousTimeMode(c);
    case 32: return fmi3UpdateDiscreteStates(c, flags, flags + 1, flags + 2, flags + 3, flags + 4, rarely() ? NULL : results);
    case 33: return fmi3CompletedIntegratorStep(c, 1, flags, rarely() ? NULL : flags + 1);
    case 34: return fmi3SetTime(c, number()), fmi3SetContinuousStates(c, in, few), fmi3GetContinuousStates(c, out, few);
    default:
        fmi3GetNumberOfContinuousStates(c, &size), fmi3GetNumberOfEventIndicators(c, rarely() ? NULL : &size);
        return fmi3GetContinuousStateDerivatives(c, out, few), fmi3GetNominalsOfContinuousStates(c, out, few), fmi3GetEventIndicators(c, out, few);
    }
}

/* After an error an instance refuses nearly everything: now and then it is reset, initialised and stepped, so that calls
   reach the inside of the functions again. An instance for model exchange refuses the first step. */
static void recover(void)
{
    if (!instance || !below(3)) return;
    now = 0;
    if (fmi3Reset(instance) != fmi3OK || fmi3EnterInitializationMode(instance, 0, 0, 0, 0, 0) != fmi3OK) abort();
    if (!below(8)) return;
    if (fmi3ExitInitializationMode(instance) != fmi3OK) abort();
    fmi3Boolean flags[3];
    for (unsigned i = below(4); i; i--) {
        if (fmi3DoStep(instance, now, 0.002, 1, flags, flags + 1, flags + 2, &now) != fmi3OK) return;
        steps++;
    }
}

int main(int argc, char **argv)
{
    if (argc < 5) return 2;
    n_variables = (unsigned)atoi(argv[2]);
    const unsigned long calls = strtoul(argv[3], NULL, 10);
    fmi3FMUState slots[SLOTS] = {NULL};
    static fmi3Byte bytes[10000];
    size_t stored = 0;
    seed = 88172645463325252u + (uint64_t)atoi(argv[4]);
    for (unsigned long i = 0; i < calls; i++) {
        const fmi3Status status = one_call(argv[1], n_variables, slots, bytes, &stored);
        counts[status]++;
        if (status == fmi3Error) recover();
    }
    fmi3FreeInstance(instance);
    printf("ok %lu discard %lu error %lu steps %lu\n", counts[fmi3OK], counts[fmi3Discard], counts[fmi3Error], steps);
    return 0;
}
