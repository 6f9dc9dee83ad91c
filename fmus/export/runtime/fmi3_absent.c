/* FMI 3.0: functions for features that the model does not have. All its variables are scalars of type Float64; it has no
   clocks, no structural parameters, no event mode in co-simulation and no dependencies by element. */

#include "fmi3_host.h"

/* OK where nothing is requested, else an error: the model has no such variables. */
static fmi3Status absent(fmi3Instance instance, const char *function, size_t n)
{
    Instance *s = called(instance, function, ANY, 1);
    if (!s) return fmi3Error;
    return n == 0 ? fmi3OK : as_fmi3(report(s, ERROR, "%s: the model has nothing of this kind, all its variables are of type Float64", function));
}

#define NO_VARIABLES_OF(Type)                                                                                                          \
    fmi3Status fmi3Get##Type(fmi3Instance instance, const fmi3ValueReference vr[], size_t n, fmi3##Type values[], size_t n_values)     \
    {                                                                                                                                  \
        (void)vr, (void)values, (void)n_values;                                                                                        \
        return absent(instance, "fmi3Get" #Type, n);                                                                                   \
    }                                                                                                                                  \
    fmi3Status fmi3Set##Type(fmi3Instance instance, const fmi3ValueReference vr[], size_t n, const fmi3##Type values[], size_t n_values) \
    {                                                                                                                                  \
        (void)vr, (void)values, (void)n_values;                                                                                        \
        return absent(instance, "fmi3Set" #Type, n);                                                                                   \
    }

NO_VARIABLES_OF(Float32)
NO_VARIABLES_OF(Int8)
NO_VARIABLES_OF(UInt8)
NO_VARIABLES_OF(Int16)
NO_VARIABLES_OF(UInt16)
NO_VARIABLES_OF(Int32)
NO_VARIABLES_OF(UInt32)
NO_VARIABLES_OF(Int64)
NO_VARIABLES_OF(UInt64)
NO_VARIABLES_OF(Boolean)
NO_VARIABLES_OF(String)

/* Functions of an instance, value references, their number, and arrays that are not used. */
#define NO_CLOCKS(name, ...)                                                                                           \
    fmi3Status name(fmi3Instance instance, const fmi3ValueReference vr[], size_t n, __VA_ARGS__)

NO_CLOCKS(fmi3GetBinary, size_t sizes[], fmi3Binary values[], size_t n_values)
{
    (void)vr, (void)sizes, (void)values, (void)n_values;
    return absent(instance, "fmi3GetBinary", n);
}

NO_CLOCKS(fmi3SetBinary, const size_t sizes[], const fmi3Binary values[], size_t n_values)
{
    (void)vr, (void)sizes, (void)values, (void)n_values;
    return absent(instance, "fmi3SetBinary", n);
}

NO_CLOCKS(fmi3GetClock, fmi3Clock values[])
{
    (void)vr, (void)values;
    return absent(instance, "fmi3GetClock", n);
}

NO_CLOCKS(fmi3SetClock, const fmi3Clock values[])
{
    (void)vr, (void)values;
    return absent(instance, "fmi3SetClock", n);
}

NO_CLOCKS(fmi3GetIntervalDecimal, fmi3Float64 intervals[], fmi3IntervalQualifier qualifiers[])
{
    (void)vr, (void)intervals, (void)qualifiers;
    return absent(instance, "fmi3GetIntervalDecimal", n);
}

NO_CLOCKS(fmi3GetIntervalFraction, fmi3UInt64 counters[], fmi3UInt64 resolutions[], fmi3IntervalQualifier qualifiers[])
{
    (void)vr, (void)counters, (void)resolutions, (void)qualifiers;
    return absent(instance, "fmi3GetIntervalFraction", n);
}

NO_CLOCKS(fmi3GetShiftDecimal, fmi3Float64 shifts[])
{
    (void)vr, (void)shifts;
    return absent(instance, "fmi3GetShiftDecimal", n);
}

NO_CLOCKS(fmi3GetShiftFraction, fmi3UInt64 counters[], fmi3UInt64 resolutions[])
{
    (void)vr, (void)counters, (void)resolutions;
    return absent(instance, "fmi3GetShiftFraction", n);
}

NO_CLOCKS(fmi3SetIntervalDecimal, const fmi3Float64 intervals[])
{
    (void)vr, (void)intervals;
    return absent(instance, "fmi3SetIntervalDecimal", n);
}

NO_CLOCKS(fmi3SetIntervalFraction, const fmi3UInt64 counters[], const fmi3UInt64 resolutions[])
{
    (void)vr, (void)counters, (void)resolutions;
    return absent(instance, "fmi3SetIntervalFraction", n);
}

NO_CLOCKS(fmi3SetShiftDecimal, const fmi3Float64 shifts[])
{
    (void)vr, (void)shifts;
    return absent(instance, "fmi3SetShiftDecimal", n);
}

NO_CLOCKS(fmi3SetShiftFraction, const fmi3UInt64 counters[], const fmi3UInt64 resolutions[])
{
    (void)vr, (void)counters, (void)resolutions;
    return absent(instance, "fmi3SetShiftFraction", n);
}

fmi3Status fmi3GetNumberOfVariableDependencies(fmi3Instance instance, fmi3ValueReference reference, size_t *n)
{
    (void)reference, (void)n;
    return absent(instance, "fmi3GetNumberOfVariableDependencies", 1);
}

fmi3Status fmi3GetVariableDependencies(fmi3Instance instance, fmi3ValueReference dependent, size_t elements_of_dependent[], fmi3ValueReference independents[],
                                       size_t elements_of_independents[], fmi3DependencyKind kinds[], size_t n)
{
    (void)dependent, (void)elements_of_dependent, (void)independents, (void)elements_of_independents, (void)kinds, (void)n;
    return absent(instance, "fmi3GetVariableDependencies", 1);
}

fmi3Status fmi3EnterConfigurationMode(fmi3Instance instance) { return absent(instance, "fmi3EnterConfigurationMode", 1); }

fmi3Status fmi3ExitConfigurationMode(fmi3Instance instance) { return absent(instance, "fmi3ExitConfigurationMode", 1); }

fmi3Status fmi3EvaluateDiscreteStates(fmi3Instance instance) { return absent(instance, "fmi3EvaluateDiscreteStates", 1); }

fmi3Status fmi3ActivateModelPartition(fmi3Instance instance, fmi3ValueReference clock, fmi3Float64 time)
{
    (void)clock, (void)time;
    return absent(instance, "fmi3ActivateModelPartition", 1);
}
