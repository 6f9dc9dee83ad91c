"""Charts as data: numbers, long curves, notes beside points; and the same drawn by matplotlib."""

import json

import numpy as np
import pytest

import motofmi as mf
from fmus.cosimulation.cosimulation_run import CosimulationRun
from fmus.support.plain_json import to_json
from motofmi.reports.chart_figures import figure
from motofmi.reports.charts import (
    COLOURS,
    POINTS,
    Axis,
    Cells,
    Chart,
    Choice,
    Curve,
    Line,
    Note,
    Panel,
    Shade,
    placed,
    thinned,
)
from motofmi.reports.time_histories import time_histories

X = np.linspace(0, 1, 50)


def panel(*curves: Curve, **options) -> Panel:
    return Panel(Axis("time", "s"), Axis("torque", "N.m"), curves, **options)


def test_data_are_strict_json_with_units_on_every_axis():
    chart = Chart(
        [
            panel(
                Curve("a", X, np.where(X > 0.5, np.nan, X), band=(X - 1, X + 1)),
                shades=[Shade(0, 1, "range")],
                lines=[Line(0.5, "limit")],
                cells=Cells([0], [1], [0], [1], [2.0], "excess", 1, 10),
            )
        ],
        choices=[Choice("only a", ["a"])],
    )
    data = json.loads(to_json(chart.to_dict(), indent=None))
    (drawn,) = data["panels"]
    assert (drawn["x"]["title"], drawn["y"]["title"]) == ("time [s]", "torque [N.m]")
    assert drawn["curves"][0]["y"][-1] is None and drawn["curves"][0]["y"][0] == 0.0
    assert (
        data["choices"] == [{"label": "only a", "curves": ["a"]}] and "torque [N.m] over time [s]: a" in data["words"]
    )


def test_a_long_curve_keeps_its_extremes():
    x = np.arange(1e5)
    y = np.sin(x / 7)
    y[12345] = 5.0
    kept = thinned(x, y)
    assert len(kept) <= POINTS + 2 and (kept[0], kept[-1]) == (0, len(x) - 1) and np.all(np.diff(kept) > 0)
    assert y[kept].max() == 5.0 and 12345 in kept
    assert len(thinned(x[:100], y[:100])) == 100


def test_a_long_curve_stays_interrupted():
    y = np.sin(np.arange(100_000.0))  # zero is no extreme value
    y[[20_000, 70_001]] = np.nan
    assert set(np.flatnonzero(np.isnan(y))) <= set(thinned(np.arange(100_000.0), y))


def test_notes_do_not_lie_on_points():
    curve = Curve("a", X, X**2, style="points")
    notes = placed(panel(curve, notes=[Note(0.5, 0.25, "middle"), Note(0.5, 0.25, "again")]))
    for note in notes:
        # Farther than half a line from every point of the curve, and within the panel
        assert np.hypot(note.x - X, note.y - X**2).min() > 0.025 and 0 <= note.x <= 1 and 0 <= note.y <= 1
    assert np.hypot(notes[0].x - notes[1].x, notes[0].y - notes[1].y) > 0.025


def luminance(colour: str) -> float:
    """Relative luminance of a colour (WCAG 2.2)."""
    parts = np.array([int(colour[k : k + 2], 16) / 255 for k in (1, 3, 5)])
    return float(np.where(parts <= 0.04045, parts / 12.92, ((parts + 0.055) / 1.055) ** 2.4) @ [0.2126, 0.7152, 0.0722])


@pytest.mark.parametrize("name", COLOURS)
def test_curves_contrast_with_the_background(name):
    """Contrast of 3 for graphics (WCAG 2.2, 1.4.11)."""
    light, dark = COLOURS[name]
    assert 1.05 / (luminance(light) + 0.05) >= 3 and (luminance(dark) + 0.05) / (luminance("#161616") + 0.05) >= 3


@pytest.mark.slow
def test_the_same_chart_is_drawn_by_matplotlib():
    bars = Panel(Axis("size", "1"), Axis("name", "", names=["one", "two"]), [Curve("b", [1, 2], [0, 1], style="bars")])
    errors = panel(
        Curve("e", X[:3], X[:3], style="errors", band=(X[:3] - 1, X[:3] + 1)),
        Curve("n", [1], [1], style="needles"),
        Curve("c", X, X, style="circles"),
    )
    cells = panel(cells=Cells([0, 1], [1, 2], [0, 0], [1, 1], [2.0, 3.0], "excess", 1, 10, [True, False]))
    drawn = figure(
        Chart(
            [
                panel(Curve("a", X, X), Curve("hidden", X, X, shown=False), notes=[Note(0.5, 0.5, "here")]),
                bars,
                errors,
                cells,
            ],
            columns=2,
        )
    )
    first, second, *_ = drawn.axes
    assert (
        len(first.lines) == 1
        and first.get_ylabel() == "torque [N.m]"
        and [t.get_text() for t in first.texts] == ["here"]
    )
    assert [label.get_text() for label in second.get_yticklabels()] == ["one", "two"]
    drawn.draw_without_rendering()


@pytest.mark.slow
def test_a_root_locus_holds_the_eigenvalues():
    bike, speeds = mf.vehicle("sharp_1971"), [20.0, 30.0, 40.0]
    modes = mf.modes(bike, speed=speeds)
    (panel_of_modes,) = modes.show().chart.panels
    weave = next(c for c in panel_of_modes.curves if c.name == "weave")
    np.testing.assert_array_equal(weave.x + 1j * np.asarray(weave.y), modes["weave"].eigenvalue)
    assert weave.text[1].startswith("weave, 30 m/s")
    both = mf.compare_modes(bike, {"alone": None, "damped": "damper:7.5"}, speeds).show()
    (compared,) = both.chart.panels
    assert [c.name for c in compared.curves] == ["alone", "damped"] and {"weave", "wobble"} <= {
        note.text for note in compared.notes
    }


def test_time_histories_have_a_panel_for_each_unit():
    rows = np.column_stack([X, X, 2 * X, np.cos(X)])
    columns = ("time [s]", "vehicle.steer_angle [rad]", "vehicle.roll_angle [rad]", "device.handlebar_torque [N.m]")
    run = CosimulationRun(0.1, "jacobi", columns, rows, None, 1.0, None, [], 9, 0.1, 0.1)
    angles, torque = time_histories(run).panels
    assert (angles.y.unit, torque.y.title) == ("deg", "handlebar torque [N.m]") and len(angles.curves) == 2
    np.testing.assert_allclose(angles.curves[1].y, np.degrees(2 * X))
    (only,) = time_histories(run, ["device.handlebar_torque"]).panels
    assert only.y.unit == "N.m"
