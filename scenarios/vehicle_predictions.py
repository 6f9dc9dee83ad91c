"""The gap workflow on recorded runs of a vehicle of which only some states are measured: by prediction from sample to sample."""

from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import Any

import numpy as np
from matplotlib.figure import Figure

from fmus.component import Component
from fmus.effects import Effect
from fmus.errors import InputError
from identification.gap.data.predicted import BAND, BLOCK, PredictedRun, prepare_predicted
from identification.gap.data.told import is_rough
from identification.gap.models.predictor import PredictorModel
from identification.gap.naming.decide import Verdict, decide
from identification.gap.naming.fitting import Fit, fit
from identification.gap.stands.linear_stand import LinearStand
from identification.gap.stands.test_stand import Free
from identification.recordings import Recording
from scenarios.report import COLOURS, new_figure
from scenarios.vehicle_test import NOT_LINEAR, uncertain, vehicle_effects
from vehicle_fmu import ridden

ROUNDS = 3  # of verdict and disturbances, each beside the other
RIDER = 0.2  # to which the parameters of whoever holds the handlebar are known
DIFFERS = 0.3  # from run to run, of what is not known of a parameter
FEIGNED = 0.03  # of the noise's power, gained by a linear effect: small errors of the base and of the disturbances' spectra do that
BESIDE = 0.1  # of a larger effect's gain


def ridden_stand(vehicle: Component, device: Component, free: Sequence[str] = ()) -> LinearStand:
    """The vehicle with a device at its handlebar whose torque nobody records; both fitted within what is known of them."""
    held = tuple(Free(f"device.{n}", 0.0, x, RIDER * x) for n, x in device.values.items() if x > 0 and device.table[n].tunable)
    return LinearStand(ridden(vehicle, device), "vehicle", "vehicle.speed", (*uncertain(vehicle, free), *held), exact_delays=True)


def differing(stand: LinearStand) -> LinearStand:
    """The stand whose known parameters differ from run to run: tyres warm up, tanks empty, riders sit otherwise."""
    return replace(stand, free=tuple(replace(f, spread=DIFFERS * f.standard_error / f.known) if f.known else f for f in stand.free))


def predicted_runs(recordings: Sequence[Recording], stand: LinearStand) -> list[PredictedRun]:
    """The recordings with the outputs and inputs of the vehicle that all of them have. Raises InputError without the speed, or any output."""
    component, prefix = stand.component, f"{stand.part}." if stand.part else ""
    own = [n.removeprefix(prefix) for n in component.outputs if n.startswith(prefix)]
    inputs = [n.removeprefix(prefix) for n in component.inputs if n.startswith(prefix) and n != stand.over]
    over = stand.over.removeprefix(prefix)
    for r in recordings:
        if over not in r.columns:
            raise InputError(f"{r.name}: no {over} [m/s], which a vehicle's run needs; columns: {', '.join(r.columns)}; name one with --map COLUMN={over}")
    shared = [n for n in recordings[0].columns if all(n in r.columns for r in recordings)]
    outputs = tuple(n for n in own if n in shared)
    if not outputs:
        raise InputError(f"{recordings[0].name}: no column is an output of {component.name} ({', '.join(own)}); "
                         f"columns of all runs: {', '.join(shared)}; name them with --map COLUMN=VARIABLE")  # fmt: skip
    return [prepare_predicted(r, over, outputs, tuple(n for n in inputs if n in shared and np.ptp(r[n]) > 0)) for r in recordings]


def predictable_effects(vehicle: Component, stand: LinearStand, folder: str | None = None) -> list[type[Effect]]:
    """The library; without what makes a recorded input lag where a device is between."""
    return [e for e in vehicle_effects(vehicle, folder) if not (stand.part and e.delayed)]


def verdict_on_predictions(stand: LinearStand, runs: Sequence[PredictedRun], held: Sequence[PredictedRun],
                           library: Sequence[type[Effect]], so_far: Callable[[Verdict], None] = lambda verdict: None) -> tuple[Verdict, list[PredictedRun]]:  # fmt: skip
    """The verdict, and the held-out runs with their disturbances.

    Disturbances and noises are found beside the base, and again beside what is found, until the verdict stands. A linear
    effect that makes up for less than FEIGNED of the noise is not named.
    """
    model = PredictorModel(differing(stand))
    best = _base(model, runs)
    held = [replace(r, held=best.runs[0].held) for r in held]
    before: list[str] | None = None
    for _ in range(ROUNDS):
        beside: Any = best.model
        ready, held = ([beside.with_disturbances_beside(r, best.shared) for r in each] for each in (best.runs, held))
        verdict, held = _decided(model, ready, library, held, so_far)
        while doubtful := _doubtful(verdict):
            library = [e for e in library if e.family not in doubtful]
            verdict, held = _decided(model, ready, library, held, so_far)
        best, names = verdict.best, [e.family for e in verdict.effects]
        if names == before:
            break
        before = names
    return verdict, list(held)


def _decided(model: PredictorModel, runs: Sequence[PredictedRun], library: Sequence[type[Effect]], held: Sequence[PredictedRun],
             so_far: Callable[[Verdict], None]) -> tuple[Verdict, Sequence[PredictedRun]]:  # fmt: skip
    """The verdict, without held-out runs where a vehicle that fits the others cannot be predicted in them."""
    try:
        return decide(model, runs, library, held, so_far), held
    except InputError:
        if not held:
            raise
        return decide(model, runs, library, (), so_far), ()


def _doubtful(verdict: Verdict) -> set[str]:
    """Families of which the verdict speaks and that gain too little: beside a large effect small errors of its form look like others."""
    least = FEIGNED * verdict.base.count if verdict.base.reduced > 1 else np.inf  # nothing is better than the best prediction
    beside = max([least, *(BESIDE * c.delta_chi2 for c in verdict.effects)])
    linear = [c for c in (*verdict.effects, *verdict.tied) if c.family not in NOT_LINEAR]
    return {c.family for c in linear if c.delta_chi2 < (beside if len(verdict.effects) > 1 else least)}


def _base(model: PredictorModel, runs: Sequence[PredictedRun]) -> Fit:
    """The base fitted, inputs joined between their samples in the way that leaves less."""
    rough = any(is_rough(r.recording[n]) for r in runs for n in r.inputs)
    fits = []
    for way in (False, True) if rough else (False,):
        ready = [model.with_disturbances_beside(replace(r, held=way), model.start()) for r in runs]
        fits.append(fit(model, ready, model.start()))
    return min(fits, key=lambda f: f.chi2)


def limitations(runs: Sequence[PredictedRun]) -> list[str]:
    """What a verdict by prediction rests on."""
    sentences = [f"Not all states of the vehicle are recorded: it is predicted from sample to sample, and the errors are compared from {BAND[0]:g} to "
                 f"{BAND[1]:g} Hz in blocks of {BLOCK:g} s. 1 means as good as a long regression on everything recorded before.",
                 "Whatever drives the vehicle unrecorded is taken as a roll torque, a side force and a torque about the steer axis, each in part white and in part slow; "
                 f"linear effects that gain less than {FEIGNED:g} of the noise's power, or {BESIDE:g} of a larger effect's gain, are not named."]  # fmt: skip
    if not any(r.inputs for r in runs):
        sentences.append("No input is recorded: disturbances alone move the vehicle, and only its modes show.")
    return sentences


def spectra(verdict: Verdict) -> Figure:
    """What was measured and what each fit mispredicts over frequency, one panel per output; first run."""
    run: PredictedRun = verdict.best.runs[0]
    figure, axes = new_figure(columns=len(run.outputs), width=4.0 + 3.0 * len(run.outputs), sharex=True, squeeze=False)
    shape = (len(run.outputs), len(run.blocks), len(run.frequency))
    floor = np.stack([np.sqrt(d(run.frequency)) for d in run.densities])
    assert run.mixing is not None
    measured = np.sqrt(np.mean(np.einsum("ij,jbk->ibk", np.linalg.inv(run.mixing), run.cosines(run.measured)) ** 2, axis=1))
    own = np.linalg.inv(run.mixing)
    lines: list[tuple[Any, str, str]] = [(verdict.base, COLOURS["damper"], "base, refitted"), (verdict.best, COLOURS["rider"], "with what was found")]
    for i, (name, ax) in enumerate(zip(run.outputs, axes.flat, strict=True)):
        ax.semilogy(run.frequency, measured[i], color=COLOURS["reference"], label="measured")
        for each, colour, label in lines:
            left = each.residuals[: int(np.prod(shape))].reshape(shape) * floor[:, None]
            ax.semilogy(run.frequency, np.sqrt(np.mean(np.einsum("ij,jbk->ibk", own, left)[i] ** 2, axis=0)), color=colour, label=label, linewidth=0.9)
        ax.semilogy(run.frequency, np.sqrt((own[i] ** 2) @ floor**2), "k--", linewidth=0.8, label="best prediction")
        ax.set(xlabel="frequency [Hz]", ylabel=f"{name.replace('_', ' ')} [{run.recording.units[name]}]")
    axes.flat[0].legend()
    return figure
