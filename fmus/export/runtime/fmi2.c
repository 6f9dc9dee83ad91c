/* The functions of FMI 2.0, model exchange and co-simulation, on one instance of the model.

   Each lists the phases in which it may be called; a call in another phase is refused and changes nothing. */

#include <stdlib.h>

#include "call.h"
#include "fmi2Functions.h"
#include "step.h"

/* Callbacks and environment of the importer. */
typedef struct {
    fmi2CallbackFunctions callbacks;
    fmi2Type type;
} Host;

static fmi2Status as_fmi2(Status status)
{
    static const fmi2Status statuses[] = {fmi2OK, fmi2Warning, fmi2Discard, fmi2Error};
    return statuses[status];
}

static void send(const fmi2CallbackFunctions *callbacks, const char *name, Status status, const char *message)
{
    if (callbacks->logger) callbacks->logger(callbacks->componentEnvironment, name, as_fmi2(status), category_of(status), message);
}

static void log_message(Instance *s, Status status, const char *message)
{
    const Host *host = s->host;
    if (is_logged(s, status)) send(&host->callbacks, s->name, status, message);
}

static int model_exchange(const Instance *s) { return ((const Host *)s->host)->type == fmi2ModelExchange; }

/* Creation ------------------------------------------------------------------------------------------------- */

const char *fmi2GetTypesPlatform(void) { return fmi2TypesPlatform; }

const char *fmi2GetVersion(void) { return fmi2Version; }

fmi2Component fmi2Instantiate(fmi2String instanceName, fmi2Type fmuType, fmi2String fmuGUID, fmi2String fmuResourceLocation,
                              const fmi2CallbackFunctions *functions, fmi2Boolean visible, fmi2Boolean loggingOn)
{
    (void)fmuResourceLocation, (void)visible;
    if (!functions) return NULL;
    const char *name = instanceName ? instanceName : "", *wrong = refused_identity(instanceName, fmuGUID);
    if (!wrong && fmuType != fmi2ModelExchange && fmuType != fmi2CoSimulation) wrong = "the type given is neither model exchange nor co-simulation";
    if (wrong) {
        send(functions, name, ERROR, wrong);
        return NULL;
    }
    Host *host = malloc(sizeof *host);
    Instance *s = host ? instance_new(name, log_message, host) : NULL;
    if (!s) {
        free(host);
        send(functions, name, ERROR, "out of memory for an instance");
        return NULL;
    }
    host->callbacks = *functions;
    host->type = fmuType;
    choose_categories(s, loggingOn, 0, NULL);
    return s;
}

void fmi2FreeInstance(fmi2Component c)
{
    Instance *s = c;
    if (!s) return;
    free(s->host);
    instance_free(s);
}

fmi2Status fmi2SetDebugLogging(fmi2Component c, fmi2Boolean loggingOn, size_t nCategories, const fmi2String names[])
{
    Instance *s = called(c, "fmi2SetDebugLogging", ANY, nCategories == 0 || names);
    return s ? as_fmi2(choose_categories(s, loggingOn, nCategories, names)) : fmi2Error;
}

/* Phases --------------------------------------------------------------------------------------------------- */

fmi2Status fmi2SetupExperiment(fmi2Component c, fmi2Boolean toleranceDefined, fmi2Real tolerance, fmi2Real startTime,
                               fmi2Boolean stopTimeDefined, fmi2Real stopTime)
{
    Instance *s = called(c, "fmi2SetupExperiment", INSTANTIATED, 1);
    return s ? as_fmi2(set_experiment(s, toleranceDefined, tolerance, startTime, stopTimeDefined, stopTime)) : fmi2Error;
}

fmi2Status fmi2EnterInitializationMode(fmi2Component c) { return as_fmi2(change_phase(c, "fmi2EnterInitializationMode", INSTANTIATED, INITIALIZING)); }

fmi2Status fmi2ExitInitializationMode(fmi2Component c)
{
    Instance *s = called(c, "fmi2ExitInitializationMode", INITIALIZING, 1);
    if (!s) return fmi2Error;
    enter(s, model_exchange(s) ? EVENT : STEPPING);
    return fmi2OK;
}

fmi2Status fmi2Terminate(fmi2Component c) { return as_fmi2(change_phase(c, "fmi2Terminate", RUNNING, TERMINATED)); }

fmi2Status fmi2Reset(fmi2Component c)
{
    Instance *s = called(c, "fmi2Reset", ANY, 1);
    if (!s) return fmi2Error;
    instance_reset(s);
    return fmi2OK;
}

/* Values --------------------------------------------------------------------------------------------------- */

fmi2Status fmi2GetReal(fmi2Component c, const fmi2ValueReference vr[], size_t nvr, fmi2Real value[])
{
    Instance *s = called(c, "fmi2GetReal", ANY, nvr == 0 || (vr && value));
    return s ? as_fmi2(get_values(s, vr, nvr, value)) : fmi2Error;
}

fmi2Status fmi2SetReal(fmi2Component c, const fmi2ValueReference vr[], size_t nvr, const fmi2Real value[])
{
    Instance *s = called(c, "fmi2SetReal", SOUND, nvr == 0 || (vr && value));
    return s ? as_fmi2(set_values(s, vr, nvr, value)) : fmi2Error;
}

/* All variables are real numbers. */
static fmi2Status no_such_type(fmi2Component c, const char *function, size_t nvr)
{
    Instance *s = called(c, function, ANY, 1);
    if (!s) return fmi2Error;
    return nvr == 0 ? fmi2OK : as_fmi2(report(s, ERROR, "%s: all variables of this model are of type Real", function));
}

fmi2Status fmi2GetInteger(fmi2Component c, const fmi2ValueReference vr[], size_t nvr, fmi2Integer value[])
{
    (void)vr, (void)value;
    return no_such_type(c, "fmi2GetInteger", nvr);
}

fmi2Status fmi2GetBoolean(fmi2Component c, const fmi2ValueReference vr[], size_t nvr, fmi2Boolean value[])
{
    (void)vr, (void)value;
    return no_such_type(c, "fmi2GetBoolean", nvr);
}

fmi2Status fmi2GetString(fmi2Component c, const fmi2ValueReference vr[], size_t nvr, fmi2String value[])
{
    (void)vr, (void)value;
    return no_such_type(c, "fmi2GetString", nvr);
}

fmi2Status fmi2SetInteger(fmi2Component c, const fmi2ValueReference vr[], size_t nvr, const fmi2Integer value[])
{
    (void)vr, (void)value;
    return no_such_type(c, "fmi2SetInteger", nvr);
}

fmi2Status fmi2SetBoolean(fmi2Component c, const fmi2ValueReference vr[], size_t nvr, const fmi2Boolean value[])
{
    (void)vr, (void)value;
    return no_such_type(c, "fmi2SetBoolean", nvr);
}

fmi2Status fmi2SetString(fmi2Component c, const fmi2ValueReference vr[], size_t nvr, const fmi2String value[])
{
    (void)vr, (void)value;
    return no_such_type(c, "fmi2SetString", nvr);
}

/* State of the FMU ----------------------------------------------------------------------------------------- */

fmi2Status fmi2GetFMUstate(fmi2Component c, fmi2FMUstate *FMUstate) { return as_fmi2(take_state(c, "fmi2GetFMUstate", FMUstate)); }

fmi2Status fmi2SetFMUstate(fmi2Component c, fmi2FMUstate FMUstate) { return as_fmi2(restore_state(c, "fmi2SetFMUstate", FMUstate)); }

fmi2Status fmi2FreeFMUstate(fmi2Component c, fmi2FMUstate *FMUstate) { return as_fmi2(free_state(c, "fmi2FreeFMUstate", FMUstate)); }

fmi2Status fmi2SerializedFMUstateSize(fmi2Component c, fmi2FMUstate FMUstate, size_t *size)
{
    return as_fmi2(size_of_state(c, "fmi2SerializedFMUstateSize", FMUstate, size));
}

fmi2Status fmi2SerializeFMUstate(fmi2Component c, fmi2FMUstate FMUstate, fmi2Byte bytes[], size_t size)
{
    return as_fmi2(write_state(c, "fmi2SerializeFMUstate", FMUstate, (unsigned char *)bytes, size));
}

fmi2Status fmi2DeSerializeFMUstate(fmi2Component c, const fmi2Byte bytes[], size_t size, fmi2FMUstate *FMUstate)
{
    return as_fmi2(read_state(c, "fmi2DeSerializeFMUstate", (const unsigned char *)bytes, size, FMUstate));
}

/* Derivatives ---------------------------------------------------------------------------------------------- */

fmi2Status fmi2GetDirectionalDerivative(fmi2Component c, const fmi2ValueReference unknowns[], size_t nUnknown,
                                        const fmi2ValueReference knowns[], size_t nKnown, const fmi2Real dvKnown[], fmi2Real dvUnknown[])
{
    const int pointers = (nUnknown == 0 || (unknowns && dvUnknown)) && (nKnown == 0 || (knowns && dvKnown));
    Instance *s = called(c, "fmi2GetDirectionalDerivative", EVALUABLE, pointers);
    return s ? as_fmi2(directional_derivative(s, unknowns, nUnknown, knowns, nKnown, dvKnown, dvUnknown)) : fmi2Error;
}

fmi2Status fmi2SetRealInputDerivatives(fmi2Component c, const fmi2ValueReference vr[], size_t nvr, const fmi2Integer order[], const fmi2Real value[])
{
    Instance *s = called(c, "fmi2SetRealInputDerivatives", STARTING | STEPPING, nvr == 0 || (vr && order && value));
    return s ? as_fmi2(set_slopes(s, vr, nvr, order, value)) : fmi2Error;
}

fmi2Status fmi2GetRealOutputDerivatives(fmi2Component c, const fmi2ValueReference vr[], size_t nvr, const fmi2Integer order[], fmi2Real value[])
{
    Instance *s = called(c, "fmi2GetRealOutputDerivatives", STEPPING | TERMINATED | FAILED, nvr == 0 || (vr && order && value));
    return s ? as_fmi2(get_slopes(s, vr, nvr, order, value)) : fmi2Error;
}

/* Co-simulation -------------------------------------------------------------------------------------------- */

fmi2Status fmi2DoStep(fmi2Component c, fmi2Real currentCommunicationPoint, fmi2Real communicationStepSize, fmi2Boolean noSetFMUStatePriorToCurrentPoint)
{
    Instance *s = called(c, "fmi2DoStep", STEPPING, 1);
    (void)noSetFMUStatePriorToCurrentPoint;
    return s ? as_fmi2(step_from(s, currentCommunicationPoint, communicationStepSize)) : fmi2Error;
}

fmi2Status fmi2CancelStep(fmi2Component c)
{
    Instance *s = called(c, "fmi2CancelStep", ANY, 1);
    return s ? as_fmi2(report(s, ERROR, "fmi2CancelStep: no step is running, steps are not asynchronous")) : fmi2Error;
}

/* No step is ever pending; after a failed step the time is unchanged. */
static fmi2Status no_status(fmi2Component c, const char *function)
{
    Instance *s = called(c, function, ANY, 1);
    return s ? as_fmi2(report(s, DISCARD, "%s: this status does not exist here", function)) : fmi2Error;
}

fmi2Status fmi2GetStatus(fmi2Component c, const fmi2StatusKind kind, fmi2Status *value)
{
    (void)kind, (void)value;
    return no_status(c, "fmi2GetStatus");
}

fmi2Status fmi2GetRealStatus(fmi2Component c, const fmi2StatusKind kind, fmi2Real *value)
{
    if (kind != fmi2LastSuccessfulTime) return no_status(c, "fmi2GetRealStatus");
    Instance *s = called(c, "fmi2GetRealStatus", ANY, value != NULL);
    if (!s) return fmi2Error;
    *value = s->z[0];
    return fmi2OK;
}

fmi2Status fmi2GetIntegerStatus(fmi2Component c, const fmi2StatusKind kind, fmi2Integer *value)
{
    (void)kind, (void)value;
    return no_status(c, "fmi2GetIntegerStatus");
}

fmi2Status fmi2GetBooleanStatus(fmi2Component c, const fmi2StatusKind kind, fmi2Boolean *value)
{
    if (kind != fmi2Terminated) return no_status(c, "fmi2GetBooleanStatus");
    Instance *s = called(c, "fmi2GetBooleanStatus", ANY, value != NULL);
    if (!s) return fmi2Error;
    *value = fmi2False;
    return fmi2OK;
}

fmi2Status fmi2GetStringStatus(fmi2Component c, const fmi2StatusKind kind, fmi2String *value)
{
    (void)kind, (void)value;
    return no_status(c, "fmi2GetStringStatus");
}

/* Model exchange ------------------------------------------------------------------------------------------- */

fmi2Status fmi2EnterEventMode(fmi2Component c) { return as_fmi2(change_phase(c, "fmi2EnterEventMode", EVENT | CONTINUOUS, EVENT)); }

fmi2Status fmi2EnterContinuousTimeMode(fmi2Component c) { return as_fmi2(change_phase(c, "fmi2EnterContinuousTimeMode", EVENT, CONTINUOUS)); }

fmi2Status fmi2NewDiscreteStates(fmi2Component c, fmi2EventInfo *eventInfo)
{
    Instance *s = called(c, "fmi2NewDiscreteStates", EVENT, eventInfo != NULL);
    if (!s) return fmi2Error;
    *eventInfo = (fmi2EventInfo){fmi2False, fmi2False, fmi2False, fmi2False, fmi2False, 0};
    return fmi2OK;
}

fmi2Status fmi2CompletedIntegratorStep(fmi2Component c, fmi2Boolean noSetFMUStatePriorToCurrentPoint, fmi2Boolean *enterEventMode, fmi2Boolean *terminateSimulation)
{
    Instance *s = called(c, "fmi2CompletedIntegratorStep", CONTINUOUS, enterEventMode && terminateSimulation);
    (void)noSetFMUStatePriorToCurrentPoint;
    if (!s) return fmi2Error;
    *enterEventMode = *terminateSimulation = fmi2False;
    return fmi2OK;
}

fmi2Status fmi2SetTime(fmi2Component c, fmi2Real time)
{
    Instance *s = called(c, "fmi2SetTime", EVENT | CONTINUOUS, 1);
    return s ? as_fmi2(set_time(s, time)) : fmi2Error;
}

fmi2Status fmi2SetContinuousStates(fmi2Component c, const fmi2Real x[], size_t nx)
{
    Instance *s = called(c, "fmi2SetContinuousStates", EVENT | CONTINUOUS, nx == 0 || x);
    return s ? as_fmi2(set_states(s, x, nx)) : fmi2Error;
}

fmi2Status fmi2GetContinuousStates(fmi2Component c, fmi2Real x[], size_t nx)
{
    Instance *s = called(c, "fmi2GetContinuousStates", INITIALIZING | EVENT | CONTINUOUS | TERMINATED | FAILED, nx == 0 || x);
    return s ? as_fmi2(get_block(s, model.first_state, nx, x)) : fmi2Error;
}

fmi2Status fmi2GetDerivatives(fmi2Component c, fmi2Real derivatives[], size_t nx)
{
    Instance *s = called(c, "fmi2GetDerivatives", INITIALIZING | EVENT | CONTINUOUS | TERMINATED | FAILED, nx == 0 || derivatives);
    return s ? as_fmi2(get_block(s, model.first_derivative, nx, derivatives)) : fmi2Error;
}

fmi2Status fmi2GetNominalsOfContinuousStates(fmi2Component c, fmi2Real x_nominal[], size_t nx)
{
    Instance *s = called(c, "fmi2GetNominalsOfContinuousStates", ANY, nx == 0 || x_nominal);
    return s ? as_fmi2(get_nominals(s, nx, x_nominal)) : fmi2Error;
}

fmi2Status fmi2GetEventIndicators(fmi2Component c, fmi2Real eventIndicators[], size_t ni)
{
    Instance *s = called(c, "fmi2GetEventIndicators", INITIALIZING | EVENT | CONTINUOUS | TERMINATED | FAILED, 1);
    (void)eventIndicators;
    if (!s) return fmi2Error;
    return ni == 0 ? fmi2OK : as_fmi2(report(s, ERROR, "the model has no event indicators"));
}
