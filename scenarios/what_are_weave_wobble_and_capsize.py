"""What are weave, wobble and capsize? The three modes of a motorcycle with rider, explained and animated.

The mean rider of 2011 on the paper's reference motorcycle; every animation is the eigenvector at the stated speed.
"""

from dataclasses import dataclass

import numpy as np

from motofmi.reports.mode_animation import mode_animation
from motofmi.reports.report import Section
from motofmi.reports.sketch import motorcycle_sketch
from motofmi.scenarios.what_moves_in_each_mode import phasors
from motofmi.workflows.scenarios import InReport

REPORT = InReport("tour", 5, "weave, wobble, capsize animated")

EXPLAINED = {
    "weave": (
        50.0,
        "In weave the whole motorcycle yaws, rolls and steers in a slow S-shaped path. It is well damped at middle "
        "speeds and "
        "weakly damped or unstable at high speed.",
    ),
    "wobble": (
        50.0,
        "In wobble mainly the front assembly turns quickly about the steer axis, while the rear frame hardly moves. "
        "A damper or "
        "the arms of a rider at the handlebar damp it.",
    ),
    "capsize": (
        20.0,
        "In capsize the motorcycle leans over without oscillating and drifts to the side of the lean. It is slow, so "
        "that a "
        "rider corrects it with ease even where it is unstable.",
    ),
}


@dataclass(frozen=True)
class Explained:
    """A mode at a speed [m/s]: eigenvalue [1/s] and phasors."""

    speed: float
    eigenvalue: complex
    motion: dict[str, complex]


def run() -> dict[str, Explained]:
    """The three modes of the mean rider on the reference motorcycle."""
    return {mode: Explained(speed, *phasors(mode, speed)) for mode, (speed, _) in EXPLAINED.items()}


def section(found: dict[str, Explained]) -> Section:
    """The sketch, and each mode in two sentences with its animation."""
    text = (
        "A motorcycle running straight ahead has three modes that a rider feels: weave, wobble and capsize. Here "
        "they are those of the "
        "reference motorcycle (Cossalter et al. 2011) with the mean of ten measured riders."
    )
    animations = [
        (
            mode_animation(f"{mode}, {each.speed:g} m/s", each.eigenvalue, each.motion),
            f"{EXPLAINED[mode][1]} {numbers(mode, each)}",
        )
        for mode, each in found.items()
    ]
    return Section("What are weave, wobble and capsize?", [text], [(motorcycle_sketch(), ""), *animations])


def numbers(mode: str, each: Explained) -> str:
    """Speed, frequency and growth of a mode in words."""
    growth = each.eigenvalue.real
    change = f"{'doubles' if growth > 0 else 'halves'} in {np.log(2) / abs(growth):.2g} s" if growth else "is constant"
    oscillates = f"{each.eigenvalue.imag / (2 * np.pi):.2f} Hz, " if each.eigenvalue.imag else "no oscillation, "
    return f"At {each.speed:g} m/s: {oscillates}its amplitude {change}."
