"""The roll test: the response of the rider's body to the roll of the mock-up.

    FRF_i = a_i / (alpha h_i) = a_i h_1 / (a_1 h_i),     rFRF_i = FRF_i - 1

a_1 is the tangential acceleration of the mock-up at the distance h_1 from the roll axis, a_i that of the
rider's body at h_i: waist, shoulders and head are points 2, 3 and 4.

Source: Cossalter, Doria, Fabris, Maso (2008), Sect. 4, eqs 6 to 12.
"""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from fmus.support.errors import InputError
from motofmi.frequency_response.estimators import band_average, spectra
from motofmi.recordings.channels import BODY_POINTS, MOCKUP_ACCELERATION
from motofmi.recordings.recording import Recording
from motofmi.recordings.resampling import uniform

WIDTH = 0.15  # Hz; width of the band around each frequency of the test


@dataclass(frozen=True)
class RollFRF:
    """frequency (n,) [Hz]; absolute: point -> FRF (n,) complex; relative: point -> rFRF (n,) complex."""

    frequency: np.ndarray
    absolute: dict[str, np.ndarray]

    @property
    def relative(self) -> dict[str, np.ndarray]:
        return {point: frf - 1 for point, frf in self.absolute.items()}


def roll_frf(recording: Recording, heights: Mapping[str, float], frequencies: np.ndarray) -> RollFRF:
    """The FRFs of a test with single frequencies [Hz], in any order; heights [m] of mockup, waist, shoulder, head.

    Raises InputError for a missing height or channel.
    """
    points = [point for point in BODY_POINTS if f"{point}_acceleration" in recording.columns]
    for point in ("mockup", *points):
        if not heights.get(point, 0) > 0:
            raise InputError(f"{recording.name}: the height of {point} above the roll axis is missing; "
                             f'give "{point}_height": {{"value": 1.0, "unit": "m"}} in rig.json')  # fmt: skip
    recording, _ = uniform(recording)
    body = [f"{point}_acceleration" for point in points]
    lines = spectra(recording, [MOCKUP_ACCELERATION, *body])
    absolute = {}
    for point, channel in zip(points, body, strict=True):
        ratios = []
        for f in frequencies:
            k = lines.near(f, WIDTH)
            mockup = lines.values[MOCKUP_ACCELERATION][k]
            ratios.append(
                band_average(
                    (lines.frequency[k] - f) / (WIDTH / 2), lines.stretch[k], mockup, lines.values[channel][k], mockup
                )[0]
            )
        absolute[point] = np.array(ratios) * heights["mockup"] / heights[point]
    return RollFRF(np.asarray(frequencies, float), absolute)
