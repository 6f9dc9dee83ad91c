/* The functions of FMI 3.0 that model exchange and co-simulation share, on one instance of the model.

   Each lists the phases in which it may be called; a call in another phase is refused and changes nothing. */

#include <stdlib.h>

#include "fmi3_host.h"

fmi3Status as_fmi3(Status status)
{
    static const fmi3Status statuses[] = {fmi3OK, fmi3Warning, fmi3Discard, fmi3Error};
    return statuses[status];
}

static void log_message(Instance *s, Status status, const char *message)
{
    const Host *host = s->host;
    if (host->log && is_logged(s, status)) host->log(host->environment, as_fmi3(status), category_of(status), message);
}

/* Creation ------------------------------------------------------------------------------------------------- */

const char *fmi3GetVersion(void) { return fmi3Version; }

static fmi3Instance instantiate(fmi3String name, fmi3String token, fmi3Boolean logging, const char *wrong, Host given)
{
    if (!wrong) wrong = refused_identity(name, token);
    Host *host = wrong ? NULL : malloc(sizeof *host);
    Instance *s = host ? instance_new(name, log_message, host) : NULL;
    if (!s) {
        free(host);
        if (given.log) given.log(given.environment, fmi3Error, category_of(ERROR), wrong ? wrong : "out of memory for an instance");
        return NULL;
    }
    *host = given;
    choose_categories(s, logging, 0, NULL);
    return s;
}

fmi3Instance fmi3InstantiateModelExchange(fmi3String instanceName, fmi3String instantiationToken, fmi3String resourcePath, fmi3Boolean visible,
                                          fmi3Boolean loggingOn, fmi3InstanceEnvironment instanceEnvironment, fmi3LogMessageCallback logMessage)
{
    (void)resourcePath, (void)visible;
    const Host host = {instanceEnvironment, logMessage, NULL, 1, 0};
    return instantiate(instanceName, instantiationToken, loggingOn, NULL, host);
}

static int has_input(const fmi3ValueReference references[], size_t n)
{
    for (size_t i = 0; references && i < n; i++)
        if (references[i] < model.n_variables && model.variables[references[i]].role == INPUT) return 1;
    return 0;
}

fmi3Instance fmi3InstantiateCoSimulation(fmi3String instanceName, fmi3String instantiationToken, fmi3String resourcePath, fmi3Boolean visible,
                                         fmi3Boolean loggingOn, fmi3Boolean eventModeUsed, fmi3Boolean earlyReturnAllowed,
                                         const fmi3ValueReference requiredIntermediateVariables[], size_t nRequiredIntermediateVariables,
                                         fmi3InstanceEnvironment instanceEnvironment, fmi3LogMessageCallback logMessage,
                                         fmi3IntermediateUpdateCallback intermediateUpdate)
{
    (void)resourcePath, (void)visible;
    const int moves = intermediateUpdate && has_input(requiredIntermediateVariables, nRequiredIntermediateVariables);
    const Host host = {instanceEnvironment, logMessage, moves ? intermediateUpdate : NULL, 0, earlyReturnAllowed};
    const char *wrong = eventModeUsed ? "event mode was asked for, which this model does not have in co-simulation" : NULL;
    return instantiate(instanceName, instantiationToken, loggingOn, wrong, host);
}

fmi3Instance fmi3InstantiateScheduledExecution(fmi3String instanceName, fmi3String instantiationToken, fmi3String resourcePath, fmi3Boolean visible,
                                               fmi3Boolean loggingOn, fmi3InstanceEnvironment instanceEnvironment, fmi3LogMessageCallback logMessage,
                                               fmi3ClockUpdateCallback clockUpdate, fmi3LockPreemptionCallback lockPreemption,
                                               fmi3UnlockPreemptionCallback unlockPreemption)
{
    (void)resourcePath, (void)visible, (void)clockUpdate, (void)lockPreemption, (void)unlockPreemption;
    const Host host = {instanceEnvironment, logMessage, NULL, 0, 0};
    return instantiate(instanceName, instantiationToken, loggingOn, "scheduled execution is not offered by this model", host);
}

void fmi3FreeInstance(fmi3Instance instance)
{
    Instance *s = instance;
    if (!s) return;
    free(s->host);
    instance_free(s);
}

fmi3Status fmi3SetDebugLogging(fmi3Instance instance, fmi3Boolean loggingOn, size_t nCategories, const fmi3String names[])
{
    Instance *s = called(instance, "fmi3SetDebugLogging", ANY, nCategories == 0 || names);
    return s ? as_fmi3(choose_categories(s, loggingOn, nCategories, names)) : fmi3Error;
}

/* Phases --------------------------------------------------------------------------------------------------- */

fmi3Status fmi3EnterInitializationMode(fmi3Instance instance, fmi3Boolean toleranceDefined, fmi3Float64 tolerance, fmi3Float64 startTime,
                                       fmi3Boolean stopTimeDefined, fmi3Float64 stopTime)
{
    Instance *s = called(instance, "fmi3EnterInitializationMode", INSTANTIATED, 1);
    if (!s) return fmi3Error;
    const Status status = set_experiment(s, toleranceDefined, tolerance, startTime, stopTimeDefined, stopTime);
    if (status == OK) enter(s, INITIALIZING);
    return as_fmi3(status);
}

fmi3Status fmi3ExitInitializationMode(fmi3Instance instance)
{
    Instance *s = called(instance, "fmi3ExitInitializationMode", INITIALIZING, 1);
    if (!s) return fmi3Error;
    enter(s, ((const Host *)s->host)->exchange ? EVENT : STEPPING);
    return fmi3OK;
}

fmi3Status fmi3Terminate(fmi3Instance instance) { return as_fmi3(change_phase(instance, "fmi3Terminate", RUNNING, TERMINATED)); }

fmi3Status fmi3Reset(fmi3Instance instance)
{
    Instance *s = called(instance, "fmi3Reset", ANY, 1);
    if (!s) return fmi3Error;
    instance_reset(s);
    return fmi3OK;
}

/* Values --------------------------------------------------------------------------------------------------- */

static Status same_number(Instance *s, const char *function, size_t n_references, size_t n_values)
{
    return n_references == n_values ? OK : report(s, ERROR, "%s: %lu values for %lu scalar variables", function, (unsigned long)n_values, (unsigned long)n_references);
}

fmi3Status fmi3GetFloat64(fmi3Instance instance, const fmi3ValueReference vr[], size_t nvr, fmi3Float64 values[], size_t nValues)
{
    Instance *s = called(instance, "fmi3GetFloat64", ANY | INTERMEDIATE, nvr == 0 || (vr && values));
    if (!s || same_number(s, "fmi3GetFloat64", nvr, nValues) != OK) return fmi3Error;
    return as_fmi3(get_values(s, vr, nvr, values));
}

fmi3Status fmi3SetFloat64(fmi3Instance instance, const fmi3ValueReference vr[], size_t nvr, const fmi3Float64 values[], size_t nValues)
{
    Instance *s = called(instance, "fmi3SetFloat64", SOUND | INTERMEDIATE, nvr == 0 || (vr && values));
    if (!s || same_number(s, "fmi3SetFloat64", nvr, nValues) != OK) return fmi3Error;
    return as_fmi3(set_values(s, vr, nvr, values));
}

/* State of the FMU ----------------------------------------------------------------------------------------- */

fmi3Status fmi3GetFMUState(fmi3Instance instance, fmi3FMUState *FMUState) { return as_fmi3(take_state(instance, "fmi3GetFMUState", FMUState)); }

fmi3Status fmi3SetFMUState(fmi3Instance instance, fmi3FMUState FMUState) { return as_fmi3(restore_state(instance, "fmi3SetFMUState", FMUState)); }

fmi3Status fmi3FreeFMUState(fmi3Instance instance, fmi3FMUState *FMUState) { return as_fmi3(free_state(instance, "fmi3FreeFMUState", FMUState)); }

fmi3Status fmi3SerializedFMUStateSize(fmi3Instance instance, fmi3FMUState FMUState, size_t *size)
{
    return as_fmi3(size_of_state(instance, "fmi3SerializedFMUStateSize", FMUState, size));
}

fmi3Status fmi3SerializeFMUState(fmi3Instance instance, fmi3FMUState FMUState, fmi3Byte bytes[], size_t size)
{
    return as_fmi3(write_state(instance, "fmi3SerializeFMUState", FMUState, bytes, size));
}

fmi3Status fmi3DeserializeFMUState(fmi3Instance instance, const fmi3Byte bytes[], size_t size, fmi3FMUState *FMUState)
{
    return as_fmi3(read_state(instance, "fmi3DeserializeFMUState", bytes, size, FMUState));
}

/* Derivatives ---------------------------------------------------------------------------------------------- */

fmi3Status fmi3GetDirectionalDerivative(fmi3Instance instance, const fmi3ValueReference unknowns[], size_t nUnknowns, const fmi3ValueReference knowns[],
                                        size_t nKnowns, const fmi3Float64 seed[], size_t nSeed, fmi3Float64 sensitivity[], size_t nSensitivity)
{
    const int pointers = (nUnknowns == 0 || (unknowns && sensitivity)) && (nKnowns == 0 || (knowns && seed));
    Instance *s = called(instance, "fmi3GetDirectionalDerivative", EVALUABLE, pointers);
    if (!s || same_number(s, "seed", nKnowns, nSeed) != OK || same_number(s, "sensitivity", nUnknowns, nSensitivity) != OK) return fmi3Error;
    return as_fmi3(directional_derivative(s, unknowns, nUnknowns, knowns, nKnowns, seed, sensitivity));
}

fmi3Status fmi3GetAdjointDerivative(fmi3Instance instance, const fmi3ValueReference unknowns[], size_t nUnknowns, const fmi3ValueReference knowns[],
                                    size_t nKnowns, const fmi3Float64 seed[], size_t nSeed, fmi3Float64 sensitivity[], size_t nSensitivity)
{
    const int pointers = (nUnknowns == 0 || (unknowns && seed)) && (nKnowns == 0 || (knowns && sensitivity));
    Instance *s = called(instance, "fmi3GetAdjointDerivative", EVALUABLE, pointers);
    if (!s || same_number(s, "seed", nUnknowns, nSeed) != OK || same_number(s, "sensitivity", nKnowns, nSensitivity) != OK) return fmi3Error;
    return as_fmi3(adjoint_derivative(s, unknowns, nUnknowns, knowns, nKnowns, seed, sensitivity));
}
