"""Responses over frequency as a chart: magnitude above phase."""

from collections.abc import Mapping

import numpy as np

from motofmi.reports.charts import SEQUENCE, Axis, Chart, Curve, Panel


def bode(frequency: np.ndarray, responses: Mapping[str, np.ndarray], units: Mapping[str, str]) -> Chart:
    """Complex responses (n,) by name, with their units, at frequencies (n,) [Hz]."""
    axis = Axis("frequency", "Hz", log=True)
    named = [(f"{name.replace('_', ' ')} [{units[name]}]", z, SEQUENCE[k % len(SEQUENCE)])
             for k, (name, z) in enumerate(responses.items())]  # fmt: skip
    magnitude = [Curve(name, frequency, np.abs(z), colour) for name, z, colour in named]
    phase = [Curve(name, frequency, np.degrees(np.angle(z)), colour) for name, z, colour in named]
    return Chart(
        [Panel(axis, Axis("magnitude", "", log=True), magnitude), Panel(axis, Axis("phase", "deg"), phase)], linked=True
    )
