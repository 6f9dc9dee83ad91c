"""Modes of a free motion that its duration T does not resolve.

    |f_1 - f_2| < 1 / T,   or |s_1 - s_2| < 1 / T of two decays exp(-s t)

Two modes that are closer beat with a period longer than the motion. Their sum is then not distinguishable from one mode
whose amplitude and frequency change with the amplitude, as with dry friction or a nonlinear spring: the free initial
states of a further body take the place of the effect. The ratio of two such decays changes by less than a factor of e
over the motion: their sum is not distinguishable from one decay whose rate changes, as with quadratic drag. An input
that excites the modes would distinguish them.

Source: Kay, Marple, Proc. IEEE 69 (1981) 1380-1419, for the resolution 1 / T (Rayleigh); Istratov, Vyvenko, Rev. Sci.
Instrum. 70 (1999) 1233-1257, for decays.
"""

from dataclasses import dataclass
from typing import Any

import numpy as np

from motofmi.gap.estimation.fit_result import Fit
from motofmi.gap.estimation.starting_values import poles
from motofmi.gap.preprocessing.sampled_run import excited


@dataclass(frozen=True)
class Unresolved:
    """Two modes that are closer than the resolution of the longest run: frequencies [Hz], or rates of decay [1/s]."""

    what: str
    first: float
    second: float
    resolution: float
    unit: str

    def __str__(self) -> str:
        resolution = f"resolution {self.resolution:.2g} {self.unit}"
        return f"{self.what} of {self.first:.4g} and {self.second:.4g} {self.unit} ({resolution})"


def unresolved_modes(found: Fit) -> Unresolved | None:
    """The two closest modes of a fit with free runs; None where the longest run resolves them, an input varies, or no
    effect has states of its own. Decays are not compared where those of the base alone are not resolved."""
    model: Any = found.model
    if not any(effect.has_states() for effect in model.effects) or excited(found.runs):
        return None
    resolution = 1 / max(float(run.recording.time[-1] - run.recording.time[0]) for run in found.runs)
    roots, of_base = (poles(each, found.x) for each in (model, type(model)(model.experiment)))
    if closest := _closest(roots[roots.imag > 0].imag / (2 * np.pi), resolution):
        return Unresolved("modes", *closest, resolution, "Hz")
    if (closest := _closest(_decays(roots), resolution)) and not _closest(_decays(of_base), resolution):
        return Unresolved("decays", *closest, resolution, "1/s")
    return None


def _decays(roots: np.ndarray) -> np.ndarray:
    return -roots[roots.imag == 0].real


def _closest(values: np.ndarray, resolution: float) -> tuple[float, float] | None:
    """The two closest of some values, where they are closer than the resolution."""
    ordered = np.sort(values)
    if len(ordered) < 2 or np.min(np.diff(ordered)) >= resolution:
        return None
    first = int(np.argmin(np.diff(ordered)))
    return float(ordered[first]), float(ordered[first + 1])
