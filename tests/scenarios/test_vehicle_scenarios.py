"""The scenarios about the vehicles: complete tables, and the page that shows them."""

from importlib.util import find_spec

import numpy as np
import pytest

from motofmi.scenarios import do_tyres_make_a_bicycle_wobble as of_bicycles
from motofmi.scenarios import does_fork_bending_turn_the_trend_of_wobble_round as of_freedoms
from motofmi.scenarios import does_the_passive_rider_calm_wobble_on_every_vehicle as on_every_vehicle
from motofmi.scenarios import is_a_passive_rider_like_sharps_hands as of_hands
from motofmi.scenarios import what_do_suspensions_do_to_weave_in_a_corner as of_suspensions
from motofmi.scenarios import what_does_each_reading_do_to_sharp_1994 as of_readings
from motofmi.scenarios import what_does_the_passive_rider_do_to_weave_in_a_corner as of_corners
from motofmi.scenarios import which_damper_serves_which_vehicle as of_dampers
from motofmi.scenarios import which_riders_weave as of_riders
from tests import ROOT
from tests.scenarios.test_scenarios import is_complete
from vehicle_fmu import modes, motorcycles, over_speed, ridden

needs_studies = pytest.mark.skipif(find_spec("zarr") is None or find_spec("pyarrow") is None,
                                   reason="the extra motofmi[scale] is not installed")  # fmt: skip

PAGE = (ROOT / "docs" / "vehicles.md").read_text("utf-8")


@pytest.mark.slow
def test_the_page_shows_the_computed_rows():
    system = on_every_vehicle.systems("sharp_1994")[on_every_vehicle.OFF]
    found = {("sharp_1994", on_every_vehicle.OFF): modes(over_speed(system), on_every_vehicle.SPEEDS)}
    for line in on_every_vehicle.markdown(on_every_vehicle.table(found)).splitlines():
        assert line in PAGE


@pytest.mark.study
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


@pytest.mark.study
def test_the_findings_of_the_paper_are_on_the_page_with_what_is_missed():
    speeds = np.array([10.0, 30.0, 35.0, 60.0, 70.0])
    words = (of_freedoms.RIGID, "fork bending", "frame torsion", "rider lean", "rider slide")
    systems = of_freedoms.systems()
    found = {word: modes(over_speed(systems[word]), speeds) for word in words}
    shown = of_freedoms.findings(found)
    assert [row[-1] for row in shown.rows] == ["yes", "partly", "partly", "yes", "yes", "yes"]
    for row in shown.rows:
        assert f"| {row[0]} |" in PAGE


@pytest.mark.slow
def test_only_on_tyres_a_bicycle_has_a_wobble():
    found = of_bicycles.run(np.arange(2.0, 20.1, 2.0))
    knife, *on_tyres = found.values()
    assert "wobble" not in knife.unstable and all("wobble" in one.unstable for one in on_tyres)
    # Tyres of finite stiffness move the end of the unstable weave of the benchmark, 4.292 m/s, by little.
    assert knife.unstable["weave"][0][1] == pytest.approx(4.292, abs=0.01)
    assert all(one.unstable["weave"][0][1] == pytest.approx(4.292, abs=0.2) for one in on_tyres)
    assert is_complete(of_bicycles.section(found))


@pytest.mark.slow
def test_the_inertia_of_the_torso_is_what_the_passive_rider_has_besides_sharps_hands():
    found = of_hands.run(np.arange(40.0, 60.1, 5.0))
    weave, wobble = (of_hands.changes(found, mode) for mode in ("weave", "wobble"))
    # Both riders and Sharp's hands make wobble more stable and weave less; most with the inertia of the torso (2011,
    # Sect. 5).
    assert max(wobble.values()) < 0 < min(weave.values())
    assert weave[of_hands.RIDER] > 2 * max(weave[of_hands.LIGHT], weave[of_hands.HANDS])
    assert is_complete(of_hands.section(found))


@pytest.mark.slow
@needs_studies
def test_a_damper_serves_wobble_at_the_cost_of_weave():
    found = of_dampers.run(("sharp_1971",), np.array([0.0, 10.0, 20.0]), np.arange(20.0, 60.1, 5.0))
    off = found.least["sharp_1971", "none"]
    # Sharp 1971, and the 2011 paper, Fig. 14: steering damping stabilises wobble and makes weave less stable.
    assert (np.diff(off["wobble"]) > 0).all() and (np.diff(off["weave"]) < 0).all()
    damping, ratio = found.best("sharp_1971", "none")
    # So the best one is between: too little damping leaves wobble, too much of it weave.
    assert damping == 10.0 and ratio == min(off["weave"][1], off["wobble"][1])
    assert is_complete(of_dampers.section(found))


@pytest.mark.slow
@needs_studies
def test_shares_of_riders_that_weave_are_counted_from_their_modes():
    found = of_riders.run(("sharp_1971",), ("none", "damper:high_2011"), riders=8, speeds=np.arange(10.0, 60.1, 10.0))
    for pair, share in found.weaving.items():
        curve = found.over_speed[pair]
        # Each rider that weaves somewhere counts once: no less than at any one speed, no more than all speeds together.
        assert curve.max() <= share <= min(curve.sum(), 1.0)
        assert found.served[pair] == pytest.approx(1 - max(share, found.wobbling[pair]), abs=min(share, found.wobbling[pair]))
    assert found.weaving["sharp_1971", "none"] > 0  # 2011, Sect. 5: the mean rider makes it weave from 34 to 57 m/s
    assert found.best["sharp_1971"] in ("none", "damper:high_2011") and is_complete(of_riders.section(found))


@pytest.mark.slow
def test_weave_in_a_corner_is_on_the_page():
    found = of_corners.run(speeds=(50.0,), leans=np.array([0.0, 45.0]))
    assert is_complete(of_corners.section(found))
    off, rider = (found[words, 50.0] for words in of_corners.DEVICES)
    # In straight running the page says so at this speed; on suspensions the corner makes weave more stable.
    assert rider["weave"].eigenvalue.real[0] > 0 and (off["weave"].eigenvalue.real < 0).all()
    assert (np.diff(rider["weave"].eigenvalue.real) < 0).all() and (np.diff(off["weave"].eigenvalue.real) < 0).all()
    for row, cells in ((row, line.split(" | ")) for row in of_corners.table(found).rows for line in PAGE.splitlines()
                       if line.startswith(f"| {' | '.join(row[:3])} |")):  # fmt: skip
        assert cells[3] == row[3] and cells[-1].removesuffix(" |") == row[4]


@pytest.mark.slow
def test_suspensions_in_a_corner_are_on_the_page():
    found = of_suspensions.run(leans=np.array([0.0, 45.0]), accelerations=np.array([-2.0, 0.0]))
    assert is_complete(of_suspensions.section(found))
    rows = {tuple(line.split(" | ")[:2]): line.removesuffix(" |").split(" | ") for line in PAGE.splitlines()}
    for row in of_suspensions.table(found).rows:
        cells = rows[f"| {row[0]}", row[1]]
        assert [cells[2], cells[-1]] == row[2:]
    loads = found.over_acceleration["front_load"]
    assert loads[0] > loads[1] + 150  # N: load transfer by braking, mass 249 kg, height per wheelbase 0.4
