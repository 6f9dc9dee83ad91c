/* An FMU of FMI 2.0 for both kinds, for tests of the check.

   -DBALL     bouncing ball: h' = v, v' = -g, v := -e v when h < 0; it stops by an event without end of the simulation
   else       der(x) = -k x + u, y = x + 2 u + g; n counts events: x falls below 0.5, time reaches 0.35 s

   Co-simulation integrates by Euler's method in internal steps of 1 ms. faults.h says how it can be made faulty. */
#include <math.h>
#include <stdarg.h>
#include "fmi2Functions.h"
#include "faults.h"

#define MOST 8
#define INTERNAL 1e-3

typedef enum { INSTANTIATED, INITIALISATION, EVENT, CONTINUOUS, STEP, TERMINATED, FAILED } Phase;

typedef struct {
    double real[MOST], time, next, before[2];
    int integer[MOST], boolean[MOST];
    char text[MOST][64];
    Phase phase;
    double maximum; /* the largest u so far */
    int exchange, calls;
    fmi2CallbackLogger log;
    fmi2ComponentEnvironment environment;
} Model;

#ifdef BALL
enum { H, V, DER_H, DER_V, G, E, REALS };
#define NX 2
#define NZ 1
static const int states[NX] = { H, V }, rates[NX] = { DER_H, DER_V };

static void start(Model *m) { m->real[H] = 1, m->real[G] = 9.81, m->real[E] = 0.7, m->next = INFINITY; }
static void evaluate(Model *m) { m->real[DER_H] = m->real[V], m->real[DER_V] = m->real[V] == 0 && m->real[H] <= 0 ? 0 : -m->real[G]; }
static void indicators(Model *m, double *z) { z[0] = m->real[H] == 0 && m->real[V] == 0 ? 1 : m->real[H]; }
static int event(Model *m) {
    if (m->real[H] <= 0 && m->real[V] < 0) {
        m->real[H] = 1e-12, m->real[V] *= -m->real[E];
        if (m->real[V] < 0.1) m->real[V] = m->real[H] = 0;
    }
    return 0;
}
static void remember(Model *m) { (void)m; }
static const unsigned settable = 1u << H | 1u << V | 1u << G | 1u << E, fixed = 1u << H | 1u << V | 1u << G | 1u << E;
#else
enum { X, DER_X, U, Y, K, G, BOUNDED, REALS };
#define NX 1
#define NZ 1
static const int states[NX] = { X }, rates[NX] = { DER_X };
static double shared, shared_maximum, shared_u, shared_k;

static void start(Model *m) {
    if (!is("static_maximum")) shared_maximum = 0;
    shared_u = 0, shared_k = 2;
    m->real[X] = 1, m->real[K] = is("start_value") ? 3 : 2, m->real[G] = 0.25, m->next = 0.35, m->integer[1] = 7;
    strcpy(m->text[0], "grey"), strcpy(m->text[1], is("string_utf8") ? "\xff\xfe" : "grey");
    shared = 0;
}
static void evaluate(Model *m) {
    m->real[DER_X] = -m->real[K] * m->real[X] + m->real[U];
    m->real[Y] = m->real[X] + 2 * m->real[U] + (is("unused_reset") ? 0 : m->real[G]);
    if (is("nonlinear")) m->real[Y] += fabs(m->real[U]);
    if (is("nan_output") && m->time > 0.1) m->real[Y] = NAN;
    if (is("infinite_output") && m->time > 0.1) m->real[Y] = INFINITY;
    if (is("random")) m->real[Y] += 1e-6 * (getpid() % 1000 + rand());
    if (is("shared")) m->real[Y] += shared;
    if (strstr(fault, "maximum_")) m->real[Y] += m->maximum;
    if (is("shared_maximum") || is("static_maximum")) m->real[Y] += shared_maximum;
    if (is("shared_input")) m->real[Y] += shared_u;
    if (is("shared_parameter")) m->real[Y] += shared_k;
    if (is("nan_varied") && m->real[U] != 0) m->real[Y] = NAN;
    if (is("clock")) { static int n; m->real[Y] += 1e-3 * n++; }
    m->real[BOUNDED] = is("real_bound") ? 2 : 0.5;
    m->integer[2] = is("integer_bound") ? 99 : m->integer[1];
    m->boolean[1] = m->boolean[0];
}
static void indicators(Model *m, double *z) { z[0] = m->real[X] - 0.5; }
static void remember(Model *m) {
    m->maximum = fmax(m->maximum, m->real[U]);
    if (m->real[U] > shared_maximum) shared_maximum = m->real[U];
}
static int event(Model *m) {
    if (is("endless_events")) return 1;
    int state = m->real[X] < 0.5 && m->before[1] >= 0, time = m->time >= m->next - 1e-12;
    m->integer[0] += state + time;
    m->before[1] = m->real[X] - 0.5;
    if (time) m->next = INFINITY;
    return 0;
}
static const unsigned settable = 1u << X | 1u << U | 1u << K | 1u << G, fixed = 1u << X | 1u << K;
#endif

static void say(Model *m, fmi2Status status, const char *text) {
    m->log(m->environment, "check", status, "logStatusError", "%s (%d %s)", text, 42, "words");
}

static fmi2Status fail(Model *m, const char *text) {
    m->phase = FAILED;
    say(m, fmi2Error, text);
    return fmi2Error;
}

#define M ((Model *)c)
#define REQUIRE(condition) if (!(condition)) return fail(M, "call not allowed here")

const char *fmi2GetTypesPlatform(void) {
#ifdef WRONG_PLATFORM
    return "other";
#endif
    return fmi2TypesPlatform;
}
const char *fmi2GetVersion(void) {
#ifdef WRONG_VERSION
    return "1.0";
#endif
    return fmi2Version;
}
fmi2Status fmi2SetDebugLogging(fmi2Component c, fmi2Boolean on, size_t n, const fmi2String names[]) { (void)c, (void)on, (void)n, (void)names; return fmi2OK; }

fmi2Component fmi2Instantiate(fmi2String name, fmi2Type type, fmi2String guid, fmi2String resources, const fmi2CallbackFunctions *functions,
                              fmi2Boolean visible, fmi2Boolean logging) {
    (void)name, (void)visible, (void)logging;
    read_fault(resources);
    misbehave("instantiate");
    Model temporary = { .log = functions->logger, .environment = functions->componentEnvironment };
    if (is("null_instance")) { say(&temporary, fmi2Error, "no licence"); return NULL; }
    if (strcmp(guid, "{bench}") && !is("any_guid")) { say(&temporary, fmi2Error, "wrong GUID"); return NULL; }
    Model *m = functions->allocateMemory(1, sizeof(Model));
    m->log = functions->logger, m->environment = functions->componentEnvironment, m->exchange = type == fmi2ModelExchange;
    start(m);
    evaluate(m);
    return m;
}
void fmi2FreeInstance(fmi2Component c) {
    misbehave("free");
    free(c);
}
fmi2Status fmi2SetupExperiment(fmi2Component c, fmi2Boolean td, fmi2Real tol, fmi2Real begin, fmi2Boolean sd, fmi2Real stop) {
    (void)td, (void)tol, (void)sd, (void)stop;
    REQUIRE(M->phase == INSTANTIATED);
    M->time = begin;
    return fmi2OK;
}
fmi2Status fmi2EnterInitializationMode(fmi2Component c) {
    misbehave("initialise");
    if (is("error_initialise")) return fail(M, "no initial solution");
    REQUIRE(M->phase == INSTANTIATED);
    M->phase = INITIALISATION;
    return fmi2OK;
}
fmi2Status fmi2ExitInitializationMode(fmi2Component c) {
    REQUIRE(M->phase == INITIALISATION);
    evaluate(M);
    M->before[1] = NZ ? 1 : 0;
    indicators(M, M->before);
    M->phase = M->exchange ? EVENT : STEP;
    return fmi2OK;
}
fmi2Status fmi2Terminate(fmi2Component c) {
    misbehave("terminate");
    if (is("error_terminate")) return fail(M, "cannot end");
    REQUIRE(M->phase == EVENT || M->phase == CONTINUOUS || M->phase == STEP);
    M->phase = TERMINATED;
    return fmi2OK;
}
fmi2Status fmi2Reset(fmi2Component c) {
    misbehave("reset");
    if (is("error_reset")) return fail(M, "cannot be reset");
    if (is("no_reset_after_error") && M->phase == FAILED) return fail(M, "cannot be reset");
    Model fresh = { .log = M->log, .environment = M->environment, .exchange = M->exchange };
    start(&fresh);
#ifndef BALL
    if (is("forget_reset")) fresh.real[X] = M->real[X];
    if (is("maximum_reset")) fresh.maximum = M->maximum;
    if (is("input_reset")) fresh.real[U] = M->real[U];
    if (is("parameter_reset")) fresh.real[K] = M->real[K];
    if (is("unused_reset")) fresh.real[G] = M->real[G];
#endif
    *M = fresh;
    evaluate(M);
    return fmi2OK;
}

#define LOOP for (size_t i = 0; i < n; i++)
#define GET(NAME, TYPE, FIELD, COUNT)                                                                             \
    fmi2Status fmi2Get##NAME(fmi2Component c, const fmi2ValueReference vr[], size_t n, TYPE value[]) {             \
        misbehave("get");                                                                                         \
        if (M->phase == CONTINUOUS || M->phase == EVENT || M->phase == INITIALISATION) evaluate(M);               \
        LOOP {                                                                                                    \
            if (vr[i] >= COUNT && !is("any_reference")) return fail(M, "unknown value reference");                 \
            if (vr[i] < COUNT) value[i] = FIELD;                                                                  \
        }                                                                                                         \
        return fmi2OK;                                                                                            \
    }
GET(Integer, fmi2Integer, M->integer[vr[i]], 3)
GET(Boolean, fmi2Boolean, M->boolean[vr[i]], 2)
GET(String, fmi2String, is("string_null") ? NULL : M->text[vr[i]], 2)

fmi2Status fmi2GetReal(fmi2Component c, const fmi2ValueReference vr[], size_t n, fmi2Real value[]) {
    misbehave("get");
    if (M->phase == CONTINUOUS || M->phase == EVENT || M->phase == INITIALISATION) evaluate(M);
    LOOP {
        if (vr[i] >= REALS) { if (!is("any_reference")) return fail(M, "unknown value reference"); value[i] = 0; continue; }
#ifndef BALL
        if (is("error_get") && vr[i] == BOUNDED) return fail(M, "table not loaded");
        value[i] = M->real[vr[i]] * (is("state_variable") && vr[i] == X ? 2 : 1);
#else
        value[i] = M->real[vr[i]];
#endif
    }
    return fmi2OK;
}

fmi2Status fmi2SetReal(fmi2Component c, const fmi2ValueReference vr[], size_t n, const fmi2Real value[]) {
    LOOP {
        int early = M->phase == INSTANTIATED || M->phase == INITIALISATION;
        if (vr[i] >= REALS || !(settable >> vr[i] & 1)) return fail(M, "cannot be set");
        if (is("error_set")) return fail(M, "refuses to be set");
        if (is("error_set_late") && !early) return fail(M, "refuses to be set");
        if ((fixed >> vr[i] & 1) && !early && !is("any_parameter")) return fail(M, "is fixed");
        if (!isfinite(value[i]) && !is("any_number")) { say(M, fmi2Discard, "is not finite"); return fmi2Discard; }
#ifndef BALL
        if (vr[i] == U && value[i] > 100 && !is("any_bound")) { say(M, fmi2Discard, "is above its maximum"); return fmi2Discard; }
#endif
#ifndef BALL
        if (is("discard_varied") && vr[i] == U && value[i] != 0) { say(M, fmi2Discard, "has to be 0"); return fmi2Discard; }
        if (is("error_varied") && vr[i] == U && value[i] != 0) return fail(M, "has to be 0");
        if (is("error_changed") && vr[i] == K && value[i] != 2) return fail(M, "has to be 2");
        if (vr[i] == U) shared_u = value[i];
        if (vr[i] == K) shared_k = value[i];
#endif
        M->real[vr[i]] = value[i];
#ifndef BALL
        if (is("warn_varied") && vr[i] == U && value[i] != 0) { say(M, fmi2Warning, "is off"); return fmi2Warning; }
#endif
        if (is("warn_always")) { say(M, fmi2Warning, "was set"); return fmi2Warning; }
    }
    return fmi2OK;
}
#define SET(NAME, TYPE, STATEMENT, COUNT)                                                                          \
    fmi2Status fmi2Set##NAME(fmi2Component c, const fmi2ValueReference vr[], size_t n, const TYPE value[]) {       \
        LOOP { if (vr[i] >= COUNT) return fail(M, "cannot be set"); STATEMENT; }                                   \
        return fmi2OK;                                                                                            \
    }
SET(Integer, fmi2Integer, M->integer[vr[i]] = value[i], 2)
SET(Boolean, fmi2Boolean, M->boolean[vr[i]] = value[i], 1)
SET(String, fmi2String, snprintf(M->text[vr[i]], 64, "%s", value[i]), 1)

fmi2Status fmi2GetFMUstate(fmi2Component c, fmi2FMUstate *state) {
    if (is("error_save")) return fail(M, "no room for a state");
    if (is("null_state")) return fmi2OK;
    if (!*state) *state = malloc(sizeof(Model));
    memcpy(*state, c, sizeof(Model));
    return fmi2OK;
}
fmi2Status fmi2SetFMUstate(fmi2Component c, fmi2FMUstate state) {
    if (is("ignore_restore")) return fmi2OK;
    Model now = *M;
    memcpy(c, state, sizeof(Model));
#ifndef BALL
    if (is("forget_restore")) M->integer[0] += 1;
    if (is("maximum_restore")) M->maximum = now.maximum;
    if (is("input_restore")) M->real[U] = now.real[U];
    if (is("parameter_restore")) M->real[K] = now.real[K];
#endif
    return fmi2OK;
}
fmi2Status fmi2FreeFMUstate(fmi2Component c, fmi2FMUstate *state) { (void)c; misbehave("freestate"); free(*state); *state = NULL; return fmi2OK; }
fmi2Status fmi2SerializedFMUstateSize(fmi2Component c, fmi2FMUstate state, size_t *size) {
    (void)state;
    if (is("error_size")) return fail(M, "unknown size");
    *size = sizeof(Model);
    return fmi2OK;
}
fmi2Status fmi2SerializeFMUstate(fmi2Component c, fmi2FMUstate state, fmi2Byte data[], size_t size) { (void)c; memcpy(data, state, size); return fmi2OK; }
fmi2Status fmi2DeSerializeFMUstate(fmi2Component c, const fmi2Byte data[], size_t size, fmi2FMUstate *state) {
    if (is("error_read")) return fail(M, "not a state of this version");
    *state = malloc(sizeof(Model));
    memcpy(*state, data, size);
    if (is("forget_bytes")) ((Model *)*state)->real[0] = 0.7;
    if (is("maximum_bytes")) ((Model *)*state)->maximum = 0;
    return fmi2OK;
}
fmi2Status fmi2GetDirectionalDerivative(fmi2Component c, const fmi2ValueReference unknown[], size_t nu, const fmi2ValueReference known[], size_t nk,
                                        const fmi2Real seed[], fmi2Real result[]) {
    misbehave("derivative");
    if (is("error_derivative")) return fail(M, "no derivative");
    for (size_t i = 0; i < nu; i++) {
        result[i] = 0;
#ifndef BALL
        for (size_t j = 0; j < nk; j++) {
            int u = (int)unknown[i], k = (int)known[j];
            double d = u == DER_X && k == X ? -M->real[K] : u == DER_X && k == U ? 1 : u == Y && k == X ? 1 : u == Y && k == U ? 2 : 0;
            result[i] += d * seed[j] * (is("wrong_derivative") && u == Y ? 1.01 : 1);
        }
#else
        (void)unknown, (void)known, (void)nk, (void)seed;
#endif
        if (is("nan_derivative")) result[i] = NAN;
    }
    return fmi2OK;
}

/* Model exchange */
fmi2Status fmi2EnterEventMode(fmi2Component c) { REQUIRE(M->phase == CONTINUOUS || M->phase == EVENT); M->phase = EVENT; return fmi2OK; }
fmi2Status fmi2NewDiscreteStates(fmi2Component c, fmi2EventInfo *info) {
    misbehave("event");
    REQUIRE(M->phase == EVENT);
    memset(info, 0, sizeof *info);
    info->newDiscreteStatesNeeded = event(M);
    info->terminateSimulation = is("ends");
    info->nextEventTimeDefined = isfinite(M->next), info->nextEventTime = M->next;
    return fmi2OK;
}
fmi2Status fmi2EnterContinuousTimeMode(fmi2Component c) { REQUIRE(M->phase == EVENT); M->phase = CONTINUOUS; return fmi2OK; }
fmi2Status fmi2CompletedIntegratorStep(fmi2Component c, fmi2Boolean same, fmi2Boolean *enter, fmi2Boolean *ends) { (void)same; REQUIRE(M->phase == CONTINUOUS); remember(M); *enter = *ends = 0; return fmi2OK; }
fmi2Status fmi2SetTime(fmi2Component c, fmi2Real time) { M->time = time; return fmi2OK; }
fmi2Status fmi2SetContinuousStates(fmi2Component c, const fmi2Real x[], size_t n) {
    REQUIRE(M->phase == CONTINUOUS);
    if (!is("ignore_states")) LOOP M->real[states[i]] = x[i];
    return fmi2OK;
}
fmi2Status fmi2GetDerivatives(fmi2Component c, fmi2Real d[], size_t n) {
    misbehave("rates");
    evaluate(M);
    if (is("error_rates")) return fail(M, "division by zero");
    LOOP d[i] = is("rate_variable") ? 7 : M->real[rates[i]];
    if (is("more_rates")) d[n] = 0;
    return fmi2OK;
}
fmi2Status fmi2GetEventIndicators(fmi2Component c, fmi2Real z[], size_t n) {
    (void)n;
    if (is("fewer_indicators")) return fmi2OK;
    indicators(M, z);
    if (is("more_indicators")) z[NZ] = 1;
    return fmi2OK;
}
fmi2Status fmi2GetContinuousStates(fmi2Component c, fmi2Real x[], size_t n) {
    if (is("fewer_states")) return fmi2OK;
    LOOP x[i] = M->real[states[i]];
    return fmi2OK;
}
fmi2Status fmi2GetNominalsOfContinuousStates(fmi2Component c, fmi2Real x[], size_t n) { (void)c; LOOP x[i] = is("nominal") ? -1 : 1; return fmi2OK; }

/* Co-simulation */
fmi2Status fmi2SetRealInputDerivatives(fmi2Component c, const fmi2ValueReference vr[], size_t n, const fmi2Integer order[], const fmi2Real value[]) {
    (void)vr, (void)n, (void)order, (void)value;
    return fail(M, "not provided");
}
fmi2Status fmi2GetRealOutputDerivatives(fmi2Component c, const fmi2ValueReference vr[], size_t n, const fmi2Integer order[], fmi2Real value[]) {
    (void)vr, (void)order;
    if (is("error_output_derivative")) return fail(M, "order not provided");
    LOOP value[i] = is("nan_output_derivative") ? NAN : M->real[rates[0]];
    return fmi2OK;
}
fmi2Status fmi2DoStep(fmi2Component c, fmi2Real from, fmi2Real step, fmi2Boolean none) {
    (void)none;
    misbehave("step");
    if (is("hang_nan") && isnan(step)) hang();
    if (is("crash_negative") && step < 0) crash();
    if (is("any_step") && M->phase != FAILED && !(step > 0)) return fmi2OK;
    if (is("any_phase") && M->phase == INSTANTIATED) return fmi2OK;
    REQUIRE(M->phase == STEP);
    if (!(step > 0) || fabs(from - M->time) > 1e-9) return fail(M, "wrong step");
    if (is("error_step") && M->time > 0.1) return fail(M, "solver failed");
    if (is("fatal_step") && M->time > 0.1) { say(M, fmi2Fatal, "memory is corrupt"); return fmi2Fatal; }
    if (is("discard_step") && M->time > 0.1) { say(M, fmi2Discard, "step too long"); return fmi2Discard; }
    if (is("status_step") && M->time > 0.1) return (fmi2Status)7;
    if (is("fixed_step") && M->calls++ && fabs(step - 0.01) > 1e-12) return fail(M, "another step");
#ifndef BALL
    shared += 1;
#endif
    for (double end = M->time + step; M->time < end - 1e-12; ) {
        double h = fmin(INTERNAL, end - M->time), old[NZ], now[NZ];
        indicators(M, old);
        evaluate(M);
        for (int i = 0; i < NX; i++) M->real[states[i]] += h * M->real[rates[i]];
        remember(M);
        M->time = end - M->time <= INTERNAL ? end : M->time + h;
        indicators(M, now);
        if ((old[0] > 0) != (now[0] > 0) || M->time >= M->next) event(M);
    }
    evaluate(M);
    return fmi2OK;
}
fmi2Status fmi2CancelStep(fmi2Component c) { return fail(M, "not provided"); }
fmi2Status fmi2GetStatus(fmi2Component c, const fmi2StatusKind kind, fmi2Status *value) { (void)c, (void)kind; *value = fmi2OK; return fmi2OK; }
fmi2Status fmi2GetRealStatus(fmi2Component c, const fmi2StatusKind kind, fmi2Real *value) { (void)kind; *value = M->time; return fmi2OK; }
fmi2Status fmi2GetIntegerStatus(fmi2Component c, const fmi2StatusKind kind, fmi2Integer *value) { (void)kind, (void)value; return fail(M, "not provided"); }
fmi2Status fmi2GetBooleanStatus(fmi2Component c, const fmi2StatusKind kind, fmi2Boolean *value) { (void)c, (void)kind; *value = 0; return fmi2OK; }
#ifndef MISSING_SYMBOL
fmi2Status fmi2GetStringStatus(fmi2Component c, const fmi2StatusKind kind, fmi2String *value) { (void)kind, (void)value; return fail(M, "not provided"); }
#endif

#ifdef CONSTRUCTOR
__attribute__((constructor)) static void loaded(void) { CONSTRUCTOR; }
#endif
#ifdef UNDEFINED
extern int nowhere_defined(void);
int uses(void) { return nowhere_defined(); }
#endif
