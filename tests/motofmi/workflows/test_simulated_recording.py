"""A simulated steer test in a file: what is identified from it is the rider that was simulated."""

import numpy as np
import pytest

import motofmi as mf
from fmus.support.errors import InputError
from motofmi.recordings.reading import read_recording


@pytest.mark.slow
def test_the_rider_of_a_recording_is_found_again(tmp_path):
    rider = mf.rider("5_2011")
    path = mf.simulate_steer_test(rider, tmp_path / "sweep.csv", duration=60, seed=1)
    found = mf.identify(mf.estimate_frf([path])).parameters
    # The standard errors of one run are up to 0.2 %.
    for name in ("torso_inertia", "arm_stiffness"):
        assert found[name]["value"] == pytest.approx(rider.values[name], rel=0.01)


@pytest.mark.parametrize(("excitation", "largest"), [("sweep", 2.0), ("stepped_sine", 2.0), ("multisine", 2.0)])
def test_every_excitation_has_its_amplitude_and_duration(excitation, largest, tmp_path):
    run = read_recording(mf.simulate_steer_test("rider:mean_2011", tmp_path / "run.csv", excitation=excitation, duration=34.0))
    assert np.degrees(np.abs(run.columns["steer_angle_command"]).max()) == pytest.approx(largest, rel=0.02)
    assert run.time[-1] == pytest.approx(36.0, abs=0.1)


@pytest.mark.parametrize(("given", "message"), [
    ({"excitation": "hammer"}, "unknown excitation 'hammer'"), ({"duration": 5.0}, "duration = 5 is not possible (valid: from 10)"),
    ({"amplitude": 0.0}, "amplitude = 0 is not possible (valid: above 0)"), ({"rider": "sharp_1971"}, "rider"),
])  # fmt: skip
def test_what_is_not_possible_is_refused_before_a_file_is_written(given, message, tmp_path):
    with pytest.raises(InputError, match=message.replace("(", r"\(").replace(")", r"\)")):
        mf.simulate_steer_test(**{"rider": "mean_2011", "path": tmp_path / "run.csv", **given})
    assert not list(tmp_path.iterdir())
