"""Model exchange: as many states, derivatives, nominals and event indicators as the description says, with the values
of the variables that it names for them."""

from collections.abc import Iterator

import numpy as np

from fmus.checks.calls import CallFailedError
from fmus.checks.problem import Problem
from fmus.checks.simulation import values
from fmus.checks.trial import Trial

PLACE, SEVERITY = 1, "error"


def applies(trial: Trial) -> bool:
    return trial.kind == "ModelExchange"


def run(trial: Trial) -> Iterator[Problem]:
    fmu, model = trial.initialised(), trial.model
    if model.version == "3":
        for name, expected, what in (
            ("GetNumberOfContinuousStates", fmu.order, "continuous states"),
            ("GetNumberOfEventIndicators", model.event_indicators, "event indicators"),
        ):
            count = fmu.ffi.new("size_t *")
            fmu.call(name, count)
            if count[0] != expected:
                yield trial.error(f"the binary has {count[0]} {what}, the description {expected}", fmu.last)
                return
    fmu.indicators()
    states = fmu.states()
    yield from _same(trial, "state", fmu.states(), values(fmu, model.states))
    rates = fmu.rates()
    yield from _same(
        trial, "derivative", rates, values(fmu, [u.variable for u in model.derivatives if u.variable is not None])
    )
    nominals = fmu.nominals()
    if (bad := ~(np.isfinite(nominals) & (nominals > 0))).any():
        yield trial.error(
            f"the nominal of continuous state {int(np.argmax(bad)) + 1} is {nominals[bad][0]:g}, it has to be positive",
            fmu.last,
        )
    states = states + 1e-3 * nominals
    try:
        fmu.set_states(states)
    except CallFailedError as failed:
        if failed.call.status.endswith("Discard"):
            return
        raise
    if not np.array_equal(fmu.states(), states):
        yield trial.error(
            "continuous states differ from those that were set", fmu.last, trial.section("3.2.1", "3.2.1")
        )


def _same(trial: Trial, what: str, vector: np.ndarray, variables: np.ndarray) -> Iterator[Problem]:
    if (
        len(vector) == len(variables)
        and (unequal := ~(np.isclose(vector, variables, rtol=1e-9, atol=0) | np.isnan(vector))).any()
    ):
        k = int(np.argmax(unequal))
        yield trial.error(
            f"{what} {k + 1} of the vector is {vector[k]:.9g}, its variable {variables[k]:.9g}",
            trial.instances[-1].last,
            trial.section("2.2.8", "2.4.8"),
        )
