"""The roll test: the estimate against the exact transfer function, a rigid rider, and the published features."""

import json
from functools import lru_cache

import numpy as np
import pytest

from fmus import linearise
from fmus.errors import InputError
from fmus.published import table
from identification.recordings import write_recording
from identification.roll import POINTS, RollFRF, check_features, roll_frf
from rider_fmu import FEATURES, RollRider
from scenarios.command_line import main
from scenarios.virtual_rig import roll_test

RIDER = RollRider("rider")
HEIGHTS = {point: RIDER.values[f"{point}_height"] for point in ("mockup", *POINTS)}


@lru_cache
def noisy():
    return roll_test(seed=1)


def exact(frequency, rider=RIDER):
    space = linearise(rider)
    return {point: space.frequency_response(2 * np.pi * frequency, f"{point}_acceleration", "roll_acceleration") / rider.values[f"{point}_height"]
            for point in POINTS}  # fmt: skip


def test_estimate_is_the_exact_ratio():
    recording, levels = roll_test(accelerometer_noise=0.0)
    found = roll_frf(recording, HEIGHTS, levels)
    for point, curve in exact(levels).items():
        # an average over 0.15 Hz of a resonance 0.8 Hz wide
        np.testing.assert_allclose(found.absolute[point], curve, atol=0.02)
        np.testing.assert_allclose(found.relative[point], found.absolute[point] - 1)


def test_order_of_the_frequencies_does_not_matter_but_is_random():
    (first, levels), (second, _) = noisy(), roll_test(seed=2)
    assert np.abs(first["waist_acceleration"] - second["waist_acceleration"]).max() > 0.1
    for point in POINTS:
        a, b = (roll_frf(r, HEIGHTS, levels).absolute[point] for r in (first, second))
        # accelerometer noise of 0.01 m/s2 on 0.1 m/s2 at 0.5 Hz, 20 s each
        np.testing.assert_allclose(a, b, atol=0.05)


def test_a_rigid_rider_moves_with_the_mockup():
    rigid = RIDER.with_values(saddle_stiffness=1e6, bending_stiffness=1e6, neck_stiffness=1e6)
    for curve in exact(np.array([0.5, 1.0, 2.0]), rigid).values():
        # stiffnesses of 1e6 N/m on 66 kg give way by m w^2 / k
        np.testing.assert_allclose(curve, 1, atol=3 * 66 * (4 * np.pi) ** 2 / 1e6)


def test_published_features():
    """All that the 2008 paper prints but the head's second peak, which it suspects to be voluntary."""
    recording, levels = noisy()
    features = check_features(roll_frf(recording, HEIGHTS, levels), table(FEATURES))
    assert len(features) == 14
    assert [(f.point, f.feature) for f in features if not f.met] == [(4, "peaks_below")]


def test_features_are_missed_by_a_rider_who_is_no_isolator():
    levels = np.arange(0.5, 7.01, 0.25)
    rigid = RollFRF(levels, {point: np.ones(len(levels), complex) for point in POINTS})
    assert sum(f.met for f in check_features(rigid, table(FEATURES))) <= 2  # it decreases nowhere, so nothing rises either


def test_missing_height_is_named():
    recording, levels = noisy()
    with pytest.raises(InputError, match="height of waist"):
        roll_frf(recording, {"mockup": 0.5}, levels)


def test_command(tmp_path, capsys):
    recording, _ = noisy()
    write_recording(recording, tmp_path / "roll.csv")
    rig = {f"{point}_height": {"value": height, "unit": "m"} for point, height in HEIGHTS.items()}
    (tmp_path / "rig.json").write_text(json.dumps(rig))
    plot = tmp_path / "roll.png"
    assert main(["frf", str(tmp_path / "roll.csv"), "--json", str(tmp_path / "roll.json"), "--plot", str(plot), "--report", str(tmp_path / "roll.html")]) == 0
    result = json.loads((tmp_path / "roll.json").read_text())
    assert set(result["frf"]) == set(POINTS) and len(result["frequency"]) == 27
    assert plot.stat().st_size > 10_000 and "Roll test" in (tmp_path / "roll.html").read_text()
    assert "NOT met" in capsys.readouterr().out
