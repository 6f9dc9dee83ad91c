"""Which test tells most about the rider? Sweeps, stepped sine and multisine of 200 s on the virtual rig,
compared by error bars."""

from math import radians

import numpy as np

from motofmi.frequency_response.estimators import estimate
from motofmi.frequency_response.excitation import Excitation, multisine, stepped_sine, sweep
from motofmi.identification.parameter_fit import Identification, identify
from motofmi.reports.charts import SEQUENCE, Axis, Chart, Curve, Panel
from motofmi.reports.report import Section, Table
from motofmi.virtual_rig.simulated_rig import steer_test
from motofmi.workflows.measured_rider import PARAMETERS, rig_response
from rider_fmu import riders
from rider_fmu.rigs.handlebar import HANDLEBAR_INERTIA

TESTS: dict[str, Excitation] = {
    "sweep up, 2 deg (2011)": sweep(),
    "sweep down, 2 deg": sweep(12, 0.5),
    "stepped sine, 4 deg (2008)": stepped_sine(seconds=200 / 17),
    "multisine, 4 deg": multisine(amplitude=radians(4)),
}


def run(rider: str = "mean_2011", seed: int = 0) -> dict[str, Identification]:
    """What each test identifies, with the noise of a real rig."""
    model = rig_response()
    return {name: identify([estimate(steer_test(riders.load(rider), HANDLEBAR_INERTIA, test, seed=seed,
                                                oversampling=2))], model)
            for name, test in TESTS.items()}  # fmt: skip


def chart(found: dict[str, Identification]) -> Chart:
    """Standard errors of the six parameters, by test."""
    names = [name.replace("_", " ") for name in PARAMETERS]
    curves = [
        Curve(name, 100 * f.standard_error / f.values, np.arange(len(names)), SEQUENCE[k], "points", size=9)
        for k, (name, f) in enumerate(found.items())
    ]
    return Chart(
        [
            Panel(
                Axis("standard error", "% of the value", log=True),
                Axis("parameter", "", names=names),
                curves,
                hover="point",
            )
        ]
    )


def section(found: dict[str, Identification]) -> Section:
    """The error bars, and the test with the smallest."""
    worst = {name: float(np.max(f.standard_error / f.values)) for name, f in found.items()}
    best = min(worst, key=worst.__getitem__)
    text = (f"With the same 200 s, potentiometer, torsiometer, converters and remnant, the {best} leaves the smallest "
            f"worst error, {100 * worst[best]:.2g} %; the others "
            f"{', '.join(f'{100 * w:.2g} % ({n})' for n, w in worst.items() if n != best)}. These errors are of one "
            "run's rider: a rider differs by more from run to run, so repeats tell more than longer "
            "tests.")  # fmt: skip
    rows = [
        (name, *(f"{100 * e / v:.2g}" for e, v in zip(f.standard_error, f.values, strict=True)))
        for name, f in found.items()
    ]
    return Section("Which test tells most about the rider?", [text], [(chart(found), "Standard errors by test, one "
                                                                                      "simulated run each")],
                   [Table(("test", *PARAMETERS), rows, "standard errors [%]")])  # fmt: skip
