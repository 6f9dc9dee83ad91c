"""The gap workflow on recorded runs of a vehicle of which only some states are measured: by prediction from sample to sample."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from fmus.effects import Effect
from fmus.errors import InputError
from identification.gap.data.predicted import PredictedRun, prepare_predicted
from identification.gap.data.told import is_rough
from identification.gap.models.predictor import PredictorModel
from identification.gap.naming.decide import Verdict, decide
from identification.gap.naming.fitting import Fit, fit
from identification.gap.stands.linear_stand import LinearStand
from identification.recordings import Recording

ROUNDS = 3  # of verdict and disturbances, each beside the other


def predicted_runs(recordings: Sequence[Recording], stand: LinearStand) -> list[PredictedRun]:
    """The recordings with what they have in common: outputs of the vehicle, and inputs besides the speed."""
    prefix = f"{stand.part}." if stand.part else ""
    shared = [n for n in recordings[0].columns if all(n in r.columns for r in recordings)]
    component = stand.component
    outputs = tuple(n.removeprefix(prefix) for n in component.outputs if n.removeprefix(prefix) in shared)
    inputs = tuple(n.removeprefix(prefix) for n in component.inputs if n.removeprefix(prefix) in shared and n != stand.over)
    over = stand.over.removeprefix(prefix)
    for r in recordings:
        if over not in r.columns:
            raise InputError(f"{r.name}: no {over} [m/s]; a vehicle's run needs it (columns: {', '.join(r.columns)}); name a column with --map COLUMN={over}")
    if not outputs:
        raise InputError(f"{recordings[0].name}: no column is an output of {component.name} (its outputs: "
                         f"{', '.join(n.removeprefix(prefix) for n in component.outputs)}; columns: {', '.join(shared)}); name columns with --map COLUMN=VARIABLE")  # fmt: skip
    return [prepare_predicted(r, over, outputs, tuple(n for n in inputs if np.ptp(r[n]) > 0)) for r in recordings]


def verdict_on_predictions(stand: LinearStand, runs: Sequence[PredictedRun], held: Sequence[PredictedRun], library: Sequence[type[Effect]]) -> tuple[Verdict, list[PredictedRun]]:
    """The verdict, and the held-out runs with their disturbances.

    Disturbances and noises are found beside the base, and again beside what is found, until the verdict stands.
    """
    model = PredictorModel(stand)
    found = _base(model, runs)
    best: Fit = found
    verdict = None
    for _ in range(ROUNDS):
        ready = [best.model.with_disturbances_beside(r, best.shared) for r in best.runs]
        checked = [best.model.with_disturbances_beside(r, best.shared) for r in held]
        before, verdict = verdict, decide(model, ready, library, checked)
        best = verdict.best
        if before is not None and [e.family for e in before.effects] == [e.family for e in verdict.effects]:
            break
    return verdict, checked


def _base(model: PredictorModel, runs: Sequence[PredictedRun]) -> Fit:
    """The base fitted, inputs joined between their samples in the way that leaves less."""
    rough = any(is_rough(r.recording[n]) for r in runs for n in r.inputs)
    fits = []
    for way in (False, True) if rough else (False,):
        ready = [model.with_disturbances_beside(replace(r, held=way), model.start()) for r in runs]
        fits.append(fit(model, ready, model.start()))
    return min(fits, key=lambda f: f.chi2)
