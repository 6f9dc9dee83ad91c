/* The interface of the layered standard fmi-ls-wasm (draft) on the functions of FMI 3.0.

   The functions follow the canonical ABI of the WebAssembly Component Model: a list or string is a pointer and a length,
   an option a flag and a value, and a result of more than one number a pointer to it, with the layout of the structures
   below. The host obtains memory for arguments from component_realloc. All memory of a call is released by
   component_after, which the host calls when it has read the result. The interface itself is fmus/export/wasm_interface.py. */

#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include "fmi3_host.h"

#define EXPORT __attribute__((visibility("default")))

typedef struct {
    void *data;
    size_t length;
} List;

typedef struct {
    uint8_t failed;
    union {
        List list;
        uint8_t status;
    } is;
} ListResult;

typedef struct {
    uint8_t failed;
    union {
        uint64_t number;
        uint8_t status;
    } is;
} NumberResult;

/* Memory of one call ---------------------------------------------------------------------------------------- */

typedef struct Block Block;
struct Block {
    Block *next;
    double aligned; /* the data behind it are aligned for every type */
};

static Block *blocks;

static void *allocate(size_t size)
{
    Block *block = malloc(sizeof *block + size);
    if (!block) __builtin_trap();
    block->next = blocks;
    blocks = block;
    return block + 1;
}

EXPORT void *component_realloc(void *old, size_t old_size, size_t alignment, size_t size)
{
    (void)alignment; /* at most 8; blocks have 16 */
    void *data = allocate(size);
    if (old_size > 0) memcpy(data, old, old_size < size ? old_size : size);
    return data;
}

EXPORT void component_after(int32_t result)
{
    (void)result;
    while (blocks) {
        Block *next = blocks->next;
        free(blocks);
        blocks = next;
    }
}

static char *terminated(const char *text, size_t length)
{
    char *copy = allocate(length + 1);
    memcpy(copy, text, length);
    copy[length] = 0;
    return copy;
}

/* Results --------------------------------------------------------------------------------------------------- */

static int failed(fmi3Status status) { return status != fmi3OK && status != fmi3Warning; }

static const ListResult *list_result(fmi3Status status, void *data, size_t length)
{
    static ListResult result;
    result.failed = failed(status);
    if (result.failed) result.is.status = status;
    else result.is.list = (List){data, length};
    return &result;
}

static const NumberResult *number_result(fmi3Status status, uint64_t number)
{
    static NumberResult result;
    result.failed = failed(status);
    if (result.failed) result.is.status = status;
    else result.is.number = number;
    return &result;
}

/* Creation -------------------------------------------------------------------------------------------------- */

typedef struct {
    uint8_t is_there;
    Instance *instance;
} InstanceOption;

static const InstanceOption *instance_option(fmi3Instance instance)
{
    static InstanceOption option;
    option = (InstanceOption){instance != NULL, instance};
    return &option;
}

EXPORT const List *component_get_version(void)
{
    static List version;
    version = (List){(void *)fmi3GetVersion(), strlen(fmi3GetVersion())};
    return &version;
}

EXPORT const InstanceOption *component_instantiate_model_exchange(const char *name, size_t n_name, const char *token, size_t n_token, const char *resources,
                                                                  size_t n_resources, int visible, int logging)
{
    (void)resources, (void)n_resources;
    return instance_option(fmi3InstantiateModelExchange(terminated(name, n_name), terminated(token, n_token), NULL, visible != 0, logging != 0, NULL, NULL));
}

EXPORT const InstanceOption *component_instantiate_co_simulation(const char *name, size_t n_name, const char *token, size_t n_token, const char *resources,
                                                                 size_t n_resources, int visible, int logging, int events, int early_return,
                                                                 const fmi3ValueReference *intermediate, size_t n_intermediate)
{
    (void)resources, (void)n_resources;
    return instance_option(fmi3InstantiateCoSimulation(terminated(name, n_name), terminated(token, n_token), NULL, visible != 0, logging != 0, events != 0,
                                                       early_return != 0, intermediate, n_intermediate, NULL, NULL, NULL));
}

EXPORT void component_free(Instance *s) { fmi3FreeInstance(s); }

EXPORT fmi3Status component_set_debug_logging(Instance *s, int logging, const List *categories, size_t n)
{
    fmi3String *names = allocate(n * sizeof *names);
    for (size_t i = 0; i < n; i++) names[i] = terminated(categories[i].data, categories[i].length);
    return fmi3SetDebugLogging(s, logging != 0, n, names);
}

/* Phases ---------------------------------------------------------------------------------------------------- */

EXPORT fmi3Status component_enter_initialization_mode(Instance *s, int has_tolerance, double tolerance, double start, int has_stop, double stop)
{
    return fmi3EnterInitializationMode(s, has_tolerance != 0, tolerance, start, has_stop != 0, stop);
}

#define CHANGES_PHASE(name, function) \
    EXPORT fmi3Status component_##name(Instance *s) { return function(s); }

CHANGES_PHASE(exit_initialization_mode, fmi3ExitInitializationMode)
CHANGES_PHASE(enter_event_mode, fmi3EnterEventMode)
CHANGES_PHASE(enter_step_mode, fmi3EnterStepMode)
CHANGES_PHASE(enter_continuous_time_mode, fmi3EnterContinuousTimeMode)
CHANGES_PHASE(terminate, fmi3Terminate)
CHANGES_PHASE(reset, fmi3Reset)
CHANGES_PHASE(enter_configuration_mode, fmi3EnterConfigurationMode)
CHANGES_PHASE(exit_configuration_mode, fmi3ExitConfigurationMode)
CHANGES_PHASE(evaluate_discrete_states, fmi3EvaluateDiscreteStates)

typedef struct {
    uint8_t failed;
    union {
        struct {
            uint8_t needed, terminate, nominals, values, next_defined;
            double next;
        } info;
        uint8_t status;
    } is;
} DiscreteResult;

EXPORT const DiscreteResult *component_update_discrete_states(Instance *s)
{
    static DiscreteResult result;
    fmi3Boolean needed, terminate, nominals, values, next_defined;
    double next;
    const fmi3Status status = fmi3UpdateDiscreteStates(s, &needed, &terminate, &nominals, &values, &next_defined, &next);
    result.failed = failed(status);
    if (result.failed) {
        result.is.status = status;
        return &result;
    }
    result.is.info.needed = needed, result.is.info.terminate = terminate, result.is.info.nominals = nominals;
    result.is.info.values = values, result.is.info.next_defined = next_defined, result.is.info.next = next;
    return &result;
}

/* Values ---------------------------------------------------------------------------------------------------- */

#define VALUES(name, Type)                                                                                                    \
    EXPORT const ListResult *component_get_##name(Instance *s, const fmi3ValueReference *vr, size_t n)                        \
    {                                                                                                                         \
        fmi3##Type *values = allocate(n * sizeof *values);                                                                    \
        return list_result(fmi3Get##Type(s, vr, n, values, n), values, n);                                                    \
    }                                                                                                                         \
    EXPORT fmi3Status component_set_##name(Instance *s, const fmi3ValueReference *vr, size_t n, const void *values, size_t n_values) \
    {                                                                                                                         \
        return fmi3Set##Type(s, vr, n, values, n_values);                                                                     \
    }

VALUES(float32, Float32)
VALUES(float64, Float64)
VALUES(int8, Int8)
VALUES(int16, Int16)
VALUES(int32, Int32)
VALUES(int64, Int64)
VALUES(uint8, UInt8)
VALUES(uint16, UInt16)
VALUES(uint32, UInt32)
VALUES(uint64, UInt64)

/* For types of which the model has no variables: a list is empty or refused. */
#define NONE_OF(name, got, set)                                                                                               \
    EXPORT const ListResult *component_get_##name(Instance *s, const fmi3ValueReference *vr, size_t n)                        \
    {                                                                                                                         \
        return list_result(got, NULL, 0);                                                                                     \
    }                                                                                                                         \
    EXPORT fmi3Status component_set_##name(Instance *s, const fmi3ValueReference *vr, size_t n, const void *values, size_t n_values) \
    {                                                                                                                         \
        (void)values, (void)n_values;                                                                                         \
        return set;                                                                                                           \
    }

NONE_OF(boolean, fmi3GetBoolean(s, vr, n, NULL, 0), fmi3SetBoolean(s, vr, n, NULL, 0))
NONE_OF(string, fmi3GetString(s, vr, n, NULL, 0), fmi3SetString(s, vr, n, NULL, 0))
NONE_OF(binary, fmi3GetBinary(s, vr, n, NULL, NULL, 0), fmi3SetBinary(s, vr, n, NULL, NULL, 0))
NONE_OF(clock, fmi3GetClock(s, vr, n, NULL), fmi3SetClock(s, vr, n, NULL))
NONE_OF(interval_decimal, fmi3GetIntervalDecimal(s, vr, n, NULL, NULL), fmi3SetIntervalDecimal(s, vr, n, NULL))
NONE_OF(interval_fraction, fmi3GetIntervalFraction(s, vr, n, NULL, NULL, NULL), fmi3SetIntervalFraction(s, vr, n, NULL, NULL))
NONE_OF(shift_decimal, fmi3GetShiftDecimal(s, vr, n, NULL), fmi3SetShiftDecimal(s, vr, n, NULL))
NONE_OF(shift_fraction, fmi3GetShiftFraction(s, vr, n, NULL, NULL), fmi3SetShiftFraction(s, vr, n, NULL, NULL))

EXPORT const NumberResult *component_get_number_of_variable_dependencies(Instance *s, fmi3ValueReference vr)
{
    size_t n = 0;
    const fmi3Status status = fmi3GetNumberOfVariableDependencies(s, vr, &n);
    return number_result(status, n);
}

EXPORT const ListResult *component_get_variable_dependencies(Instance *s, fmi3ValueReference dependent)
{
    return list_result(fmi3GetVariableDependencies(s, dependent, NULL, NULL, NULL, NULL, 0), NULL, 0);
}

/* State of the FMU ------------------------------------------------------------------------------------------ */

EXPORT const ListResult *component_get_fmu_state(Instance *s)
{
    fmi3FMUState state = NULL;
    size_t size = 0;
    fmi3Byte *bytes = NULL;
    fmi3Status status = fmi3GetFMUState(s, &state);
    if (status == fmi3OK) status = fmi3SerializedFMUStateSize(s, state, &size);
    if (status == fmi3OK) {
        bytes = allocate(size);
        status = fmi3SerializeFMUState(s, state, bytes, size);
    }
    if (state) fmi3FreeFMUState(s, &state);
    return list_result(status, bytes, size);
}

EXPORT fmi3Status component_set_fmu_state(Instance *s, const fmi3Byte *bytes, size_t size)
{
    fmi3FMUState state = NULL;
    fmi3Status status = fmi3DeserializeFMUState(s, bytes, size, &state);
    if (status == fmi3OK) status = fmi3SetFMUState(s, state);
    if (state) fmi3FreeFMUState(s, &state);
    return status;
}

/* Derivatives ----------------------------------------------------------------------------------------------- */

EXPORT const ListResult *component_get_directional_derivative(Instance *s, const fmi3ValueReference *unknowns, size_t n_unknowns, const fmi3ValueReference *knowns,
                                                              size_t n_knowns, const double *seed, size_t n_seed)
{
    double *sensitivity = allocate(n_unknowns * sizeof *sensitivity);
    return list_result(fmi3GetDirectionalDerivative(s, unknowns, n_unknowns, knowns, n_knowns, seed, n_seed, sensitivity, n_unknowns), sensitivity, n_unknowns);
}

EXPORT const ListResult *component_get_adjoint_derivative(Instance *s, const fmi3ValueReference *unknowns, size_t n_unknowns, const fmi3ValueReference *knowns,
                                                          size_t n_knowns, const double *seed, size_t n_seed)
{
    double *sensitivity = allocate(n_knowns * sizeof *sensitivity);
    return list_result(fmi3GetAdjointDerivative(s, unknowns, n_unknowns, knowns, n_knowns, seed, n_seed, sensitivity, n_knowns), sensitivity, n_knowns);
}

typedef struct {
    uint32_t reference, order;
} Derivative;

typedef struct {
    fmi3ValueReference *references;
    int *orders;
} Requests;

static Requests requests(const Derivative *given, size_t n)
{
    const Requests apart = {allocate(n * sizeof(fmi3ValueReference)), allocate(n * sizeof(int))};
    for (size_t i = 0; i < n; i++) apart.references[i] = given[i].reference, apart.orders[i] = (int)given[i].order;
    return apart;
}

EXPORT fmi3Status component_set_input_derivatives(Instance *instance, const Derivative *given, size_t n, const double *values, size_t n_values)
{
    const Requests apart = requests(given, n);
    Instance *s = called(instance, "set-input-derivatives", INITIALIZING | STEPPING, n == n_values);
    return s ? as_fmi3(set_slopes(s, apart.references, n, apart.orders, values)) : fmi3Error;
}

EXPORT const ListResult *component_get_output_derivatives(Instance *s, const Derivative *given, size_t n)
{
    const Requests apart = requests(given, n);
    double *values = allocate(n * sizeof *values);
    return list_result(fmi3GetOutputDerivatives(s, apart.references, n, apart.orders, values, n), values, n);
}

/* Steps ----------------------------------------------------------------------------------------------------- */

typedef struct {
    uint8_t failed;
    union {
        struct {
            double last_successful_time;
            uint8_t event_handling_needed, terminate, early_return;
        } step;
        uint8_t status;
    } is;
} StepResult;

EXPORT const StepResult *component_do_step(Instance *s, double time, double step, int no_return)
{
    static StepResult result;
    fmi3Boolean event, terminate, early;
    double last;
    const fmi3Status status = fmi3DoStep(s, time, step, no_return != 0, &event, &terminate, &early, &last);
    result.failed = failed(status);
    if (result.failed) {
        result.is.status = status;
        return &result;
    }
    result.is.step.last_successful_time = last;
    result.is.step.event_handling_needed = event, result.is.step.terminate = terminate, result.is.step.early_return = early;
    return &result;
}

EXPORT fmi3Status component_set_time(Instance *s, double time) { return fmi3SetTime(s, time); }

EXPORT fmi3Status component_set_continuous_states(Instance *s, const double *states, size_t n) { return fmi3SetContinuousStates(s, states, n); }

#define OF_EVERY_STATE(name, function)                                   \
    EXPORT const ListResult *component_##name(Instance *s)               \
    {                                                                    \
        double *values = allocate(model.n_states * sizeof *values);      \
        return list_result(function(s, values, model.n_states), values, model.n_states); \
    }

OF_EVERY_STATE(get_continuous_states, fmi3GetContinuousStates)
OF_EVERY_STATE(get_continuous_state_derivatives, fmi3GetContinuousStateDerivatives)
OF_EVERY_STATE(get_nominals_of_continuous_states, fmi3GetNominalsOfContinuousStates)

EXPORT const ListResult *component_get_event_indicators(Instance *s) { return list_result(fmi3GetEventIndicators(s, NULL, 0), NULL, 0); }

EXPORT const NumberResult *component_get_number_of_event_indicators(Instance *s)
{
    size_t n = 0;
    const fmi3Status status = fmi3GetNumberOfEventIndicators(s, &n);
    return number_result(status, n);
}

EXPORT const NumberResult *component_get_number_of_continuous_states(Instance *s)
{
    size_t n = 0;
    const fmi3Status status = fmi3GetNumberOfContinuousStates(s, &n);
    return number_result(status, n);
}

typedef struct {
    uint8_t failed, enter_event_mode_or_status, terminate;
} CompletedResult;

EXPORT const CompletedResult *component_completed_integrator_step(Instance *s, int no_return)
{
    static CompletedResult result;
    fmi3Boolean event, terminate;
    const fmi3Status status = fmi3CompletedIntegratorStep(s, no_return != 0, &event, &terminate);
    if (failed(status)) result = (CompletedResult){1, status, 0};
    else result = (CompletedResult){0, event, terminate};
    return &result;
}
