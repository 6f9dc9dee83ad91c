"""What does the gap workflow say when the linear rider is fitted to the full one? The servo test at 1, 2, 4 and 8 deg.

Every run is a sweep up with the rig's noise, remnant and converters, validated on a sweep down. The base is the
passive rider. Where the handlebar's inertia is known, the limbs' share of it is what the passive rider lacks first;
where it is not (hands and bar are not identifiable separately from one port), the rest is what no linear rider has:
the geometry of the arms.
"""

import tempfile
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from fmus.support.progress import track
from motofmi.frequency_response.excitation import sweep
from motofmi.recordings.reading import write_recording
from motofmi.reports.charts import Axis, Chart, Curve, Line, Panel
from motofmi.reports.report import Section, Table
from motofmi.virtual_rig.full_rider import steer_test
from motofmi.workflows.gap.find_gap import find_gap
from motofmi.workflows.gap.result import Gap
from motofmi.workflows.scenarios import InReport
from rider_fmu import riders
from rider_fmu.full_rider.reduction import Reduced, reduce
from rider_fmu.rigs.handlebar import HANDLEBAR_INERTIA

REPORT = InReport("full rider", 30, "verdicts on the full rider")

AMPLITUDES = (1.0, 2.0, 4.0, 8.0)  # deg
KNOWN_BAR = {
    "handlebar_inertia": {"value": HANDLEBAR_INERTIA, "standard_error": 0.01 * HANDLEBAR_INERTIA, "unit": "kg.m2"}
}
UP, DOWN = 90.0, 80.0  # s


@dataclass(frozen=True)
class Verdicts:
    """What `find_gap` finds by amplitude [deg] with the handlebar's inertia unknown, and at the smallest with it
    known; the reduced rider."""

    by_amplitude: dict[float, Gap]
    known_bar: Gap
    reduced: Reduced

    @property
    def smallest(self) -> float:
        """The smallest amplitude [deg]."""
        return min(self.by_amplitude)


def run(
    amplitudes: tuple[float, ...] = AMPLITUDES, rider: str = "full_mean_2011", up: float = UP, down: float = DOWN
) -> Verdicts:
    """The verdicts on sweeps up, validated on sweeps down; up and down are their durations [s]."""
    full, verdicts = riders.load(rider), {}
    with tempfile.TemporaryDirectory() as folder:
        for amplitude in track(amplitudes, "sweeps and verdicts"):
            files = [Path(folder) / f"{direction}_{amplitude:g}_deg.csv" for direction in ("up", "down")]
            motions = (sweep(0.5, 12, up, np.radians(amplitude)), sweep(12, 0.5, down, np.radians(amplitude)))
            for seed, (file, motion) in enumerate(zip(files, motions, strict=True)):
                write_recording(steer_test(full, HANDLEBAR_INERTIA, motion, seed=seed), file)
            verdicts[amplitude] = find_gap(files[0], validation=files[1])
            if amplitude == min(amplitudes):
                known = find_gap(files[0], validation=files[1], rig=KNOWN_BAR)
    return Verdicts(verdicts, known, reduce(full))


def chart(found: Verdicts) -> Chart:
    """The misfit of the validation sweeps over the amplitude, before and after."""
    amplitudes = list(found.by_amplitude)
    curves = [
        Curve(label, amplitudes, [v.gap[key] for v in found.by_amplitude.values()], colour, "both")
        for key, label, colour in (
            ("holdout_before", "linear rider", "measured"),
            ("holdout_after", "with the effects found", "found"),
        )
    ]
    return Chart(
        [
            Panel(
                Axis("amplitude of the sweep", "deg", log=True),
                Axis("reduced chi-square of the validation run", "1", log=True),
                curves,
                lines=[Line(1.0, "noise floor")],
            )
        ]
    )


def section(found: Verdicts) -> Section:
    """The verdict at each amplitude."""
    known, reduced = found.known_bar, found.reduced
    said = "; ".join(f"{a:g} deg: {in_words(v)}" for a, v in found.by_amplitude.items())
    text = [f"Where the handlebar's inertia is known, the verdict at {found.smallest:g} deg is {in_words(known)}. The "
            "limbs of the full rider add "
            f"{reduced.steer_inertia:.3f} kg.m2 to the steer axis, which the passive rider of 2011 has not.",
            f"Where it is not known, the linear coefficients are complete, and the rest is geometry. Verdicts: {said}. "
            "No effect of the library is the geometry of arms, so any name here is wrong; the misfit that remains on "
            "the validation sweep shows it."]  # fmt: skip
    rows = [[case, in_words(v),
             *(f"{v.gap[k]:.4g}" if v.gap[k] is not None else ""
               for k in ("before", "after", "holdout_before", "holdout_after"))]
            for case, v in ((f"{found.smallest:g} deg, bar known", known),
                            *((f"{a:g} deg", v) for a, v in found.by_amplitude.items()))]  # fmt: skip
    headings = ("sweep", "verdict", "before", "after", "validation, before", "validation, after")
    return Section("What does the gap workflow say of the full rider?", text,
                   [(chart(found), "Misfit over the amplitude, in units of the noise")],
                   [Table(headings, rows, "Reduced chi-square, one is the noise")])  # fmt: skip


def in_words(result: Gap) -> str:
    """The verdict with its names and values."""
    effects = [f"{e['name']} ({e['form']}): " + ", ".join(f"{n} = {p['value']:.4g} +- {p['standard_error']:.2g} "
                                                          f"{p['unit']}" for n, p in e["parameters"].items())
               for e in result.effects]  # fmt: skip
    return " ".join([result.verdict, " and ".join(effects) or ", ".join(result.tied)]).strip()
