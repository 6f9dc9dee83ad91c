"""The numbers of docs/full_rider.md: what the scenarios about the full rider and the rider in roll find."""

from collections.abc import Callable

import numpy as np

from motofmi.scenarios import (
    does_anthropometry_give_the_inertias,
    does_kinematics_explain_amplitude_dependence,
    what_do_roll_features_leave_open,
    what_does_lean_do_to_weave,
    what_does_the_gap_say_of_the_full_rider,
)
from rider_fmu import riders
from rider_fmu.full_rider.reduction import reduce

SPEED = 40.0  # m/s


def run(progress: Callable) -> dict:
    """The answers by question."""
    questions = {
        "posture": posture,
        "anthropometry": anthropometry,
        "kinematics": kinematics,
        "riders_differ": riders_differ,
        "lean": lean,
        "features": features,
        "gap": gap,
    }
    return {name: questions[name]() for name in progress(list(questions), "questions about the full rider")}


def posture() -> dict:
    """The change of the inertia that the rider reflects to the steer axis, by steer angle [deg], as a percentage."""
    rider = riders.load("full_mean_2011")

    def reflected(angle: float) -> float:
        found = reduce(rider, np.radians(angle))
        return found.steer_inertia - found.cross_inertia**2 / found.torso_inertia

    return {f"{angle:g}": 100 * (reflected(angle) / reflected(0.0) - 1) for angle in (4.0, 8.0)}


def anthropometry() -> dict:
    """Ratio of identified to anthropometric torso inertia, inertia of the hands, and what joints cannot give [%]."""
    rows = does_anthropometry_give_the_inertias.run()
    own, found, hands = (
        np.array([row[key] for row in rows]) for key in ("torso_inertia", "identified_torso_inertia", "steer_inertia")
    )
    return {
        "ratio": _range(found / own),
        "correlation": float(np.corrcoef(own, found)[0, 1]),
        "hands_inertia": _range(hands),
        "not_reached": {
            f"{row['rider'].split('_')[0]} {kind}": 100 * float(joints.residual)
            for row in rows
            for kind, joints in row["spread"].items()
            if joints.at_zero
        },
    }


def kinematics() -> dict:
    """The change of the FRF by amplitude [deg], as a percentage."""
    found = does_kinematics_explain_amplitude_dependence.run()
    return {f"{a:g}": 100 * float(c) for a, c in zip(found.amplitude, found.change, strict=True)}


def riders_differ() -> dict:
    """Standard deviations of the ten riders' stiffnesses, dampings and torso inertias over their means, as
    percentages."""
    ten = [riders.load(f"{number}_2011").values for number in range(1, 11)]
    names = ("torso_inertia", "arm_stiffness", "waist_stiffness", "arm_damping", "waist_damping")
    of = {name: np.array([each[name] for each in ten]) for name in names}
    return _range([100 * values.std(ddof=1) / values.mean() for values in of.values()])


def lean() -> dict:
    """Ranges of unstable weave and wobble [m/s], and weave at 40 m/s, by rider."""
    found = {}
    for name, modes in what_does_lean_do_to_weave.run().items():
        weave = modes["weave"].eigenvalue[np.argmin(np.abs(modes.speed - SPEED))]
        unstable = {mode: [list(map(float, band)) for band in modes.unstable[mode]] for mode in ("weave", "wobble")}
        found[name] = {**unstable, "real": float(weave.real), "frequency": float(weave.imag / (2 * np.pi))}
    return found


def features() -> dict:
    """The printed features that are met, and what they leave open."""
    found = what_do_roll_features_leave_open.run()
    return {
        "features": len(what_do_roll_features_leave_open.FEATURES),
        "lean_stiffness": _range(found.ranges["lean_stiffness"]),
        "weave": _range(found.weave),
    }


def gap() -> dict:
    """The verdicts on sweeps by amplitude [deg], and with the bar's inertia known."""
    found = what_does_the_gap_say_of_the_full_rider.run()
    cases = {**{f"{a:g}": each for a, each in found.by_amplitude.items()}, "known": found.known_bar}
    return {"limbs": found.reduced.steer_inertia, **{name: _verdict(each) for name, each in cases.items()}}


def _verdict(found) -> dict:
    return {
        "verdict": found.verdict,
        "effects": [{key: effect[key] for key in ("name", "form", "parameters")} for effect in found.effects],
        "nearest": (found.to_dict().get("closest") or {}).get("name"),
        "before": found.gap["holdout_before"],
        "after": found.gap["holdout_after"],
    }


def _range(values) -> dict[str, float]:
    return {"low": float(np.min(values)), "high": float(np.max(values))}
