/* FMI 3.0, co-simulation and model exchange: steps with moving inputs, and derivatives for the importer's solver.

   FMI 3.0 has no setter for the derivatives of inputs. Instead the importer sets the inputs in intermediate updates:
   it is asked for them at 0, 1/3, 2/3 and 1 of the step, and they follow the cubic through these four values.
   Inputs that are polynomials up to order 3 are thereby represented exactly. */

#include <string.h>

#include "fmi3_host.h"
#include "step.h"

enum { NODES = 4 };

/* Calls the importer once; if it requests early return and is allowed to, *end becomes that time. */
static void update(Instance *s, double time, int set, int finished, double *end, int *early)
{
    const Host *host = s->host;
    fmi3Boolean requested = fmi3False;
    fmi3Float64 wanted = time;
    const Phase before = phase(s);
    enter(s, INTERMEDIATE);
    host->intermediate_update(host->environment, time, set, !set, finished, host->early_return && !finished, &requested, &wanted);
    if (phase(s) == INTERMEDIATE) enter(s, before); /* else a call within the update has failed */
    if (host->early_return && !finished && requested && wanted >= time && wanted < *end) {
        *end = wanted;
        *early = 1;
    }
}

/* Derivatives of the cubic through values at 0, h/3, 2h/3 and h. */
static void cubic_slopes(const double v[NODES], double h, double slopes[3])
{
    const double first = v[1] - v[0], second = v[2] - 2 * v[1] + v[0], third = v[3] - 3 * v[2] + 3 * v[1] - v[0], third_of_h = h / 3;
    slopes[0] = (first - second / 2 + third / 3) / third_of_h;
    slopes[1] = (second - third) / (third_of_h * third_of_h);
    slopes[2] = third / (third_of_h * third_of_h * third_of_h);
}

/* Obtains the inputs over a step from the importer and stores their values and slopes at its start. */
static void sample_inputs(Instance *s, double time, double h, double *end, int *early)
{
    const unsigned n = model.n_inputs;
    double *nodes = s->work, *u = s->z + model.first_input;
    for (unsigned node = 0; node < NODES; node++) {
        update(s, time + node * h / (NODES - 1), 1, 0, end, early);
        memcpy(nodes + node * n, u, n * sizeof *u);
    }
    for (unsigned i = 0; i < n; i++) {
        const double v[NODES] = {nodes[i], nodes[n + i], nodes[2 * n + i], nodes[3 * n + i]};
        double slopes[3];
        cubic_slopes(v, h, slopes);
        for (unsigned k = 0; k < MAX_ORDER; k++) s->slopes[k * n + i] = slopes[k];
        u[i] = v[0];
    }
    s->kept[SLOPES] = SLOPES_FOR_NEXT_STEP;
    values_changed(s, 0);
}

fmi3Status fmi3DoStep(fmi3Instance instance, fmi3Float64 currentCommunicationPoint, fmi3Float64 communicationStepSize, fmi3Boolean noSetFMUStatePriorToCurrentPoint,
                      fmi3Boolean *eventHandlingNeeded, fmi3Boolean *terminateSimulation, fmi3Boolean *earlyReturn, fmi3Float64 *lastSuccessfulTime)
{
    Instance *s = called(instance, "fmi3DoStep", STEPPING, eventHandlingNeeded && terminateSimulation && earlyReturn && lastSuccessfulTime);
    (void)noSetFMUStatePriorToCurrentPoint;
    if (!s) return fmi3Error;
    const double time = currentCommunicationPoint, h = communicationStepSize;
    const Host *host = s->host;
    double end = time + h;
    int early = 0;
    *eventHandlingNeeded = *terminateSimulation = *earlyReturn = fmi3False;
    *lastSuccessfulTime = s->z[0];
    if (check_step(s, time, h) != OK) return fmi3Error;
    if (host->intermediate_update && model.n_inputs > 0) sample_inputs(s, time, h, &end, &early);
    if (phase(s) == FAILED) return fmi3Error;
    if (end > time) {
        const Status status = step_from(s, time, early ? end - time : h);
        if (status != OK) return as_fmi3(status);
    }
    if (host->intermediate_update) update(s, s->z[0], 0, 1, &end, &early);
    if (phase(s) == FAILED) return fmi3Error;
    *earlyReturn = early != 0;
    *lastSuccessfulTime = s->z[0];
    return fmi3OK;
}

fmi3Status fmi3EnterStepMode(fmi3Instance instance)
{
    Instance *s = called(instance, "fmi3EnterStepMode", STEPPING, 1);
    return s ? as_fmi3(report(s, ERROR, "fmi3EnterStepMode: there is no event mode to leave")) : fmi3Error;
}

fmi3Status fmi3GetOutputDerivatives(fmi3Instance instance, const fmi3ValueReference vr[], size_t nvr, const fmi3Int32 orders[], fmi3Float64 values[], size_t nValues)
{
    Instance *s = called(instance, "fmi3GetOutputDerivatives", STEPPING | TERMINATED | FAILED, nvr == 0 || (vr && orders && values));
    if (!s) return fmi3Error;
    if (nvr != nValues) return as_fmi3(report(s, ERROR, "fmi3GetOutputDerivatives: as many values as references are needed"));
    return as_fmi3(get_slopes(s, vr, nvr, orders, values));
}

/* Model exchange ------------------------------------------------------------------------------------------- */

static Instance *exchange(fmi3Instance instance, const char *function, unsigned allowed, int pointers)
{
    Instance *s = called(instance, function, allowed, pointers);
    if (!s || ((const Host *)s->host)->exchange) return s;
    report(s, ERROR, "%s belongs to model exchange, this instance is one of co-simulation", function);
    return NULL;
}

fmi3Status fmi3EnterEventMode(fmi3Instance instance) { return as_fmi3(change_phase(instance, "fmi3EnterEventMode", EVENT | CONTINUOUS, EVENT)); }

fmi3Status fmi3EnterContinuousTimeMode(fmi3Instance instance) { return as_fmi3(change_phase(instance, "fmi3EnterContinuousTimeMode", EVENT, CONTINUOUS)); }

fmi3Status fmi3UpdateDiscreteStates(fmi3Instance instance, fmi3Boolean *discreteStatesNeedUpdate, fmi3Boolean *terminateSimulation, fmi3Boolean *nominalsOfContinuousStatesChanged,
                                    fmi3Boolean *valuesOfContinuousStatesChanged, fmi3Boolean *nextEventTimeDefined, fmi3Float64 *nextEventTime)
{
    const int pointers = discreteStatesNeedUpdate && terminateSimulation && nominalsOfContinuousStatesChanged && valuesOfContinuousStatesChanged && nextEventTimeDefined && nextEventTime;
    Instance *s = called(instance, "fmi3UpdateDiscreteStates", EVENT, pointers);
    if (!s) return fmi3Error;
    *discreteStatesNeedUpdate = *terminateSimulation = *nominalsOfContinuousStatesChanged = fmi3False;
    *valuesOfContinuousStatesChanged = *nextEventTimeDefined = fmi3False;
    *nextEventTime = 0;
    return fmi3OK;
}

fmi3Status fmi3CompletedIntegratorStep(fmi3Instance instance, fmi3Boolean noSetFMUStatePriorToCurrentPoint, fmi3Boolean *enterEventMode, fmi3Boolean *terminateSimulation)
{
    Instance *s = called(instance, "fmi3CompletedIntegratorStep", CONTINUOUS, enterEventMode && terminateSimulation);
    (void)noSetFMUStatePriorToCurrentPoint;
    if (!s) return fmi3Error;
    *enterEventMode = *terminateSimulation = fmi3False;
    return fmi3OK;
}

fmi3Status fmi3SetTime(fmi3Instance instance, fmi3Float64 time)
{
    Instance *s = called(instance, "fmi3SetTime", EVENT | CONTINUOUS, 1);
    return s ? as_fmi3(set_time(s, time)) : fmi3Error;
}

fmi3Status fmi3SetContinuousStates(fmi3Instance instance, const fmi3Float64 states[], size_t n)
{
    Instance *s = called(instance, "fmi3SetContinuousStates", EVENT | CONTINUOUS, n == 0 || states);
    return s ? as_fmi3(set_states(s, states, n)) : fmi3Error;
}

fmi3Status fmi3GetContinuousStates(fmi3Instance instance, fmi3Float64 states[], size_t n)
{
    Instance *s = exchange(instance, "fmi3GetContinuousStates", EVALUABLE, n == 0 || states);
    return s ? as_fmi3(get_block(s, model.first_state, n, states)) : fmi3Error;
}

fmi3Status fmi3GetContinuousStateDerivatives(fmi3Instance instance, fmi3Float64 derivatives[], size_t n)
{
    Instance *s = exchange(instance, "fmi3GetContinuousStateDerivatives", EVALUABLE, n == 0 || derivatives);
    return s ? as_fmi3(get_block(s, model.first_derivative, n, derivatives)) : fmi3Error;
}

fmi3Status fmi3GetNominalsOfContinuousStates(fmi3Instance instance, fmi3Float64 nominals[], size_t n)
{
    Instance *s = called(instance, "fmi3GetNominalsOfContinuousStates", ANY, n == 0 || nominals);
    return s ? as_fmi3(get_nominals(s, n, nominals)) : fmi3Error;
}

fmi3Status fmi3GetNumberOfContinuousStates(fmi3Instance instance, size_t *n)
{
    Instance *s = called(instance, "fmi3GetNumberOfContinuousStates", ANY, n != NULL);
    if (!s) return fmi3Error;
    *n = model.n_states;
    return fmi3OK;
}

fmi3Status fmi3GetNumberOfEventIndicators(fmi3Instance instance, size_t *n)
{
    Instance *s = called(instance, "fmi3GetNumberOfEventIndicators", ANY, n != NULL);
    if (!s) return fmi3Error;
    *n = 0;
    return fmi3OK;
}

fmi3Status fmi3GetEventIndicators(fmi3Instance instance, fmi3Float64 eventIndicators[], size_t n)
{
    Instance *s = called(instance, "fmi3GetEventIndicators", EVALUABLE, 1);
    (void)eventIndicators;
    if (!s) return fmi3Error;
    return n == 0 ? fmi3OK : as_fmi3(report(s, ERROR, "the model has no event indicators"));
}
