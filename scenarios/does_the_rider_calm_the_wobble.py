"""Does the rider calm the wobble, and does he upset the weave?

Root loci from 1 to 60 m/s as in the 2011 paper: the reference motorcycle, with the mean rider, with more
steering damping (Figs 7 and 14), and the rider with less and more damping in arms and waist (Figs 15 to 18).
The paper's text does not say by how much the dampings were changed; here it is one coefficient of variation
over the ten riders (its Table 2): 55 % for the arms, 45 % for the waist.
"""

from dataclasses import dataclass

import numpy as np

from fmus.declaration.component import Component
from motofmi.reports.charts import Chart, Choice
from motofmi.reports.report import Section, Table
from motofmi.reports.root_locus import root_locus
from motofmi.workflows.scenarios import InReport
from rider_fmu import riders
from vehicle_fmu import LinearDamper, Modes, modes, motorcycles, over_speed, ridden

REPORT = InReport("tour", 10, "root loci: rider, damper, changed damping")

SPEEDS = np.arange(1, 60.01, 0.5)
ARM_VARIATION, WAIST_VARIATION = 0.55, 0.45  # sigma/mu of c_a and c_t, 2011, Table 2
ADDED_DAMPING = 7.5  # N.m.s/rad, 2011, Fig. 14: 14.2 in all


@dataclass(frozen=True)
class Case:
    """One root locus: what is at the handlebar, in words and as a device."""

    label: str
    device: Component | None
    colour: str


def cases() -> dict[str, Case]:
    """The loci of the paper's figures by name."""
    mean = riders.load("mean_2011")
    arms, waist = mean.values["arm_damping"], mean.values["waist_damping"]

    def changed(parameter: str, value: float, colour: str) -> Case:
        less = "less" if value < mean.values[parameter] else "more"
        return Case(
            f"{less} {parameter.replace('_', ' ')}, {value:.1f} N.m.s/rad",
            mean.with_values(**{parameter: value}),
            colour,
        )

    return {
        "reference": Case("reference, without a rider", None, "measured"),
        "rider": Case("mean rider", mean, "found"),
        "damper": Case(
            f"damper of {ADDED_DAMPING} N.m.s/rad added",
            LinearDamper("damper", damping=ADDED_DAMPING),
            "base",
        ),
        "less arm damping": changed("arm_damping", arms * (1 - ARM_VARIATION), "changed"),
        "more arm damping": changed("arm_damping", arms * (1 + ARM_VARIATION), "fourth"),
        "less waist damping": changed("waist_damping", waist * (1 - WAIST_VARIATION), "fifth"),
        "more waist damping": changed("waist_damping", waist * (1 + WAIST_VARIATION), "sixth"),
    }


def run(vehicle: str = "reference_2011", speeds: np.ndarray = SPEEDS) -> dict[str, Modes]:
    """The modes of every case over speeds [m/s]."""
    motorcycle = motorcycles.load(vehicle)
    return {name: modes(over_speed(ridden(motorcycle, case.device)), speeds) for name, case in cases().items()}


CHOICES = {
    "rider and damper (Figs 7, 14)": ("reference", "rider", "damper"),
    "arm damping (Figs 15, 16)": ("rider", "less arm damping", "more arm damping"),
    "waist damping (Figs 17, 18)": ("rider", "less waist damping", "more waist damping"),
    "all": (),
}


def chart(found: dict[str, Modes]) -> Chart:
    """The root locus of every case, of which some are shown at first."""
    labels = {name: case.label for name, case in cases().items()}
    choices = [Choice(text, [labels[name] for name in names or found]) for text, names in CHOICES.items()]
    return root_locus(
        {labels[name]: result for name, result in found.items()},
        top=90.0,
        choices=choices,
        shown=choices[0].curves,
        colours={case.label: case.colour for case in cases().values()},
    )


def bands(result: Modes, mode: str) -> str:
    """The unstable band of a mode in words."""
    if mode not in result.unstable:
        return "absent"
    return ", ".join(f"{low:.1f} to {high:.1f}" for low, high in result.unstable[mode]) or "none"


def section(found: dict[str, Modes]) -> Section:
    """The answer, with the loci of the paper's figures and a table of the unstable bands."""
    rows = [
        [cases()[name].label, *(bands(result, m) for m in ("weave", "wobble", "rider_wobble", "capsize"))]
        for name, result in found.items()
    ]
    at_50 = {n: r["wobble"].eigenvalue[np.argmin(np.abs(r.speed - 50))] for n, r in found.items()}
    text = (
        f"The rider adds damping to wobble (real part at 50 m/s {at_50['rider'].real:.1f} instead of "
        f"{at_50['reference'].real:.2f} 1/s) and takes it from weave (unstable at {bands(found['rider'], 'weave')} m/s). "
        f"The damper adds damping to wobble, too ({at_50['damper'].real:.1f} 1/s); weave is then unstable at "
        f"{bands(found['damper'], 'weave')} m/s, and at {bands(found['reference'], 'weave')} m/s without either."
    )
    note = ("Changed dampings: the paper's text gives no amounts, so each is changed by one coefficient of variation "
            "of its Table 2, "
            f"{ARM_VARIATION:.0%} for the arms and {WAIST_VARIATION:.0%} for the waist.")  # fmt: skip
    caption = (
        f"Root loci, 1 to {SPEEDS[-1]:g} m/s in steps of {SPEEDS[1] - SPEEDS[0]:g}, as in the 2011 paper; points "
        "grow with speed. Buttons and legend switch "
        "the loci; the pointer shows mode, speed and frequency."
    )
    table = Table(
        ("at the handlebar", "weave unstable [m/s]", "wobble", "rider-wobble", "capsize"),
        rows,
        "Unstable bands of speed, 1 to 60 m/s",
    )
    return Section("Does the rider calm the wobble?", [text, note], [(chart(found), caption)], [table])
