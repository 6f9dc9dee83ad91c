"""Modes of a free motion that its duration does not resolve.

    |f_1 - f_2| < 1 / T

Two modes that are closer beat with a period longer than the motion, T. Their sum is then not distinguishable from one
mode whose amplitude and frequency change with the amplitude, as with dry friction or a nonlinear spring: the free
initial states of a further body take the place of the effect. An input that excites the modes would tell them apart.

Source: Kay, Marple, Proc. IEEE 69 (1981) 1380-1419, for the resolution 1 / T (Rayleigh).
"""

from typing import Any

import numpy as np

from motofmi.gap.estimation.fit_result import Fit
from motofmi.gap.estimation.starting_values import poles
from motofmi.gap.preprocessing.sampled_run import excited


def unresolved_modes(found: Fit) -> tuple[float, float, float] | None:
    """The frequencies [Hz] of the two closest modes of a fit with free runs and the resolution [Hz] of the longest run;
    None where it resolves them, an input varies, or no effect has states of its own."""
    model: Any = found.model
    if not any(effect.has_states() for effect in model.effects) or excited(found.runs):
        return None
    roots = poles(model, found.x)
    frequencies = np.sort(roots[roots.imag > 0].imag) / (2 * np.pi)
    resolution = 1 / max(float(run.recording.time[-1] - run.recording.time[0]) for run in found.runs)
    if len(frequencies) < 2 or np.min(np.diff(frequencies)) >= resolution:
        return None
    first = int(np.argmin(np.diff(frequencies)))
    return float(frequencies[first]), float(frequencies[first + 1]), resolution
