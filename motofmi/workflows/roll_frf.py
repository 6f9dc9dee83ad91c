"""The roll test of 2008: the response of waist, shoulders and head to the roll of the mock-up, and the
features printed in the paper."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from fmus.support.notebook import html, new_axes
from motofmi.frequency_response.roll_motion import RollFRF, roll_frf
from motofmi.recordings.recording import Recording
from motofmi.reports import frf_figures
from motofmi.reports.frf_report import roll_chart
from motofmi.reports.report import Report, Section, Table
from motofmi.reports.shown import Interactive
from motofmi.workflows.measured import Recorded, Rig, paths_of, recordings_of, rig_of
from rider_fmu.roll_features import FEATURES, readings

HIGHEST, STEP = 7.0, 0.25  # Hz; highest frequency and spacing of the frequencies


@dataclass(frozen=True, repr=False)
class RollTest:
    """FRF_i and rFRF_i (2008, eqs 6 to 12) of the points of the body: absolute and relative, complex (n,) by point, at
    frequency (n,) [Hz]; `estimate_roll_frf` shows an example.
    """

    recording: Recording
    frf: RollFRF

    @property
    def features(self) -> list[dict[str, Any]]:
        """The features printed in the paper: printed range, measured range, and whether it is met."""
        return [{"quantity": f.quantity, "point": f.point, "feature": f.name, "printed": [f.low, f.high],
                 "measured": [low, high], "unit": f.unit, "met": bool(f.low <= low and high <= f.high)}
                for f, (low, high) in zip(FEATURES, readings(self.frf.absolute, self.frf.frequency),
                                          strict=True)]  # fmt: skip

    def to_dict(self) -> dict[str, Any]:
        """The keys of `motofmi frf --json` on a roll test."""
        return {"runs": [self.recording.name], "frequency": self.frf.frequency, "frf": self.frf.absolute,
                "relative_frf": self.frf.relative, "features": self.features,
                "warnings": list(self.recording.warnings)}  # fmt: skip

    def plot(self, axes: Any = None) -> Any:
        """Amplitude and phase of FRF_i and rFRF_i; the axes (2, 2) of matplotlib."""
        axes = new_axes(2, 2, sharex=True, figsize=(9.0, 6.5)) if axes is None else axes
        frf_figures.draw_roll(axes, self.frf)
        return axes

    def show(self) -> Interactive:
        """Amplitude and phase of FRF_i and rFRF_i, interactive in a notebook."""
        return Interactive(roll_chart(self.frf))

    def report(self, path: str | Path) -> Path:
        """Write an HTML report; its path. Raises InputError where it cannot be written."""
        rows = [(f"{f['quantity']}, {f['point']}", f["feature"].replace("_", " "),
                 *(interval(f[k]) for k in ("printed", "measured")), f["unit"],
                 "met" if f["met"] else "missed") for f in self.features]  # fmt: skip
        table = Table(("FRF", "feature", "printed", "measured", "unit", ""), rows, marks=[r[-1] for r in rows])
        met = sum(f["met"] for f in self.features)
        Report(
            "Roll test",
            f"{met} of the {len(rows)} printed features are met by {self.recording.name}.",
            [
                Section(
                    "Features of the 2008 paper",
                    ["Every feature that the paper prints, beside what was measured."],
                    [],
                    [table],
                )
            ],
            asked="How do waist, shoulders and head follow the roll of the mock-up?",
            warnings=self.recording.warnings,
            inputs=paths_of([self.recording]),
            figures=[
                (
                    roll_chart(self.frf),
                    "Absolute (FRF) and relative (rFRF) responses over frequency, as in Figs 16 to 23 of the 2008 "
                    "paper.",
                )
            ],
        ).write(Path(path))
        return Path(path)

    def __repr__(self) -> str:
        met = sum(f["met"] for f in self.features)
        return (
            f"RollTest({self.recording.name}: {', '.join(self.frf.absolute)}; {met} of {len(FEATURES)} printed "
            "features met)"
        )

    def _repr_html_(self) -> str:
        rows = [
            (f["quantity"], f["point"], f["feature"], interval(f["printed"]), interval(f["measured"]), f["unit"])
            for f in self.features
        ]
        return html(repr(self), ("quantity", "point", "feature", "printed", "measured", "unit"), rows)


def estimate_roll_frf(recording: Recorded, *, mapping: Mapping[str, str] | None = None, rate: float | None = None,
                      rig: Rig | None = None, band: tuple[float, float] = (0.5, HIGHEST)) -> RollTest:  # fmt: skip
    """The response of waist, shoulders and head to the roll of the mock-up, from one recording (path or
    Recording) of the roll test.

    mapping and rate as in `estimate_frf`. rig gives the heights [m] of the points above the roll axis (`mockup_height`
    and others; default: rig.json beside the recording); band is in Hz. Raises InputError for a missing height or
    channel.

        >>> from motofmi.virtual_rig.simulated_rig import roll_test
        >>> from rider_fmu.components.rider_in_roll import point_heights
        >>> recording, _ = roll_test()
        >>> heights = {"mockup": 0.5, **point_heights(mf.rider("roll_3_2008"))}
        >>> rig = {f"{point}_height": {"value": height, "unit": "m"} for point, height in heights.items()}
        >>> found = mf.estimate_roll_frf(recording, rig=rig)
        >>> sorted(found.frf.absolute), sorted(found.features[0])[:3]
        (['head', 'shoulder', 'waist'], ['feature', 'measured', 'met'])
        >>> axes = found.plot()
        >>> page, chart = found.report("roll.html"), found.show().save("chart.html")
        >>> sorted(found.to_dict())
        ['features', 'frequency', 'frf', 'relative_frf', 'runs', 'warnings']
    """
    run = recordings_of(recording, mapping, rate)[0]
    low, high = band
    heights = {
        name.removesuffix("_height"): entry["value"]
        for name, entry in rig_of(rig, [run]).items()
        if name.endswith("_height")
    }
    return RollTest(run, roll_frf(run, heights, np.arange(low, min(high, HIGHEST) + 1e-9, STEP)))


def interval(ends: Sequence[float]) -> str:
    """`1.2 to 1.4`, or one number."""
    return f"{ends[0]:.3g}" if ends[0] == ends[1] else f"{ends[0]:.3g} to {ends[1]:.3g}"
