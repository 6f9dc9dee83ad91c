"""The scenarios about the vehicles: complete tables, and the page that shows them."""

import numpy as np
import pytest

from motofmi.scenarios import does_fork_bending_turn_the_trend_of_wobble_round as of_freedoms
from motofmi.scenarios import does_the_passive_rider_calm_wobble_on_every_vehicle as on_every_vehicle
from motofmi.scenarios import what_does_each_reading_do_to_sharp_1994 as of_readings
from tests import ROOT
from vehicle_fmu import modes, motorcycles, over_speed, ridden

PAGE = (ROOT / "docs" / "vehicles.md").read_text("utf-8")


@pytest.mark.slow
def test_the_page_shows_the_computed_rows():
    system = on_every_vehicle.systems("sharp_1994")[on_every_vehicle.OFF]
    found = {("sharp_1994", on_every_vehicle.OFF): modes(over_speed(system), on_every_vehicle.SPEEDS)}
    for line in on_every_vehicle.markdown(on_every_vehicle.table(found)).splitlines():
        assert line in PAGE


@pytest.mark.slow
def test_every_reading_changes_the_motorcycle_and_is_on_the_page():
    motorcycle = motorcycles.load("sharp_1994")
    speeds = np.array([20.0, 50.0])
    shipped = modes(over_speed(ridden(motorcycle)), speeds)
    for words, changed in of_readings.readings(motorcycle).items():
        one = motorcycle.with_values(**changed)
        change = max(np.abs(modes(over_speed(ridden(one)), speeds)[m].eigenvalue - shipped[m].eigenvalue).max()
                    for m in ("weave", "wobble")) if changed else 1.0  # fmt: skip
        assert change > 1e-3, words
        assert f"| {words} |" in PAGE


@pytest.mark.slow
def test_the_findings_of_the_paper_are_on_the_page_with_what_is_missed():
    speeds = np.array([10.0, 30.0, 35.0, 60.0, 70.0])
    words = (of_freedoms.RIGID, "fork bending", "frame torsion", "rider lean", "rider slide")
    systems = of_freedoms.systems()
    found = {word: modes(over_speed(systems[word]), speeds) for word in words}
    shown = of_freedoms.findings(found)
    assert [row[-1] for row in shown.rows] == ["yes", "partly", "partly", "yes", "yes", "yes"]
    for row in shown.rows:
        assert f"| {row[0]} |" in PAGE
