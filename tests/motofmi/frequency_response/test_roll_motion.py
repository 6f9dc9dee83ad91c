"""The roll test: the estimate against the exact transfer function, a rigid rider, and the command with the published features."""

import json
from functools import lru_cache

import numpy as np
import pytest

from fmus.support.errors import InputError
from motofmi.cli.main import main
from motofmi.frequency_response.roll_motion import roll_frf
from motofmi.recordings.channels import BODY_POINTS
from motofmi.recordings.reading import write_recording
from motofmi.virtual_rig.simulated_rig import roll_test
from rider_fmu import riders
from rider_fmu.components.rider_in_roll import point_heights
from rider_fmu.roll_features import roll_frf as exact

RIDER = riders.load("roll_3_2008")
HEIGHTS = {"mockup": 0.5, **point_heights(RIDER)}


@lru_cache
def noisy():
    return roll_test(seed=1)


@pytest.mark.slow
def test_estimate_is_the_exact_ratio():
    recording, levels = roll_test(accelerometer_noise=0.0)
    found = roll_frf(recording, HEIGHTS, levels)
    for point, curve in exact(RIDER, levels).items():
        # an average over 0.15 Hz of resonances that are a few tenths of a hertz wide
        np.testing.assert_allclose(found.absolute[point], curve, atol=0.02 * np.abs(curve).max())
        np.testing.assert_allclose(found.relative[point], found.absolute[point] - 1)


@pytest.mark.slow
def test_order_of_the_frequencies_is_random_and_does_not_matter():
    (first, levels), (second, _) = noisy(), roll_test(seed=2)
    assert np.abs(first["waist_acceleration"] - second["waist_acceleration"]).max() > 0.1
    for point in BODY_POINTS:
        a, b = (roll_frf(r, HEIGHTS, levels).absolute[point] for r in (first, second))
        # accelerometer noise of 0.01 m/s2 on 0.1 m/s2 at 0.5 Hz, 20 s each
        np.testing.assert_allclose(a, b, atol=0.06)


@pytest.mark.slow
def test_a_rigid_rider_moves_with_the_mockup():
    rigid = RIDER.with_values(saddle_stiffness=1e6, lean_stiffness=1e6, neck_roll_stiffness=1e5)
    recording, levels = roll_test(rigid, np.array([0.5, 1.0, 2.0]), accelerometer_noise=0.0)
    for curve in roll_frf(recording, HEIGHTS, levels).absolute.values():
        # 50 kg on 1e6 N/m give way by m (w^2 + g/h) / k, 1 % at most
        np.testing.assert_allclose(curve, 1, atol=0.02)


@pytest.mark.slow
def test_missing_height_is_named():
    recording, levels = noisy()
    with pytest.raises(InputError, match="height of waist"):
        roll_frf(recording, {"mockup": 0.5}, levels)


@pytest.mark.slow
def test_command(tmp_path, capsys):
    recording, _ = noisy()
    write_recording(recording, tmp_path / "roll.csv")
    rig = {f"{point}_height": {"value": height, "unit": "m"} for point, height in HEIGHTS.items()}
    (tmp_path / "rig.json").write_text(json.dumps(rig))
    plot = tmp_path / "roll.png"
    assert (
        main(
            [
                "frf",
                str(tmp_path / "roll.csv"),
                "--json",
                str(tmp_path / "roll.json"),
                "--plot",
                str(plot),
                "--report",
                str(tmp_path / "roll.html"),
            ]
        )
        == 0
    )
    result = json.loads((tmp_path / "roll.json").read_text())
    assert set(result["frf"]) == set(BODY_POINTS) and len(result["frequency"]) == 27
    # the test, its noise and the estimator between the rider and the features: at most three of the fourteen are lost
    assert len(result["features"]) == 14 and sum(f["met"] for f in result["features"]) >= 11
    assert plot.stat().st_size > 10_000 and "Roll test" in (tmp_path / "roll.html").read_text()
    assert "printed" in capsys.readouterr().out
