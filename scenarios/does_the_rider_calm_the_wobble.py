"""Does the rider calm the wobble, and does he upset the weave?

Root loci from 1 to 60 m/s as in the 2011 paper: the reference motorcycle, with the mean rider, with more
steering damping (Figs 7 and 14), and the rider with less and more damping in arms and waist (Figs 15 to 18).
The paper's text does not say by how much the dampings were changed; here it is one coefficient of variation
over the ten riders (its Table 2): 55 % for the arms, 45 % for the waist.
"""

from dataclasses import dataclass

import numpy as np
from matplotlib.figure import Figure

from fmus.declaration.component import Component
from motofmi.reports.figures import COLOURS, new_figure
from motofmi.reports.report import Section, Table
from motofmi.workflows.scenarios import InReport
from rider_fmu import riders
from vehicle_fmu import MODES, LinearDamper, Modes, modes, motorcycles, over_speed, ridden

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
    marker: str


def cases() -> dict[str, Case]:
    """The loci of the paper's figures by name."""
    mean = riders.load("mean_2011")
    arms, waist = mean.values["arm_damping"], mean.values["waist_damping"]

    def changed(parameter: str, value: float) -> Case:
        text = f"{parameter.replace('_', ' ')} {value:.1f} instead of {mean.values[parameter]:.1f} N.m.s/rad"
        return Case(f"mean rider, {text}", mean.with_values(**{parameter: value}), COLOURS["changed"], "s")

    return {
        "reference": Case("reference, no rider impedance", None, COLOURS["reference"], "o"),
        "rider": Case("mean rider", mean, COLOURS["rider"], "o"),
        "damper": Case(
            f"damper of {ADDED_DAMPING} N.m.s/rad added",
            LinearDamper("damper", damping=ADDED_DAMPING),
            COLOURS["damper"],
            "s",
        ),
        "less arm damping": changed("arm_damping", arms * (1 - ARM_VARIATION)),
        "more arm damping": changed("arm_damping", arms * (1 + ARM_VARIATION)),
        "less waist damping": changed("waist_damping", waist * (1 - WAIST_VARIATION)),
        "more waist damping": changed("waist_damping", waist * (1 + WAIST_VARIATION)),
    }


def run(vehicle: str = "reference_2011", speeds: np.ndarray = SPEEDS) -> dict[str, Modes]:
    """The modes of every case over speeds [m/s]."""
    motorcycle = motorcycles.load(vehicle)
    return {name: modes(over_speed(ridden(motorcycle, case.device)), speeds) for name, case in cases().items()}


FIGURES = {
    "Fig. 7": ("reference", "rider"),
    "Fig. 14": ("reference", "rider", "damper"),
    "Fig. 15": ("rider", "less arm damping"),
    "Fig. 16": ("rider", "more arm damping"),
    "Fig. 17": ("rider", "less waist damping"),
    "Fig. 18": ("rider", "more waist damping"),
}


def figure(found: dict[str, Modes], names: tuple[str, ...]) -> Figure:
    """The root locus of some cases; marks grow with the speed, every mode is named once."""
    picture, ax = new_figure(width=7.5, height=5)
    ax.axvspan(0, 12, color="#fbe3dc", zorder=0)
    for name in names:
        case, result = cases()[name], found[name]
        sizes = 2 + 18 * (result.speed - result.speed[0]) / np.ptp(result.speed)
        for k, column in enumerate(result.eigenvalues.T):
            ax.scatter(column.real, np.abs(column.imag), s=sizes, marker=case.marker, facecolors="none",
                       edgecolors=case.colour, linewidths=0.7, label=case.label if k == 0 else None)  # fmt: skip
    labelled = found[names[-1]]
    for mode in MODES:
        values = labelled[mode].eigenvalue
        shown = values[(values.imag > 0.5) & (values.real > -50)]
        if len(shown):
            place = shown[len(shown) // 2]
            ax.annotate(
                mode.replace("_", "-"),
                (place.real, place.imag),
                xytext=(-8, 10),
                textcoords="offset points",
                ha="right",
                fontsize=9,
            )
    ax.set(xlim=(-50, 6), ylim=(-2, 92), xlabel="real part [1/s]", ylabel="imaginary part [rad/s]")
    ax.legend(loc="upper left", fontsize=8, framealpha=0.9)
    return picture


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
    text = (f"At 50 m/s the reference's wobble has a real part of {at_50['reference'].real:.2f} 1/s; with the mean "
            "rider it is "
            f"{at_50['rider'].real:.1f}, with the added damper {at_50['damper'].real:.1f}. The rider upsets the weave "
            f"({bands(found['rider'], 'weave')} m/s). With the added damper it is unstable at "
            f"{bands(found['damper'], 'weave')} m/s, "
            f"without either at {bands(found['reference'], 'weave')} m/s.")  # fmt: skip
    note = ("Changed dampings: the paper's text gives no amounts, so each is changed by one coefficient of variation "
            "of its Table 2, "
            f"{ARM_VARIATION:.0%} for the arms and {WAIST_VARIATION:.0%} for the waist.")  # fmt: skip
    captions = [(figure(found, names), f"{title} of the 2011 paper, as computed; 1 to 60 m/s, marks grow with speed. "
                 "Shaded: unstable.") for title, names in FIGURES.items()]  # fmt: skip
    table = Table(
        ("at the handlebar", "weave unstable [m/s]", "wobble", "rider-wobble", "capsize"),
        rows,
        "Unstable bands of speed, 1 to 60 m/s",
    )
    return Section("Does the rider calm the wobble?", [text, note], captions, [table])
