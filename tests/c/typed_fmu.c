/* A small FMU of FMI 2.0 for co-simulation with a parameter of every type, which its outputs show:

   y = gain u,   seen_flag, seen_count, seen_mode: the parameters as numbers,   label_length: of the text

It asks for the end of the simulation at end_time. */

#include <stdlib.h>
#include <string.h>

#include "fmi2FunctionTypes.h"

enum { U, GAIN, Y, SEEN_FLAG, SEEN_COUNT, SEEN_MODE, LABEL_LENGTH, END_TIME, N_REAL };

typedef struct {
    double real[N_REAL];
    int flag, count, mode, ended;
    char label[100];
} Instance;

const char *fmi2GetTypesPlatform(void) { return "default"; }
const char *fmi2GetVersion(void) { return "2.0"; }

static void start(Instance *s)
{
    memset(s, 0, sizeof *s);
    s->real[GAIN] = 1.0;
    s->mode = 1;
    s->real[END_TIME] = 1e300;
}

fmi2Component fmi2Instantiate(fmi2String name, fmi2Type type, fmi2String guid, fmi2String resources, const fmi2CallbackFunctions *functions,
                              fmi2Boolean visible, fmi2Boolean logging)
{
    (void)type, (void)resources, (void)visible, (void)logging;
    if (strcmp(guid, "{typed}")) {
        functions->logger(functions->componentEnvironment, name, fmi2Error, "error", "the GUID is of another model");
        return NULL;
    }
    Instance *s = malloc(sizeof *s);
    if (s) start(s);
    return s;
}

void fmi2FreeInstance(fmi2Component c) { free(c); }
fmi2Status fmi2SetDebugLogging(fmi2Component c, fmi2Boolean on, size_t n, const fmi2String names[]) { return (void)c, (void)on, (void)n, (void)names, fmi2OK; }
fmi2Status fmi2SetupExperiment(fmi2Component c, fmi2Boolean d, fmi2Real t, fmi2Real a, fmi2Boolean e, fmi2Real b)
{
    return (void)c, (void)d, (void)t, (void)a, (void)e, (void)b, fmi2OK;
}
fmi2Status fmi2EnterInitializationMode(fmi2Component c) { return (void)c, fmi2OK; }
fmi2Status fmi2ExitInitializationMode(fmi2Component c) { return (void)c, fmi2OK; }
fmi2Status fmi2Terminate(fmi2Component c) { return (void)c, fmi2OK; }
fmi2Status fmi2Reset(fmi2Component c) { return start(c), fmi2OK; }

fmi2Status fmi2GetReal(fmi2Component c, const fmi2ValueReference vr[], size_t n, fmi2Real value[])
{
    Instance *s = c;
    s->real[Y] = s->real[GAIN] * s->real[U];
    s->real[SEEN_FLAG] = s->flag;
    s->real[SEEN_COUNT] = s->count;
    s->real[SEEN_MODE] = s->mode;
    s->real[LABEL_LENGTH] = (double)strlen(s->label);
    for (size_t i = 0; i < n; i++) value[i] = s->real[vr[i]];
    return fmi2OK;
}

fmi2Status fmi2SetReal(fmi2Component c, const fmi2ValueReference vr[], size_t n, const fmi2Real value[])
{
    for (size_t i = 0; i < n; i++) ((Instance *)c)->real[vr[i]] = value[i];
    return fmi2OK;
}

fmi2Status fmi2SetInteger(fmi2Component c, const fmi2ValueReference vr[], size_t n, const fmi2Integer value[])
{
    for (size_t i = 0; i < n; i++) *(vr[i] == 0 ? &((Instance *)c)->count : &((Instance *)c)->mode) = value[i];
    return fmi2OK;
}

fmi2Status fmi2SetBoolean(fmi2Component c, const fmi2ValueReference vr[], size_t n, const fmi2Boolean value[])
{
    (void)vr;
    for (size_t i = 0; i < n; i++) ((Instance *)c)->flag = value[i];
    return fmi2OK;
}

fmi2Status fmi2SetString(fmi2Component c, const fmi2ValueReference vr[], size_t n, const fmi2String value[])
{
    (void)vr;
    for (size_t i = 0; i < n; i++) strncpy(((Instance *)c)->label, value[i], 99);
    return fmi2OK;
}

fmi2Status fmi2GetInteger(fmi2Component c, const fmi2ValueReference vr[], size_t n, fmi2Integer value[])
{
    for (size_t i = 0; i < n; i++) value[i] = vr[i] == 0 ? ((Instance *)c)->count : ((Instance *)c)->mode;
    return fmi2OK;
}

fmi2Status fmi2GetBoolean(fmi2Component c, const fmi2ValueReference vr[], size_t n, fmi2Boolean value[])
{
    (void)vr;
    for (size_t i = 0; i < n; i++) value[i] = ((Instance *)c)->flag;
    return fmi2OK;
}

fmi2Status fmi2DoStep(fmi2Component c, fmi2Real t, fmi2Real h, fmi2Boolean no)
{
    Instance *s = c;
    (void)no;
    s->ended = t + h > s->real[END_TIME];
    return s->ended ? fmi2Discard : fmi2OK;
}

fmi2Status fmi2GetBooleanStatus(fmi2Component c, const fmi2StatusKind kind, fmi2Boolean *value)
{
    *value = ((Instance *)c)->ended;
    return kind == fmi2Terminated ? fmi2OK : fmi2Discard;
}

fmi2Status fmi2GetRealStatus(fmi2Component c, const fmi2StatusKind kind, fmi2Real *value)
{
    *value = ((Instance *)c)->real[END_TIME];
    return kind == fmi2LastSuccessfulTime ? fmi2OK : fmi2Discard;
}

/* Functions that an importer looks up and that the description does not offer. */
#define ABSENT(name) fmi2Status name(void) { return fmi2Error; }
ABSENT(fmi2GetString)
ABSENT(fmi2GetFMUstate)
ABSENT(fmi2SetFMUstate)
ABSENT(fmi2FreeFMUstate)
ABSENT(fmi2SerializedFMUstateSize)
ABSENT(fmi2SerializeFMUstate)
ABSENT(fmi2DeSerializeFMUstate)
ABSENT(fmi2GetDirectionalDerivative)
ABSENT(fmi2SetRealInputDerivatives)
ABSENT(fmi2GetRealOutputDerivatives)
ABSENT(fmi2CancelStep)
ABSENT(fmi2GetStatus)
ABSENT(fmi2GetIntegerStatus)
ABSENT(fmi2GetStringStatus)
