"""The test that would settle a verdict: which run, and by how much it would tell the rivals apart.

For each kind of run the noise-free outputs of the rivals, each as fitted, are compared: the expected delta-chi-square
is the squared distance of the two over the noise, with what the base could refit taken out.
"""

from collections.abc import Sequence
from typing import Any

import numpy as np

from identification.gap.competing import Candidate
from identification.gap.decide import Verdict
from identification.gap.fitting import Fit

LINEAR = ("cross_inertia", "steer_stiffness", "steer_damping", "added_inertia")
BARE_TIME = 60.0  # s of a bare-bar sweep
TORQUE_NOISE = 0.2  # N.m, where the runs say nothing
SWEEP = np.linspace(0.5, 12.0, 240)  # Hz


def next_experiment(verdict: Verdict) -> dict[str, Any] | None:
    """The run that would settle a tie or strengthen a weak verdict, with the delta-chi-square that it would bring."""
    rivals = verdict.tied if verdict.verdict == "tied" else _weak(verdict)
    if not rivals:
        return None
    proposals = [_bare_bar(verdict, rivals), _again(verdict, rivals, 2.0, "larger amplitude"), _gyro(rivals)]
    known = [p for p in proposals if p is not None]
    return max(known, key=lambda p: p["expected_delta_chi2"] or 0.0) | {"alternatives": known}


def _weak(verdict: Verdict) -> list[Candidate]:
    """The two best where the verdict rests on little."""
    first = verdict.candidates[:2]
    if verdict.verdict == "named" and first and first[0].delta_bic < 40.0:
        return list(verdict.effects) + [c for c in first if c.family != verdict.effects[0].family]
    if verdict.verdict == "unknown":
        return list(first)
    return []


def _own(candidate: Candidate) -> np.ndarray:
    model = candidate.fit.model
    return candidate.fit.x[len(model.base) : len(model.names)] if candidate.effect in model.effects else np.zeros(0)


def _bare_bar(verdict: Verdict, rivals: Sequence[Candidate]) -> dict[str, Any] | None:
    """Hands off, the bar alone moves: only what sits at the bar itself is left in the torque."""
    if not any(c.family in LINEAR for c in rivals):
        return None
    w = 2 * np.pi * SWEEP
    signals = {}
    for c in rivals:
        size = float(_own(c)[0]) if len(_own(c)) else 0.0
        signals[c.family] = {"steer_stiffness": size + 0 * w, "steer_damping": 1j * w * size}.get(c.family, 0 * w)
    amplitude = max(float(np.abs(r.moved(r.recording.time)[0]).max()) for r in verdict.base.runs)
    noise = _noise(verdict.base)
    samples = BARE_TIME * verdict.base.runs[0].recording.rate
    return _proposal("bare_bar", "Sweep the bare handlebar, hands off: the torque then holds the bar alone.", signals, amplitude**2 * samples / 2 / noise**2)


def _proposal(kind: str, sentence: str, signals: dict[str, np.ndarray], scale: float) -> dict[str, Any]:
    """The smallest distance of any two rivals, an unknown inertia of the bar taken out."""
    inertia = (2 * np.pi * SWEEP) ** 2
    names, distances = list(signals), []
    for i, a in enumerate(names):
        for b in names[i + 1 :]:
            difference = signals[a] - signals[b]
            difference = difference - inertia * np.real(np.vdot(inertia, difference)) / np.vdot(inertia, inertia)
            distances.append(float(np.mean(np.abs(difference) ** 2)) * scale)
    return {"experiment": kind, "sentence": sentence, "expected_delta_chi2": min(distances, default=0.0)}


def _again(verdict: Verdict, rivals: Sequence[Candidate], factor: float, kind: str) -> dict[str, Any]:
    """The same runs at another amplitude: nonlinear rivals part, linear ones only stand out more."""
    fits: list[Fit] = [c.fit for c in rivals if c.effect in c.fit.model.effects]
    gap = abs(fits[0].chi2 - fits[1].chi2) if len(fits) > 1 else abs(verdict.base.chi2 - fits[0].chi2) if fits else 0.0
    return {"experiment": "amplitude", "sentence": f"Repeat the runs at {factor:g} times the amplitude ({kind}).", "expected_delta_chi2": gap * factor**2}


def _gyro(rivals: Sequence[Candidate]) -> dict[str, Any] | None:
    if not any(c.family == "cross_inertia" for c in rivals):
        return None
    return {"experiment": "torso_gyro", "sentence": "Log the torso's rate with a gyro: a cross inertia turns the torso, a spring or damper at the bar does not.",
            "expected_delta_chi2": None}  # fmt: skip


def _noise(found: Fit) -> float:
    densities = [np.median(run.noise.density) for run in found.runs]
    return float(np.sqrt(np.median(densities))) if densities else TORQUE_NOISE
