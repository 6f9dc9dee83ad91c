"""The gap workflow on recorded runs of a vehicle of which only some states are measured: by prediction from sample to sample."""

from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import Any

import numpy as np
from matplotlib.figure import Figure

from fmus.component import Component
from fmus.effects import Effect
from fmus.errors import InputError
from identification.gap.data.predicted import BLOCK, LOWEST, PredictedRun, prepare_predicted
from identification.gap.models.disturbances import CORNER_SPREAD, FORCES, SPREAD, factors_of
from identification.gap.models.predictor import PredictorModel
from identification.gap.naming.candidate import TIE, one_each
from identification.gap.naming.decide import Verdict, decide
from identification.gap.naming.fitted import Fit
from identification.gap.naming.fitting import fit
from identification.gap.stands.linear_stand import LinearStand
from identification.gap.stands.test_stand import Free
from identification.recordings import Recording
from scenarios.report import COLOURS, new_figure
from scenarios.vehicle_test import NOT_LINEAR, OF_HANDS, uncertain, vehicle_effects
from vehicle_fmu import ridden

RIDER = 0.2  # to which the parameters of whoever holds the handlebar are known
HEAD = "head"  # the element between handlebar and frame
GUSTS = 0.5  # by how much the logarithms of disturbances differ from run to run beyond the first guess of each
DIFFERS = 0.3  # from run to run, of what is not known of a parameter
FEIGNED = 0.005  # of the noise's power, gained by each parameter of a linear effect: small errors of the base and of the disturbances' spectra do that
FEIGNED_BY_HANDS = 0.03  # the same where nobody records what hands do: their torque is no noise with a smooth spectrum
BESIDE = 0.1  # of a larger effect's gain


def ridden_stand(vehicle: Component, device: Component, free: Sequence[str] = ()) -> LinearStand:
    """The vehicle with a device at its handlebar whose torque nobody records; both fitted within what is known of them."""
    held = tuple(Free(f"device.{n}", 0.0, x, RIDER * x) for n, x in device.values.items() if x > 0 and device.table[n].tunable)
    return LinearStand(ridden(vehicle, device), "vehicle", "vehicle.speed", (*uncertain(vehicle, free), *held), exact_delays=True)


def differing(stand: LinearStand) -> LinearStand:
    """The stand whose known parameters differ from run to run: tyres warm up, tanks empty, riders sit otherwise."""
    return replace(stand, free=tuple(replace(f, spread=DIFFERS * f.standard_error / f.known) if f.known else f for f in stand.free))


def with_disturbances(stand: LinearStand, outputs: Sequence[str]) -> LinearStand:
    """The stand with what is not known of disturbances and of the noise of outputs as free parameters: factors of a first guess."""
    prefix = f"{stand.part}." if stand.part else ""
    factors = factors_of([n for n in FORCES if prefix + n in stand.component.inputs], outputs)
    free = tuple(Free(stand.parameter(factors, n), GUSTS, 1.0, CORNER_SPREAD if n.startswith("corner") else SPREAD) for n in factors.sought())
    return replace(stand, component=stand.with_effects([factors]), free=(*stand.free, *free))


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


def predictable_effects(vehicle: Component, stand: LinearStand, runs: Sequence[PredictedRun], folder: str | None = None) -> list[type[Effect]]:
    """The library, without delays of what is not recorded, and without what nobody could tell from hands.

    Those hold a handlebar without a modelled device; where their torque is not recorded, they are a spring, a damper, an inertia.
    """
    recorded = {*runs[0].outputs, *(() if stand.part else runs[0].inputs)}  # with a device between, nobody knows when an input acts
    every = [e for e in vehicle_effects(vehicle, folder) if all(source in recorded for source, _ in e.delayed.values())]
    if stand.part or torque_is_known(runs):
        return every
    return [e for e in every if e.family not in OF_HANDS and e.element != HEAD]


def verdict_on_predictions(stand: LinearStand, runs: Sequence[PredictedRun], held: Sequence[PredictedRun],
                           library: Sequence[type[Effect]], so_far: Callable[[Verdict], None] = lambda verdict: None) -> Verdict:  # fmt: skip
    """The verdict on runs, each with the disturbances that are in it.

    A first guess of disturbances and noises is found beside the base. A linear effect that makes up for less than FEIGNED of
    the noise is not named.
    """
    model = PredictorModel(with_disturbances(differing(stand), runs[0].outputs))
    base = _base(model, runs)
    held = [replace(r, held=base.runs[0].held) for r in held]
    ready = [model.with_disturbances_beside(r, base.of_run(i)) for i, r in enumerate(base.runs)]
    held = [model.with_disturbances_beside(r, base.shared) for r in held]
    verdict = _decided(model, ready, library, held, so_far)
    if doubtful := _doubtful(verdict):
        again = _decided(model, ready, [e for e in library if e.family not in doubtful], held, so_far)
        verdict = replace(again, candidates=again.candidates or verdict.candidates)
    return verdict


def _decided(model: PredictorModel, runs: Sequence[PredictedRun], library: Sequence[type[Effect]], held: Sequence[PredictedRun],
             so_far: Callable[[Verdict], None]) -> Verdict:  # fmt: skip
    """The verdict, without held-out runs where a vehicle that fits the others cannot be predicted in them."""
    second = (feigned(runs) * sum(len(r.data) for r in runs), BESIDE)
    try:
        return decide(model, runs, library, held, so_far, second)
    except InputError:
        if not held:
            raise
        return decide(model, runs, library, (), so_far, second)


def _doubtful(verdict: Verdict) -> set[str]:
    """Families that gain too little to be named, if the verdict speaks of one: small errors of the base look like them.

    Each parameter may feign a share. What is not linear is as doubtful as the linear effect that it is hardly better than.
    """
    least = feigned(verdict.base.runs) * verdict.base.count
    linear = max((c.delta_bic for c in verdict.candidates if c.fitted and c.family not in NOT_LINEAR), default=-np.inf)
    weak = {c.family for c in one_each(verdict.candidates) if c.delta_chi2 < least * len(c.effect.sought()) and (c.family not in NOT_LINEAR or c.delta_bic < linear + TIE)}
    return weak if weak & {c.family for c in (*verdict.effects, *verdict.tied)} else set()


def feigned(runs: Sequence[PredictedRun]) -> float:
    """The share of the noise's power below which nothing linear is named."""
    return FEIGNED if torque_is_known(runs) else FEIGNED_BY_HANDS


def torque_is_known(runs: Sequence[PredictedRun]) -> bool:
    """Whether the steer torque is recorded."""
    return "steer_torque" in runs[0].inputs


def _base(model: PredictorModel, runs: Sequence[PredictedRun]) -> Fit:
    """The base fitted, inputs joined between their samples in the way that leaves less."""
    lines = fit(model, [model.with_disturbances_beside(r, model.start()) for r in runs], model.start())
    if not any(r.inputs for r in runs):
        return lines
    steps = [model.with_disturbances_beside(replace(r, held=True, noise=None), model.start()) for r in lines.runs]
    held = fit(model, steps, model.start())
    if lines.chi2 <= held.chi2:
        return lines
    return replace(held, runs=[replace(r, mixing=None) for r in held.runs])  # what predicts them best knows less


def limitations(stand: LinearStand, runs: Sequence[PredictedRun]) -> list[str]:
    """What a verdict by prediction rests on."""
    sentences = [f"Not all states of the vehicle are recorded: it is predicted from sample to sample, and the errors are compared from {LOWEST:g} Hz on "
                 f"in blocks of {BLOCK:g} s. 1 means as good as a long regression on everything recorded before.",
                 "Whatever drives the vehicle unrecorded is taken as a roll torque, a side force and a torque about the steer axis, each in part white and in part slow; "
                 f"linear effects that gain less than {100 * feigned(runs):g} % of the noise's power for each of their parameters, or {100 * BESIDE:g} % of a larger effect's gain, are not named."]  # fmt: skip
    if not any(r.inputs for r in runs):
        sentences.append("No input is recorded: disturbances alone move the vehicle, and only its modes show.")
    if not stand.part and not torque_is_known(runs):
        sentences.append("The steer torque is not recorded: what hands on a handlebar do as well is not looked for (friction, springs, dampers and inertia there).")
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
        ax.loglog(run.frequency, measured[i], color=COLOURS["reference"], label="measured")
        for each, colour, label in lines:
            left = each.residuals[: int(np.prod(shape))].reshape(shape) * floor[:, None]
            ax.loglog(run.frequency, np.sqrt(np.mean(np.einsum("ij,jbk->ibk", own, left)[i] ** 2, axis=0)), color=colour, label=label, linewidth=0.9)
        ax.loglog(run.frequency, np.sqrt((own[i] ** 2) @ floor**2), "k--", linewidth=0.8, label="best prediction")
        ax.set(xlabel="frequency [Hz]", ylabel=f"{name.replace('_', ' ')} [{run.recording.units[name]}]")
    axes.flat[0].legend()
    return figure
