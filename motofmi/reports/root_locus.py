"""The root locus of named modes over speed as a chart, of one vehicle or of several with one colour each."""

from collections.abc import Collection, Mapping, Sequence

import numpy as np

from motofmi.reports.charts import SEQUENCE, Axis, Chart, Choice, Curve, Note, Panel, Shade
from vehicle_fmu import MODES, Modes

MODE_COLOURS = dict(zip(MODES, SEQUENCE, strict=False))
LARGEST, SMALLEST = 8.0, 3.0  # px, of points at the highest and at the lowest speed


def root_locus(found: Mapping[str, Modes], low: float = -50.0, high: float = 6.0, top: float | None = None,
               colours: Mapping[str, str] | None = None, shown: Collection[str] | None = None,
               choices: Sequence[Choice] = ()) -> Chart:  # fmt: skip
    """The eigenvalues with a real part from low to high [1/s] and an imaginary part up to top [rad/s].

    Points grow with the speed; the pointer shows mode, speed and frequency. Of a single vehicle every mode has a
    colour, of several every vehicle; each mode is named once. shown are those that are visible at first.
    """
    parts = {name: _inside(each, low, top) for name, each in found.items()}
    if len(found) == 1:
        (one,) = found.values()
        curves = [
            _curve(
                one,
                mode.replace("_", "-"),
                [(m, k) for m, k in next(iter(parts.values())) if m == mode],
                MODE_COLOURS[mode],
                True,
            )
            for mode in one.unstable
        ]
    else:
        of = colours or dict(zip(found, [SEQUENCE[k % len(SEQUENCE)] for k in range(len(found))], strict=True))
        curves = [
            _curve(each, name, parts[name], of[name], shown is None or name in shown) for name, each in found.items()
        ]
    panel = Panel(
        Axis("real part", "1/s", low=low, high=high),
        Axis("imaginary part", "rad/s", low=0, high=top),
        curves,
        shades=[Shade(0, high, "unstable")],
        notes=_notes(found, parts),
        hover="point",
        height=460,
    )
    return Chart([panel], choices=choices)


def _inside(found: Modes, low: float, top: float | None) -> list[tuple[str, int]]:
    """Mode and place in the speeds of every eigenvalue that is drawn."""
    limit = np.inf if top is None else top
    return [
        (mode, int(k))
        for mode in found.unstable
        for k in np.flatnonzero((found[mode].eigenvalue.real > low) & (found[mode].eigenvalue.imag <= limit))
    ]


def _curve(found: Modes, name: str, parts: Sequence[tuple[str, int]], colour: str, shown: bool) -> Curve:
    width = np.ptp(found.speed) or 1.0
    values = np.array([found[mode].eigenvalue[k] for mode, k in parts], complex)
    sizes = [SMALLEST + (LARGEST - SMALLEST) * (found.speed[k] - found.speed[0]) / width for _, k in parts]
    text = [f"{mode.replace('_', '-')}, {found.speed[k]:g} m/s, {found[mode].frequency[k]:.2f} Hz" for mode, k in parts]
    return Curve(name, values.real, values.imag, colour, "circles", size=sizes, text=text, shown=shown)


def _notes(found: Mapping[str, Modes], parts: Mapping[str, Sequence[tuple[str, int]]]) -> list[Note]:
    """The name of each mode where its first branch that oscillates is farthest from other modes; none where the legend
    has the names."""
    if len(found) == 1:
        return []
    every = [(m, found[name][m].eigenvalue[k]) for name, each in parts.items() for m, k in each]
    notes: dict[str, Note] = {}
    for name, each in found.items():
        for mode in each.unstable:
            inside = np.array([v for m, k in parts[name] if m == mode and (v := each[mode].eigenvalue[k]).imag > 0.5])
            if len(inside) and mode not in notes:
                others = np.array([v for m, v in every if m != mode])
                apart = np.abs(inside[:, None] - others).min(axis=1) if len(others) else np.zeros(len(inside))
                at = inside[np.argmax(apart)]
                notes[mode] = Note(at.real, at.imag, mode.replace("_", "-"))
    return list(notes.values())
