/* An FMU of FMI 3.0 for tests of the check, of every kind: arrays with a structural size n, every type, clocks.
   der(x) = A x + u, y = x + u, z = x[0] - 0.5; the others pass their input to their output.
   Co-simulation: an intermediate update after every fifth internal step; early return on request, and where z changes its sign.
   Scheduled execution: a partition for each input clock; every third tick of the sampler starts the countdown of the timer. */
#include <math.h>
#include "fmi3Functions.h"
#include "faults.h"

#define MOST 4
#define BLOB 16
#define INTERNAL 1e-3
#define MESSAGE "tick"

typedef enum { INSTANTIATED, CONFIGURATION, INITIALISATION, EVENT, CONTINUOUS, STEP, ACTIVE, TERMINATED, FAILED } Phase;
typedef enum { F64, F32, I8, U8, I16, U16, I32, U32, I64, U64, BOOL, TEXT, BINARY, CLOCK } Type;
enum { TIME, N, A, U, X, DER_X, Y, F32_IN, F32_OUT, FIRST_INT, TRUTH = FIRST_INT + 16, TRUTH_OUT, WORD, WORD_OUT, DATA, DATA_OUT, COLOUR, COLOUR_OUT,
       TRIGGER, TICK, COUNT, Z, TIMER, NOTE, SAMPLER, SAMPLES, VARIABLES };

typedef struct {
    double time, a[MOST * MOST], u[MOST], x[MOST], rate[MOST], y[MOST], z, maximum; /* the largest u[0] - 1 so far */
    uint64_t n;
    float f32[2];
    int8_t i8[2]; uint8_t u8[2]; int16_t i16[2]; uint16_t u16[2]; int32_t i32[2], count, samples; uint32_t u32[2]; int64_t i64[2], colour[2]; uint64_t u64[2];
    bool truth[2], trigger, tick, timer, sampler, known, kept;
    char word[2][64], blob[2][BLOB];
    size_t sizes[2];
    Phase phase;
    bool exchange, events, early;
    fmi3IntermediateUpdateCallback update;
    fmi3ClockUpdateCallback clocks;
    fmi3LockPreemptionCallback lock;
    fmi3UnlockPreemptionCallback unlock;
    fmi3LogMessageCallback log;
    fmi3InstanceEnvironment environment;
} Model;

#define M ((Model *)c)

static double shared_maximum;

static void start(Model *m) {
    shared_maximum = 0;
    static const double a[] = { -1, 0, 0, -2 };
    m->n = 2, m->x[1] = 1, m->u[0] = 1, m->u[1] = 2;
    memcpy(m->a, a, sizeof a);
    m->f32[0] = 0.1f, m->u8[0] = 1, m->i16[0] = 2, m->u16[0] = 3, m->i32[0] = 4, m->u32[0] = 5, m->i64[0] = 6, m->u64[0] = 7;
    m->colour[0] = 1, strcpy(m->word[0], "grey"), strcpy(m->blob[0], "data"), m->sizes[0] = 4;
    if (is("other_data")) m->blob[0][0] = 0, m->sizes[0] = 1;
}

static void evaluate(Model *m) {
    for (size_t i = 0; i < m->n; i++) {
        m->rate[i] = m->u[i], m->y[i] = m->x[i] + m->u[i];
        for (size_t j = 0; j < m->n; j++) m->rate[i] += m->a[i * m->n + j] * m->x[j];
    }
    if (strstr(fault, "maximum_")) m->y[0] += m->maximum;
    if (is("shared_maximum")) m->y[0] += shared_maximum;
    m->z = m->n ? m->x[0] - 0.5 : 1;
    m->f32[1] = m->f32[0], m->i8[1] = m->i8[0], m->u8[1] = m->u8[0], m->i16[1] = m->i16[0], m->u16[1] = m->u16[0], m->i32[1] = m->i32[0];
    m->u32[1] = m->u32[0], m->i64[1] = m->i64[0], m->u64[1] = m->u64[0], m->truth[1] = m->truth[0], m->colour[1] = is("no_item") ? 9 : m->colour[0];
    strcpy(m->word[1], m->kept ? "new" : is("unsteady_text") && m->time > 0 ? "\xff" : m->word[0]), memcpy(m->blob[1], m->blob[0], BLOB), m->sizes[1] = m->sizes[0] + is("long_data");
}

/* Type, storage and number of elements of a variable; NULL where there is none. */
static void *variable(Model *m, fmi3ValueReference vr, Type type, size_t *count) {
    void *ints[] = { m->i8, m->u8, m->i16, m->u16, m->i32, m->u32, m->i64, m->u64 };
    *count = 1;
#define FOUND(t, place, elements) do { *count = elements; return type == t ? (void *)(place) : NULL; } while (0)
    switch (vr) {
        case TIME: FOUND(F64, &m->time, 1);
        case N: FOUND(U64, &m->n, 1);
        case A: FOUND(F64, m->a, m->n * m->n);
        case U: FOUND(F64, m->u, m->n);
        case X: FOUND(F64, m->x, m->n);
        case DER_X: FOUND(F64, m->rate, m->n);
        case Y: FOUND(F64, m->y, m->n);
        case Z: FOUND(F64, &m->z, 1);
        case F32_IN: case F32_OUT: FOUND(F32, &m->f32[vr - F32_IN], 1);
        case TRUTH: case TRUTH_OUT: FOUND(BOOL, &m->truth[vr - TRUTH], 1);
        case COLOUR: case COLOUR_OUT: FOUND(I64, &m->colour[vr - COLOUR], 1);
        case COUNT: FOUND(I32, &m->count, 1);
        case TRIGGER: FOUND(CLOCK, &m->trigger, 1);
        case TICK: FOUND(CLOCK, &m->tick, 1);
        case TIMER: FOUND(CLOCK, &m->timer, 1);
        case SAMPLER: FOUND(CLOCK, &m->sampler, 1);
        case SAMPLES: FOUND(I32, &m->samples, 1);
    }
    if (vr >= FIRST_INT && vr < TRUTH && type == (Type)(I8 + (vr - FIRST_INT) / 2)) {
        size_t k = (vr - FIRST_INT) / 2, width = k < 2 ? 1 : k < 4 ? 2 : k < 6 ? 4 : 8;
        return (char *)ints[k] + (vr - FIRST_INT) % 2 * width;
    }
    return NULL;
}

static void remember(Model *m) { m->maximum = fmax(m->maximum, m->u[0] - 1), shared_maximum = fmax(shared_maximum, m->u[0] - 1); }

static fmi3Status fail(Model *m, const char *text) {
    m->phase = FAILED;
    m->log(m->environment, fmi3Error, "logStatusError", text);
    return fmi3Error;
}
#define REQUIRE(condition) if (!(condition)) return fail(M, "call not allowed here")
#define LOOP for (size_t i = 0; i < n; i++)

static bool settable(Model *m, fmi3ValueReference vr) {
    bool early = m->phase == INSTANTIATED || m->phase == INITIALISATION;
    if (m->phase == CONFIGURATION) return vr == N && !is("refuse_size");
    if (vr == A) return early || m->phase == EVENT || (m->phase == STEP && !m->events);
    if (vr >= FIRST_INT && vr < TRUTH) return (vr - FIRST_INT) % 2 == 0;
    return vr == U || vr == F32_IN || vr == TRUTH || vr == COLOUR || (vr == X && early);
}

#define ACCESS(NAME, TYPE, KIND)                                                                                                       \
    fmi3Status fmi3Get##NAME(fmi3Instance c, const fmi3ValueReference vr[], size_t n, TYPE value[], size_t nv) {                        \
        size_t at = 0, count;                                                                                                          \
        if (M->phase != STEP && M->phase != INSTANTIATED) evaluate(M);                                                                 \
        LOOP {                                                                                                                         \
            TYPE *from = variable(M, vr[i], KIND, &count);                                                                             \
            if (!from || at + count > nv) return fail(M, "wrong value reference or number of values");                                  \
            memcpy(value + at, from, count * sizeof(TYPE)), at += count;                                                               \
        }                                                                                                                              \
        return at == nv ? fmi3OK : fail(M, "wrong number of values");                                                                   \
    }                                                                                                                                  \
    fmi3Status fmi3Set##NAME(fmi3Instance c, const fmi3ValueReference vr[], size_t n, const TYPE value[], size_t nv) {                  \
        size_t at = 0, count;                                                                                                          \
        LOOP {                                                                                                                         \
            TYPE *to = variable(M, vr[i], KIND, &count);                                                                               \
            if (!to || at + count > nv || !settable(M, vr[i])) return fail(M, "cannot be set");                                         \
            memcpy(to, value + at, count * sizeof(TYPE)), at += count;                                                                 \
        }                                                                                                                              \
        return at == nv ? fmi3OK : fail(M, "wrong number of values");                                                                   \
    }
ACCESS(Float64, fmi3Float64, F64) ACCESS(Float32, fmi3Float32, F32) ACCESS(Int8, fmi3Int8, I8) ACCESS(UInt8, fmi3UInt8, U8)
ACCESS(Int16, fmi3Int16, I16) ACCESS(UInt16, fmi3UInt16, U16) ACCESS(Int32, fmi3Int32, I32) ACCESS(UInt32, fmi3UInt32, U32)
ACCESS(Int64, fmi3Int64, I64) ACCESS(UInt64, fmi3UInt64, U64) ACCESS(Boolean, fmi3Boolean, BOOL)

fmi3Status fmi3GetString(fmi3Instance c, const fmi3ValueReference vr[], size_t n, fmi3String value[], size_t nv) {
    (void)nv, evaluate(M);
    LOOP { REQUIRE(vr[i] == WORD || vr[i] == WORD_OUT); value[i] = M->word[vr[i] - WORD]; }
    return fmi3OK;
}
fmi3Status fmi3SetString(fmi3Instance c, const fmi3ValueReference vr[], size_t n, const fmi3String value[], size_t nv) {
    (void)nv;
    LOOP { REQUIRE(vr[i] == WORD); snprintf(M->word[0], 64, "%s", value[i]); }
    return fmi3OK;
}
fmi3Status fmi3GetBinary(fmi3Instance c, const fmi3ValueReference vr[], size_t n, size_t sizes[], fmi3Binary value[], size_t nv) {
    (void)nv, evaluate(M);
    LOOP {
        REQUIRE(vr[i] == DATA || vr[i] == DATA_OUT || (vr[i] == NOTE && M->trigger && !is("error_note")));
        if (vr[i] == NOTE) { sizes[i] = sizeof MESSAGE, value[i] = (fmi3Binary)MESSAGE; continue; }
        sizes[i] = M->sizes[vr[i] - DATA], value[i] = is("null_binary") ? NULL : (fmi3Binary)M->blob[vr[i] - DATA];
    }
    return fmi3OK;
}
fmi3Status fmi3SetBinary(fmi3Instance c, const fmi3ValueReference vr[], size_t n, const size_t sizes[], const fmi3Binary value[], size_t nv) {
    (void)nv;
    LOOP { REQUIRE(vr[i] == DATA && sizes[i] <= BLOB); memcpy(M->blob[0], value[i], sizes[i]), M->sizes[0] = sizes[i]; }
    return fmi3OK;
}
fmi3Status fmi3GetClock(fmi3Instance c, const fmi3ValueReference vr[], size_t n, fmi3Clock value[]) {
    REQUIRE(!is("error_clock") && (M->phase == EVENT || M->phase == ACTIVE));
    LOOP { size_t count; bool *clock = variable(M, vr[i], CLOCK, &count); REQUIRE(clock); value[i] = *clock; }
    return fmi3OK;
}
fmi3Status fmi3SetClock(fmi3Instance c, const fmi3ValueReference vr[], size_t n, const fmi3Clock value[]) {
    LOOP {
        REQUIRE((vr[i] == TRIGGER || vr[i] == SAMPLER) && M->phase == EVENT && !is("error_set_clock"));
        if (vr[i] == SAMPLER) M->sampler = value[i];
        else M->trigger = M->tick = value[i];
    }
    return fmi3OK;
}

const char *fmi3GetVersion(void) { return fmi3Version; }
fmi3Status fmi3SetDebugLogging(fmi3Instance c, fmi3Boolean on, size_t n, const fmi3String names[]) { (void)c, (void)on, (void)n, (void)names; return fmi3OK; }

static fmi3Instance instantiate(fmi3String token, fmi3String resources, fmi3InstanceEnvironment environment, fmi3LogMessageCallback log, bool exchange, bool events) {
    read_fault(resources);
    misbehave("instantiate");
    Model temporary = { .log = log, .environment = environment };
    if (strcmp(token, "{bench}") != 0) { fail(&temporary, "wrong token"); return NULL; }
    if (events && is("no_event_mode")) { fail(&temporary, "event mode is not supported"); return NULL; }
    Model *m = calloc(1, sizeof(Model));
    m->log = log, m->environment = environment, m->exchange = exchange, m->events = events;
    start(m), evaluate(m);
    return m;
}
fmi3Instance fmi3InstantiateModelExchange(fmi3String name, fmi3String token, fmi3String resources, fmi3Boolean visible, fmi3Boolean logging,
                                          fmi3InstanceEnvironment environment, fmi3LogMessageCallback log) {
    (void)name, (void)visible, (void)logging;
    return instantiate(token, resources, environment, log, true, true);
}
fmi3Instance fmi3InstantiateCoSimulation(fmi3String name, fmi3String token, fmi3String resources, fmi3Boolean visible, fmi3Boolean logging, fmi3Boolean events,
                                         fmi3Boolean early, const fmi3ValueReference required[], size_t n, fmi3InstanceEnvironment environment,
                                         fmi3LogMessageCallback log, fmi3IntermediateUpdateCallback update) {
    (void)name, (void)visible, (void)logging, (void)required, (void)n;
    Model *m = instantiate(token, resources, environment, log, false, events);
    if (m) m->early = early || is("early_unasked"), m->update = is("no_update") ? NULL : update;
    return m;
}
fmi3Instance fmi3InstantiateScheduledExecution(fmi3String name, fmi3String token, fmi3String resources, fmi3Boolean visible, fmi3Boolean logging,
                                               fmi3InstanceEnvironment environment, fmi3LogMessageCallback log, fmi3ClockUpdateCallback update,
                                               fmi3LockPreemptionCallback lock, fmi3UnlockPreemptionCallback unlock) {
    (void)name, (void)visible, (void)logging;
    Model *m = instantiate(token, resources, environment, log, false, false);
    if (m) m->clocks = update, m->lock = lock, m->unlock = unlock;
    return m;
}
void fmi3FreeInstance(fmi3Instance c) { free(c); }
fmi3Status fmi3EnterInitializationMode(fmi3Instance c, fmi3Boolean td, fmi3Float64 tolerance, fmi3Float64 begin, fmi3Boolean sd, fmi3Float64 stop) {
    (void)td, (void)tolerance, (void)sd, (void)stop;
    REQUIRE(M->phase == INSTANTIATED);
    M->phase = INITIALISATION, M->time = begin;
    return fmi3OK;
}
fmi3Status fmi3ExitInitializationMode(fmi3Instance c) { REQUIRE(M->phase == INITIALISATION); evaluate(M); M->phase = M->clocks ? ACTIVE : M->events ? EVENT : STEP; return fmi3OK; }
fmi3Status fmi3EnterEventMode(fmi3Instance c) { REQUIRE(M->phase == CONTINUOUS || M->phase == STEP || M->phase == EVENT); M->phase = EVENT; return fmi3OK; }
fmi3Status fmi3Terminate(fmi3Instance c) { REQUIRE(M->phase == EVENT || M->phase == CONTINUOUS || M->phase == STEP || M->phase == ACTIVE); M->phase = TERMINATED; return fmi3OK; }
fmi3Status fmi3Reset(fmi3Instance c) {
    Model fresh = { .log = M->log, .environment = M->environment, .exchange = M->exchange, .events = M->events, .early = M->early,
                    .update = M->update, .clocks = M->clocks, .lock = M->lock, .unlock = M->unlock };
    fresh.kept = is("keeps_text");
    start(&fresh);
    if (is("maximum_reset")) fresh.maximum = M->maximum;
    if (is("parameter_reset")) memcpy(fresh.a, M->a, sizeof fresh.a);
    evaluate(&fresh);
    *M = fresh;
    return fmi3OK;
}
fmi3Status fmi3EnterConfigurationMode(fmi3Instance c) { REQUIRE(M->phase == INSTANTIATED); M->phase = CONFIGURATION; return fmi3OK; }
fmi3Status fmi3ExitConfigurationMode(fmi3Instance c) {
    REQUIRE(M->phase == CONFIGURATION);
    M->phase = INSTANTIATED;
    if (M->n > MOST) return fail(M, "n is above its maximum");
    if (is("forget_size")) M->n = 2;
    return fmi3OK;
}

#define ABSENT(name, ...) fmi3Status name(fmi3Instance c, __VA_ARGS__) { return fail(M, "not provided"); }
#define VRS const fmi3ValueReference vr[], size_t n
ABSENT(fmi3GetNumberOfVariableDependencies, fmi3ValueReference vr, size_t *n)
ABSENT(fmi3GetVariableDependencies, fmi3ValueReference vr, size_t a[], fmi3ValueReference b[], size_t d[], fmi3DependencyKind e[], size_t n)
ABSENT(fmi3GetIntervalFraction, VRS, fmi3UInt64 a[], fmi3UInt64 b[], fmi3IntervalQualifier d[])
ABSENT(fmi3GetShiftDecimal, VRS, fmi3Float64 a[])
ABSENT(fmi3GetShiftFraction, VRS, fmi3UInt64 a[], fmi3UInt64 b[])
ABSENT(fmi3SetIntervalDecimal, VRS, const fmi3Float64 a[])
ABSENT(fmi3SetIntervalFraction, VRS, const fmi3UInt64 a[], const fmi3UInt64 b[])
ABSENT(fmi3SetShiftDecimal, VRS, const fmi3Float64 a[])
ABSENT(fmi3SetShiftFraction, VRS, const fmi3UInt64 a[], const fmi3UInt64 b[])
ABSENT(fmi3GetOutputDerivatives, VRS, const fmi3Int32 order[], fmi3Float64 value[], size_t nv)
fmi3Status fmi3ActivateModelPartition(fmi3Instance c, fmi3ValueReference vr, fmi3Float64 time) {
    REQUIRE(M->phase == ACTIVE && !is("error_partition") && (vr == TRIGGER || vr == SAMPLER || vr == TIMER));
    M->time = time;
    M->lock();
    if (vr == TRIGGER) M->trigger = M->tick = true, M->count++;
    if (vr == SAMPLER && ++M->samples % 3 == 0) M->known = true;
    if (vr == TIMER) M->known = false;
    if (!is("stays_locked")) M->unlock();
    if (M->known || M->tick) M->clocks(M->environment);
    return fmi3OK;
}
fmi3Status fmi3EvaluateDiscreteStates(fmi3Instance c) { evaluate(M); return fmi3OK; }
fmi3Status fmi3GetIntervalDecimal(fmi3Instance c, VRS, fmi3Float64 interval[], fmi3IntervalQualifier qualifier[]) {
    LOOP {
        REQUIRE(vr[i] == TIMER);
        interval[i] = is("negative_interval") ? -1 : M->clocks ? 0.05 : 0.5;
        qualifier[i] = !M->clocks || M->known ? fmi3IntervalChanged : fmi3IntervalNotYetKnown;
    }
    return fmi3OK;
}

fmi3Status fmi3GetFMUState(fmi3Instance c, fmi3FMUState *state) { if (!*state) *state = malloc(sizeof(Model)); memcpy(*state, c, sizeof(Model)); return fmi3OK; }
fmi3Status fmi3SetFMUState(fmi3Instance c, fmi3FMUState state) {
    Model now = *M;
    memcpy(c, state, sizeof(Model));
    if (is("maximum_restore")) M->maximum = now.maximum;
    if (is("parameter_restore")) memcpy(M->a, now.a, sizeof now.a);
    return fmi3OK;
}
fmi3Status fmi3FreeFMUState(fmi3Instance c, fmi3FMUState *state) { (void)c; free(*state); *state = NULL; return fmi3OK; }
fmi3Status fmi3SerializedFMUStateSize(fmi3Instance c, fmi3FMUState state, size_t *size) { (void)c, (void)state; *size = sizeof(Model); return fmi3OK; }
fmi3Status fmi3SerializeFMUState(fmi3Instance c, fmi3FMUState state, fmi3Byte data[], size_t size) { (void)c; memcpy(data, state, size); return fmi3OK; }
fmi3Status fmi3DeserializeFMUState(fmi3Instance c, const fmi3Byte data[], size_t size, fmi3FMUState *state) {
    (void)c; *state = malloc(sizeof(Model)); memcpy(*state, data, size);
    if (is("maximum_bytes")) ((Model *)*state)->maximum = 0;
    return fmi3OK;
}

/* Elements of the Jacobian of der(x) and y by x and u. */
static double partial(Model *m, fmi3ValueReference unknown, size_t i, fmi3ValueReference known, size_t j) {
    double wrong = is("wrong_element") && unknown == Y && known == U && i == 1 && j == 1 ? 1.5 : 1;
    if (unknown == DER_X && known == X) return m->a[i * m->n + j];
    return (unknown == DER_X && known == U) || (unknown == Y && (known == X || known == U)) ? wrong * (i == j) : 0;
}
#define DERIVATIVE(NAME, FROM, NFROM, TO, NTO, PARTIAL)                                                                                \
    fmi3Status fmi3Get##NAME##Derivative(fmi3Instance c, const fmi3ValueReference unknowns[], size_t nu, const fmi3ValueReference knowns[], \
                                         size_t nk, const fmi3Float64 seed[], size_t ns, fmi3Float64 result[], size_t nr) {             \
        size_t n = M->n;                                                                                                               \
        if (ns != NFROM * n || nr != NTO * n) return fail(M, "wrong number of elements");                                               \
        for (size_t a = 0; a < NTO; a++) LOOP {                                                                                        \
            result[a * n + i] = 0;                                                                                                     \
            for (size_t b = 0; b < NFROM; b++) for (size_t j = 0; j < n; j++) result[a * n + i] += PARTIAL * seed[b * n + j];            \
            if (is("wrong_adjoint") && #NAME[0] == 'A') result[a * n + i] += 0.5;                                                       \
        }                                                                                                                              \
        return fmi3OK;                                                                                                                 \
    }
DERIVATIVE(Directional, knowns, nk, unknowns, nu, partial(M, unknowns[a], i, knowns[b], j))
DERIVATIVE(Adjoint, unknowns, nu, knowns, nk, partial(M, unknowns[b], j, knowns[a], i))

fmi3Status fmi3UpdateDiscreteStates(fmi3Instance c, fmi3Boolean *again, fmi3Boolean *ends, fmi3Boolean *nominals, fmi3Boolean *values, fmi3Boolean *defined, fmi3Float64 *next) {
    REQUIRE(M->phase == EVENT);
    M->count += M->trigger, M->samples += M->sampler;
    M->trigger = M->tick = M->sampler = false;
    *again = *ends = *nominals = *values = *defined = false, *next = 0;
    return fmi3OK;
}
fmi3Status fmi3EnterContinuousTimeMode(fmi3Instance c) { REQUIRE(M->phase == EVENT); M->phase = CONTINUOUS; return fmi3OK; }
fmi3Status fmi3EnterStepMode(fmi3Instance c) { REQUIRE(M->phase == EVENT); M->phase = STEP; return fmi3OK; }
fmi3Status fmi3CompletedIntegratorStep(fmi3Instance c, fmi3Boolean none, fmi3Boolean *enter, fmi3Boolean *ends) { (void)none; remember(M); *enter = *ends = false; return fmi3OK; }
fmi3Status fmi3SetTime(fmi3Instance c, fmi3Float64 time) { M->time = time; return fmi3OK; }
fmi3Status fmi3SetContinuousStates(fmi3Instance c, const fmi3Float64 x[], size_t n) { REQUIRE(n == M->n); LOOP M->x[i] = x[i]; return fmi3OK; }
fmi3Status fmi3GetContinuousStateDerivatives(fmi3Instance c, fmi3Float64 d[], size_t n) { REQUIRE(n == M->n); evaluate(M); LOOP d[i] = M->rate[i]; return fmi3OK; }
fmi3Status fmi3GetEventIndicators(fmi3Instance c, fmi3Float64 z[], size_t n) { REQUIRE(n == 1); evaluate(M); z[0] = M->z; return fmi3OK; }
fmi3Status fmi3GetContinuousStates(fmi3Instance c, fmi3Float64 x[], size_t n) { REQUIRE(n == M->n); LOOP x[i] = M->x[i]; return fmi3OK; }
fmi3Status fmi3GetNominalsOfContinuousStates(fmi3Instance c, fmi3Float64 x[], size_t n) { (void)c; LOOP x[i] = 1; return fmi3OK; }
fmi3Status fmi3GetNumberOfEventIndicators(fmi3Instance c, size_t *n) { (void)c; *n = is("count_indicators") ? 2 : 1; return fmi3OK; }
fmi3Status fmi3GetNumberOfContinuousStates(fmi3Instance c, size_t *n) { *n = is("count_states") ? 5 : M->n; return fmi3OK; }
fmi3Status fmi3DoStep(fmi3Instance c, fmi3Float64 from, fmi3Float64 step, fmi3Boolean none, fmi3Boolean *event, fmi3Boolean *ends, fmi3Boolean *early, fmi3Float64 *last) {
    (void)none;
    REQUIRE(M->phase == STEP && step > 0 && fabs(from - M->time) < 1e-9);
    double before = M->z, end = from + step, until = end;
    bool asked = false, crossed = false;
    for (int k = 1; M->time < until - 1e-12 && !(crossed && M->early); k++) {
        double h = fmin(INTERNAL, until - M->time);
        evaluate(M);
        for (size_t i = 0; i < M->n; i++) M->x[i] += h * M->rate[i];
        remember(M);
        M->time = until - M->time <= INTERNAL ? until : M->time + h;
        evaluate(M);
        crossed = (before > 0) != (M->z > 0);
        if (M->update && k % 5 == 0 && !asked) {
            double at = is("late_update") ? end + 1 : is("backward_update") ? from - (k > 5) * INTERNAL : M->time, wanted = until;
            M->update(M->environment, at, true, true, true, M->early, &asked, &wanted);
            if (asked && !is("deaf")) until = fmax(wanted, M->time);
        }
    }
    *ends = false, *early = M->early && (M->time < end - 1e-12 || is("early_unasked")), *event = M->events && crossed;
    *last = is("last_time") ? -1 : is("far_time") ? 7 : M->time;
    if (is("early_unasked")) *last -= INTERNAL;
    if (is("early_before") && asked) *last = from;
    return fmi3OK;
}
