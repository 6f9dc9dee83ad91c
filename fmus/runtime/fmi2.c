/* The functions of FMI 2.0, model exchange and co-simulation, on one instance of the model.

   Each says in which phases it may be called; a call out of order is refused and changes nothing. */

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "fmi2Functions.h"
#include "instance.h"
#include "snapshot.h"
#include "step.h"

enum { STARTING = INSTANTIATED | INITIALIZING, RUNNING = STEPPING | EVENT | CONTINUOUS, ANY = STARTING | RUNNING | TERMINATED };

/* What the importer gave. */
typedef struct {
    fmi2CallbackFunctions callbacks;
    fmi2Type type;
} Host;

static const struct {
    const char *name;
    unsigned statuses;
} categories[] = {
    {"logAll", 1u << WARNING | 1u << DISCARD | 1u << ERROR},
    {"logStatusError", 1u << ERROR},
    {"logStatusDiscard", 1u << DISCARD},
    {"logStatusWarning", 1u << WARNING},
};
enum { N_CATEGORIES = sizeof categories / sizeof categories[0] };

static fmi2Status as_fmi2(Status status)
{
    static const fmi2Status statuses[] = {fmi2OK, fmi2Warning, fmi2Discard, fmi2Error};
    return statuses[status];
}

static void send(const fmi2CallbackFunctions *callbacks, const char *name, Status status, const char *message)
{
    static const char *names[] = {"logAll", "logStatusWarning", "logStatusDiscard", "logStatusError"};
    if (callbacks->logger) callbacks->logger(callbacks->componentEnvironment, name, as_fmi2(status), names[status], message);
}

static void log_message(Instance *s, Status status, const char *message)
{
    const Host *host = s->host;
    if (s->categories & 1u << status) send(&host->callbacks, s->name, status, message);
}

static const char *phase_name(Phase p)
{
    switch (p) {
    case INSTANTIATED: return "before initialisation";
    case INITIALIZING: return "during initialisation";
    case STEPPING: return "between steps";
    case EVENT: return "in event mode";
    case CONTINUOUS: return "in continuous-time mode";
    default: return "after termination";
    }
}

/* The instance, if it exists, may do this now, and was given its pointers; else NULL. */
static Instance *checked(fmi2Component c, const char *function, unsigned allowed, int pointers)
{
    Instance *s = c;
    if (!s) return NULL;
    if (!(phase(s) & allowed)) {
        report(s, ERROR, "%s may not be called %s", function, phase_name(phase(s)));
        return NULL;
    }
    if (!pointers) {
        report(s, ERROR, "%s was given a null pointer", function);
        return NULL;
    }
    return s;
}

static fmi2Status to(fmi2Component c, const char *function, unsigned allowed, Phase next)
{
    Instance *s = checked(c, function, allowed, 1);
    if (!s) return fmi2Error;
    enter(s, next);
    return fmi2OK;
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
    const char *name = instanceName ? instanceName : "", *wrong = NULL;
    if (!*name) wrong = "an instance needs a name";
    else if (!fmuGUID || strcmp(fmuGUID, model.guid) != 0) wrong = "the GUID given is not that of this model: model description and binary do not belong together";
    else if (fmuType != fmi2ModelExchange && fmuType != fmi2CoSimulation) wrong = "the type given is neither model exchange nor co-simulation";
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
    s->categories = loggingOn ? categories[0].statuses : 0;
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
    Instance *s = checked(c, "fmi2SetDebugLogging", ANY, nCategories == 0 || names);
    unsigned chosen = nCategories == 0 ? categories[0].statuses : 0;
    if (!s) return fmi2Error;
    for (size_t i = 0; i < nCategories; i++) {
        size_t k = 0;
        while (k < N_CATEGORIES && !(names[i] && strcmp(names[i], categories[k].name) == 0)) k++;
        if (k == N_CATEGORIES)
            return as_fmi2(report(s, ERROR, "unknown log category '%.100s' (valid: logAll, logStatusError, logStatusDiscard, logStatusWarning)", names[i] ? names[i] : ""));
        chosen |= categories[k].statuses;
    }
    s->categories = loggingOn ? chosen : 0;
    return fmi2OK;
}

/* Phases --------------------------------------------------------------------------------------------------- */

fmi2Status fmi2SetupExperiment(fmi2Component c, fmi2Boolean toleranceDefined, fmi2Real tolerance, fmi2Real startTime,
                               fmi2Boolean stopTimeDefined, fmi2Real stopTime)
{
    Instance *s = checked(c, "fmi2SetupExperiment", INSTANTIATED, 1);
    if (!s) return fmi2Error;
    if (stopTimeDefined && !(stopTime >= startTime))
        return as_fmi2(report(s, ERROR, "stop time %g s is before start time %g s", stopTime, startTime));
    if (toleranceDefined && model.tolerance) {
        const Status status = set_values(s, &model.tolerance, 1, &tolerance);
        if (status != OK) return as_fmi2(status);
    }
    if (set_time(s, startTime) != OK) return fmi2Error;
    s->kept[STOP_TIME] = stopTimeDefined ? stopTime : HUGE_VAL;
    return fmi2OK;
}

fmi2Status fmi2EnterInitializationMode(fmi2Component c) { return to(c, "fmi2EnterInitializationMode", INSTANTIATED, INITIALIZING); }

fmi2Status fmi2ExitInitializationMode(fmi2Component c)
{
    Instance *s = checked(c, "fmi2ExitInitializationMode", INITIALIZING, 1);
    if (!s) return fmi2Error;
    enter(s, model_exchange(s) ? EVENT : STEPPING);
    return fmi2OK;
}

fmi2Status fmi2Terminate(fmi2Component c) { return to(c, "fmi2Terminate", RUNNING, TERMINATED); }

fmi2Status fmi2Reset(fmi2Component c)
{
    Instance *s = checked(c, "fmi2Reset", ANY, 1);
    if (!s) return fmi2Error;
    instance_reset(s);
    return fmi2OK;
}

/* Values --------------------------------------------------------------------------------------------------- */

fmi2Status fmi2GetReal(fmi2Component c, const fmi2ValueReference vr[], size_t nvr, fmi2Real value[])
{
    Instance *s = checked(c, "fmi2GetReal", ANY, nvr == 0 || (vr && value));
    return s ? as_fmi2(get_values(s, vr, nvr, value)) : fmi2Error;
}

fmi2Status fmi2SetReal(fmi2Component c, const fmi2ValueReference vr[], size_t nvr, const fmi2Real value[])
{
    Instance *s = checked(c, "fmi2SetReal", ANY & ~(unsigned)TERMINATED, nvr == 0 || (vr && value));
    return s ? as_fmi2(set_values(s, vr, nvr, value)) : fmi2Error;
}

/* All variables are real numbers. */
static fmi2Status no_such_type(fmi2Component c, const char *function, size_t nvr)
{
    Instance *s = checked(c, function, ANY, 1);
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

fmi2Status fmi2GetFMUstate(fmi2Component c, fmi2FMUstate *FMUstate)
{
    Instance *s = checked(c, "fmi2GetFMUstate", ANY, FMUstate != NULL);
    if (!s) return fmi2Error;
    Snapshot *snapshot = *FMUstate;
    const Status status = snapshot_take(s, &snapshot);
    *FMUstate = snapshot;
    return as_fmi2(status);
}

fmi2Status fmi2SetFMUstate(fmi2Component c, fmi2FMUstate FMUstate)
{
    Instance *s = checked(c, "fmi2SetFMUstate", ANY, FMUstate != NULL);
    return s ? as_fmi2(snapshot_restore(s, FMUstate)) : fmi2Error;
}

fmi2Status fmi2FreeFMUstate(fmi2Component c, fmi2FMUstate *FMUstate)
{
    Instance *s = checked(c, "fmi2FreeFMUstate", ANY, 1);
    if (!s) return fmi2Error;
    if (!FMUstate || !*FMUstate) return fmi2OK;
    const Status status = snapshot_free(s, *FMUstate);
    if (status == OK) *FMUstate = NULL;
    return as_fmi2(status);
}

fmi2Status fmi2SerializedFMUstateSize(fmi2Component c, fmi2FMUstate FMUstate, size_t *size)
{
    Instance *s = checked(c, "fmi2SerializedFMUstateSize", ANY, FMUstate && size);
    if (!s) return fmi2Error;
    *size = serialised_size(s);
    return fmi2OK;
}

fmi2Status fmi2SerializeFMUstate(fmi2Component c, fmi2FMUstate FMUstate, fmi2Byte bytes[], size_t size)
{
    Instance *s = checked(c, "fmi2SerializeFMUstate", ANY, FMUstate && bytes);
    return s ? as_fmi2(serialise(s, FMUstate, (unsigned char *)bytes, size)) : fmi2Error;
}

fmi2Status fmi2DeSerializeFMUstate(fmi2Component c, const fmi2Byte bytes[], size_t size, fmi2FMUstate *FMUstate)
{
    Instance *s = checked(c, "fmi2DeSerializeFMUstate", ANY, bytes && FMUstate);
    if (!s) return fmi2Error;
    Snapshot *snapshot = *FMUstate;
    const Status status = deserialise(s, (const unsigned char *)bytes, size, &snapshot);
    *FMUstate = snapshot;
    return as_fmi2(status);
}

/* Derivatives ---------------------------------------------------------------------------------------------- */

fmi2Status fmi2GetDirectionalDerivative(fmi2Component c, const fmi2ValueReference unknowns[], size_t nUnknown,
                                        const fmi2ValueReference knowns[], size_t nKnown, const fmi2Real dvKnown[], fmi2Real dvUnknown[])
{
    const int pointers = (nUnknown == 0 || (unknowns && dvUnknown)) && (nKnown == 0 || (knowns && dvKnown));
    Instance *s = checked(c, "fmi2GetDirectionalDerivative", ANY & ~(unsigned)INSTANTIATED, pointers);
    return s ? as_fmi2(directional_derivative(s, unknowns, nUnknown, knowns, nKnown, dvKnown, dvUnknown)) : fmi2Error;
}

fmi2Status fmi2SetRealInputDerivatives(fmi2Component c, const fmi2ValueReference vr[], size_t nvr, const fmi2Integer order[], const fmi2Real value[])
{
    Instance *s = checked(c, "fmi2SetRealInputDerivatives", STARTING | STEPPING, nvr == 0 || (vr && order && value));
    return s ? as_fmi2(set_slopes(s, vr, nvr, order, value)) : fmi2Error;
}

fmi2Status fmi2GetRealOutputDerivatives(fmi2Component c, const fmi2ValueReference vr[], size_t nvr, const fmi2Integer order[], fmi2Real value[])
{
    Instance *s = checked(c, "fmi2GetRealOutputDerivatives", STEPPING | TERMINATED, nvr == 0 || (vr && order && value));
    return s ? as_fmi2(get_slopes(s, vr, nvr, order, value)) : fmi2Error;
}

/* Co-simulation -------------------------------------------------------------------------------------------- */

fmi2Status fmi2DoStep(fmi2Component c, fmi2Real currentCommunicationPoint, fmi2Real communicationStepSize, fmi2Boolean noSetFMUStatePriorToCurrentPoint)
{
    Instance *s = checked(c, "fmi2DoStep", STEPPING, 1);
    (void)noSetFMUStatePriorToCurrentPoint;
    return s ? as_fmi2(step_from(s, currentCommunicationPoint, communicationStepSize)) : fmi2Error;
}

fmi2Status fmi2CancelStep(fmi2Component c)
{
    Instance *s = checked(c, "fmi2CancelStep", ANY, 1);
    return s ? as_fmi2(report(s, ERROR, "fmi2CancelStep: no step is running, steps are not asynchronous")) : fmi2Error;
}

/* No step is ever pending; a step that failed has left the time where it was. */
static fmi2Status no_status(fmi2Component c, const char *function)
{
    Instance *s = checked(c, function, ANY, 1);
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
    Instance *s = checked(c, "fmi2GetRealStatus", ANY, value != NULL);
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
    Instance *s = checked(c, "fmi2GetBooleanStatus", ANY, value != NULL);
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

fmi2Status fmi2EnterEventMode(fmi2Component c) { return to(c, "fmi2EnterEventMode", EVENT | CONTINUOUS, EVENT); }

fmi2Status fmi2EnterContinuousTimeMode(fmi2Component c) { return to(c, "fmi2EnterContinuousTimeMode", EVENT, CONTINUOUS); }

fmi2Status fmi2NewDiscreteStates(fmi2Component c, fmi2EventInfo *eventInfo)
{
    Instance *s = checked(c, "fmi2NewDiscreteStates", EVENT, eventInfo != NULL);
    if (!s) return fmi2Error;
    *eventInfo = (fmi2EventInfo){fmi2False, fmi2False, fmi2False, fmi2False, fmi2False, 0};
    return fmi2OK;
}

fmi2Status fmi2CompletedIntegratorStep(fmi2Component c, fmi2Boolean noSetFMUStatePriorToCurrentPoint, fmi2Boolean *enterEventMode, fmi2Boolean *terminateSimulation)
{
    Instance *s = checked(c, "fmi2CompletedIntegratorStep", CONTINUOUS, enterEventMode && terminateSimulation);
    (void)noSetFMUStatePriorToCurrentPoint;
    if (!s) return fmi2Error;
    *enterEventMode = *terminateSimulation = fmi2False;
    return fmi2OK;
}

fmi2Status fmi2SetTime(fmi2Component c, fmi2Real time)
{
    Instance *s = checked(c, "fmi2SetTime", EVENT | CONTINUOUS, 1);
    return s ? as_fmi2(set_time(s, time)) : fmi2Error;
}

fmi2Status fmi2SetContinuousStates(fmi2Component c, const fmi2Real x[], size_t nx)
{
    Instance *s = checked(c, "fmi2SetContinuousStates", EVENT | CONTINUOUS, nx == 0 || x);
    return s ? as_fmi2(set_states(s, x, nx)) : fmi2Error;
}

fmi2Status fmi2GetContinuousStates(fmi2Component c, fmi2Real x[], size_t nx)
{
    Instance *s = checked(c, "fmi2GetContinuousStates", INITIALIZING | EVENT | CONTINUOUS | TERMINATED, nx == 0 || x);
    return s ? as_fmi2(get_block(s, model.first_state, nx, x)) : fmi2Error;
}

fmi2Status fmi2GetDerivatives(fmi2Component c, fmi2Real derivatives[], size_t nx)
{
    Instance *s = checked(c, "fmi2GetDerivatives", INITIALIZING | EVENT | CONTINUOUS | TERMINATED, nx == 0 || derivatives);
    return s ? as_fmi2(get_block(s, model.first_derivative, nx, derivatives)) : fmi2Error;
}

fmi2Status fmi2GetNominalsOfContinuousStates(fmi2Component c, fmi2Real x_nominal[], size_t nx)
{
    Instance *s = checked(c, "fmi2GetNominalsOfContinuousStates", ANY, nx == 0 || x_nominal);
    if (!s) return fmi2Error;
    for (size_t i = 0; i < nx && i < model.n_states; i++) x_nominal[i] = model.variables[model.first_state + i].nominal;
    return nx == model.n_states ? fmi2OK : as_fmi2(report(s, ERROR, "the nominals of %u states were asked for, the model has %u", (unsigned)nx, model.n_states));
}

fmi2Status fmi2GetEventIndicators(fmi2Component c, fmi2Real eventIndicators[], size_t ni)
{
    Instance *s = checked(c, "fmi2GetEventIndicators", INITIALIZING | EVENT | CONTINUOUS | TERMINATED, 1);
    (void)eventIndicators;
    if (!s) return fmi2Error;
    return ni == 0 ? fmi2OK : as_fmi2(report(s, ERROR, "the model has no event indicators"));
}
