"""What other ways of naming say of the same blind cases: sparse regression, matching pursuit, AIC on a frequency response.

Sparse regression and matching pursuit are given more than they usually get: the base is fitted, its residual torque is
taken at every sample, and the terms are the library's own laws on the motion as the base has it. pysindy takes part
where it is installed (`pip install pysindy`). AIC chooses among the library's effects fitted to first harmonics alone.
"""

import tempfile
import warnings
from collections.abc import Callable, Iterable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
from scipy.signal import lsim

from benchmarks.gap_blind import prepared, share_of
from motofmi.gap.estimation.candidate import one_each
from motofmi.gap.estimation.fit_result import Fit
from motofmi.gap.estimation.fitting import fit
from motofmi.gap.estimation.multi_start import fit_base
from motofmi.gap.models.harmonic_model import HarmonicModel
from motofmi.gap.preprocessing.steer_test_run import SteerTestRun
from motofmi.gap.selection.candidate_search import search_candidates
from motofmi.gap.selection.model_selection import select_model
from motofmi.recordings.rig_file import read_rig
from motofmi.workflows.gap.rig import rig_effects, rig_experiment
from tests.simulators.blind_cases import Laboratory, draw

try:
    from pysindy.optimizers import STLSQ
except ImportError:  # an optional rival
    STLSQ = None

# What a term of the regressions is called in the library, as a function of steer angle, rate, deflection, its rate,
# share of time.
TERMS: dict[str, Callable[..., np.ndarray]] = {
    "coulomb_friction": lambda x, s, d, v, t: np.tanh(s / 0.02),
    "hardening_stiffness": lambda x, s, d, v, t: d**3,
    "progressive_damping": lambda x, s, d, v, t: np.abs(v) * v,
    "asymmetry": lambda x, s, d, v, t: np.abs(d),
    "backlash": lambda x, s, d, v, t: np.tanh(d / 1e-3),
    "hysteresis": lambda x, s, d, v, t: np.sign(v) * np.abs(d),
    "drift": lambda x, s, d, v, t: (t - 0.5) * d,
    "channel_delay": lambda x, s, d, v, t: v,
    "steer_stiffness": lambda x, s, d, v, t: x,
    "steer_damping": lambda x, s, d, v, t: s,
}
KINDS = ("none", "single")


def run(progress: Callable[..., Iterable], cases: int = 40, seed: int = 5) -> dict[str, Any]:
    """Per way of naming: alarms where nothing is hidden, and right and wrong names of single effects."""
    verdicts: dict[str, list[tuple[str, str]]] = {}
    for number in progress(range(cases), "rivals"):
        truth = draw(number, seed, KINDS[number % 2])
        with tempfile.TemporaryDirectory() as folder:
            Laboratory(truth, number, seed).deliver(Path(folder))
            said = name(Path(folder))
        for way, answer in said.items():
            verdicts.setdefault(way, []).append((truth.families[0] if truth.families else "none", answer))
    return {"cases": cases, "ways": {way: _rates(rows) for way, rows in verdicts.items()}}


def name(folder: Path) -> dict[str, str]:
    """What every way says of the recordings in a folder: a family, none, tied or unknown; ours first."""
    model = HarmonicModel(rig_experiment(read_rig(folder)))
    runs = prepared([p for p in (folder / "sweep_up.csv", folder / "stepped.csv") if p.exists()], model.experiment)
    library = rig_effects()
    base = fit_base(model, runs)
    verdict = select_model(model, runs, library)
    said = {"motofmi gap": " + ".join(c.family for c in verdict.effects) or verdict.verdict}
    terms, left = regression(base)
    if STLSQ is not None:
        said["pysindy (STLSQ)"] = _largest(terms, _sparsest(terms, left))
    said["matching pursuit"] = pursuit(terms, left)
    said["AIC on first harmonics"] = by_aic(base)
    return said


def regression(base: Fit) -> tuple[np.ndarray, np.ndarray]:
    """Terms (n, k), each of unit rms, and the residual torque (n,) of the base at the samples of all windows."""
    matrices, targets = [], []
    for index, made in enumerate(base.runs):
        run: SteerTestRun = made
        time = run.recording.time
        x, s, _ = run.motion_at(time)
        d = x - _torso(base, index, time, x)
        v = np.gradient(d, time)
        inside = np.concatenate([np.arange(first, last) for first, last, _ in run.reduction.bases])
        share = time / run.duration
        matrices.append(np.column_stack([term(x, s, d, v, share) for term in TERMS.values()])[inside])
        targets.append(
            (run.effort.measured - base.model.outputs(run, base.of_run(index), slopes=False)[0][:, 0])[inside]
        )
    matrix, target = np.concatenate(matrices), np.concatenate(targets)
    return matrix / np.sqrt(np.mean(matrix**2, axis=0)), target - target.mean()


def _torso(base: Fit, index: int, time: np.ndarray, angle: np.ndarray) -> np.ndarray:
    """The torso's angle (n,) as the base has it: I_t theta'' = k_a d + c_a d' - k_t theta - c_t theta',  d = angle - theta."""
    names = ("torso_inertia", "arm_stiffness", "waist_stiffness", "arm_damping", "waist_damping")
    It, ka, kt, ca, ct = (float(np.exp(base.of_run(index)[base.model.base.index(f"device.{n}")])) for n in names)
    return lsim(
        ([ca, ka], [It, ca + ct, ka + kt]), angle, np.arange(len(time)) * (time[-1] - time[0]) / (len(time) - 1)
    )[1]


def _sparsest(terms: np.ndarray, left: np.ndarray) -> np.ndarray:
    """Coefficients (k,) of thresholded least squares, with the threshold of the least BIC."""
    best, found = np.inf, np.zeros(terms.shape[1])
    for threshold in np.geomspace(0.003, 1.0, 12):
        optimizer = STLSQ(threshold=threshold, alpha=1e-6)
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # it warns where a threshold leaves no term
            optimizer.fit(terms, left[:, None])
        coefficients = np.ravel(optimizer.coef_)
        bic = _bic(left - terms @ coefficients, np.count_nonzero(coefficients))
        if bic < best:
            best, found = bic, coefficients
    return found


def pursuit(terms: np.ndarray, left: np.ndarray) -> str:
    """The first term of orthogonal matching pursuit, if the BIC wants any."""
    first = int(np.argmax(np.abs(terms.T @ left)))
    coefficient = terms[:, first] @ left / (terms[:, first] @ terms[:, first])
    gains = _bic(left, 0) - _bic(left - coefficient * terms[:, first], 1)
    return list(TERMS)[first] if gains > 0 else "none"


def _bic(left: np.ndarray, count: int) -> float:
    return len(left) * float(np.log(np.mean(left**2))) + count * float(np.log(len(left)))


def _largest(terms: np.ndarray, coefficients: np.ndarray) -> str:
    shares = np.abs(coefficients)
    return list(TERMS)[int(np.argmax(shares))] if shares.any() else "none"


def by_aic(base: Fit) -> str:
    """The effect with the least AIC where only first harmonics are fitted."""
    blind = 1e6  # times the deviation: what is not seen
    seen = [replace(r, outputs=(replace(r.effort, deviation=np.where([c.order == 1 and c.degree == 0 for c in r.reduction.columns], 1.0, blind) * r.effort.deviation),))
            for r in base.runs]  # fmt: skip
    found = fit(base.model, seen, base.x)
    best = max(
        one_each(search_candidates(found, rig_effects())), key=lambda c: c.delta_chi2 - 2 * len(c.effect.parameters())
    )
    return best.family if best.delta_chi2 > 2 * len(best.effect.parameters()) else "none"


def _rates(rows: list[tuple[str, str]]) -> dict[str, Any]:
    quiet = [answer for truth, answer in rows if truth == "none"]
    hidden = [(truth, answer) for truth, answer in rows if truth != "none"]
    return {
        "false_alarms": share_of([answer != "none" for answer in quiet]),
        "right": share_of([truth == answer for truth, answer in hidden]),
        "wrong": share_of([answer not in (truth, "none", "tied", "unknown") for truth, answer in hidden]),
    }  # fmt: skip
