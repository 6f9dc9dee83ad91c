"""What does a coupling do to the modes? Errors of frequency and damping over the step, for every
coupling, known before a run.

The FMUs of the mean rider and of the motorcycle at 30 m/s are linearised; each coupling's own algorithm is run on the
linear models and its eigenvalues are compared with those of the two coupled without error.
"""

import numpy as np

from fmus.cosimulation.cosimulate import join
from fmus.cosimulation.coupling import COUPLINGS
from fmus.cosimulation.coupling_error import Prediction, linear_network, predict
from motofmi.reports.charts import SEQUENCE, Axis, Chart, Curve, Panel
from motofmi.reports.report import Section, Table
from motofmi.workflows.ridden_fmus import ridden_fmus
from rider_fmu import riders
from vehicle_fmu import motorcycles

STEPS = np.geomspace(2e-4, 5e-2, 13)  # s
SHOWN = (1e-3, 1e-2)  # s
FASTEST = 2 * np.pi * 15  # rad/s
FLOOR = 1e-12  # rounding


def run(speed: float = 30.0) -> dict[str, dict[float, Prediction]]:
    """The prediction by coupling and step [s]."""
    units = ridden_fmus(motorcycles.load("sharp_1971"), riders.load("mean_2011"), speed=speed)
    network = linear_network(units, join(units))
    for unit in units.values():
        unit.close()
    return {
        name: {float(step): predict(c, network, float(step)) for step in (*STEPS, *SHOWN)}
        for name, c in COUPLINGS.items()
    }


def worst(prediction: Prediction) -> tuple[float, float]:
    """The largest errors of a frequency and of a damping ratio, of the modes below 15 Hz; NaN when not stable."""
    if not prediction.stable:
        return np.nan, np.nan
    modes = prediction.oscillatory & (prediction.exact.imag < FASTEST)
    return tuple(float(np.abs(e[modes]).max()) for e in (prediction.frequency_error, prediction.damping_error))  # type: ignore[return-value]


def chart(found: dict[str, dict[float, Prediction]]) -> Chart:
    """Both errors over the step; a curve ends where the coupling is no longer stable."""
    panels = []
    for k, what in enumerate(("frequency", "damping ratio")):
        curves = []
        for i, (name, by_step) in enumerate(found.items()):
            errors = np.maximum([worst(by_step[float(step)])[k] for step in STEPS], FLOOR)
            curves.append(
                Curve(
                    name,
                    1e3 * STEPS,
                    100 * errors,
                    SEQUENCE[i % len(SEQUENCE)],
                    "both" if i < len(SEQUENCE) else "dashed",
                )
            )
        panels.append(
            Panel(Axis("step", "ms", log=True), Axis(f"largest error of a {what}", "%", log=True), curves, height=340)
        )
    return Chart(panels, columns=2, linked=True)


def section(found: dict[str, dict[float, Prediction]]) -> Section:
    """The errors over the step, and a table of what the couplings are."""
    rows = []
    for name, by_step in found.items():
        cells = [
            f"{100 * error:.2g}" if np.isfinite(error) else "unstable"
            for step in SHOWN
            for error in worst(by_step[step])
        ]
        rows.append([name, COUPLINGS[name].summary, str(COUPLINGS[name].order), *cells])
    headings = [
        "coupling",
        "what it does",
        "order",
        *(f"{what} at {1e3 * step:g} ms [%]" for step in SHOWN for what in ("frequency", "damping")),
    ]
    text = ("A torque that is held for a step comes late, and a late damper is a weaker damper. The largest error of "
            "any mode below 15 Hz, rider on the motorcycle at 30 m/s, predicted from the linearised FMUs by running "
            "each coupling's own algorithm on them.")  # fmt: skip
    return Section(
        "What does a coupling do to the modes?",
        [text],
        [(chart(found), "Errors of the modes over the step")],
        [Table(headings, rows)],
    )
