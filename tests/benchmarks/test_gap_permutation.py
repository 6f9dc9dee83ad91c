"""The benchmark of permuted residuals: what is permuted, what is skipped, and that it names nothing on a simulated swing."""

import numpy as np
import pytest

from benchmarks._null_comparison import permuted
from benchmarks.gap_permutation import STUDIED, run
from motofmi.gap.comparison.block_losses import correlation_length
from tests.simulators.hidden_joint import joint_run


def quiet(items, _):
    return items


def test_permuted_residuals_keep_their_moduli_and_lose_their_order():
    noise = np.random.default_rng(1).normal(size=2000)
    left = np.convolve(noise, np.exp(-np.arange(40) / 10), "same")[:, None]
    other = permuted(left, np.random.default_rng(2))
    assert np.allclose(np.sort(np.abs(other), axis=0), np.sort(np.abs(left), axis=0))
    # Of 2000 / 40 independent stretches, a correlation has the standard deviation 0.14.
    assert abs(np.corrcoef(left[:, 0], other[:, 0])[0, 1]) < 0.5
    assert correlation_length(other[:, 0]) > 10  # the decay of the filter: blocks keep it


def test_recordings_that_are_not_there_are_skipped_with_the_command_that_gets_them(tmp_path):
    found = run(quiet, trials=3, data=tmp_path, out=tmp_path / "out")
    assert found["trials"] == 0 and set(found["skipped"]) == set(STUDIED)
    assert all("git clone https://github.com/" in reason and ".csv" in reason for reason in found["skipped"].values())
    assert all(str(tmp_path) in reason for reason in found["skipped"].values())


@pytest.mark.study
def test_the_residuals_of_a_swing_with_friction_name_nothing_once_permuted(tmp_path):
    folder = tmp_path / "pendulum_camera"
    folder.mkdir()
    for seed, name, start in ((1, "pendulum_first", 0.9), (2, "pendulum_second", 0.8)):
        swing = joint_run({"friction": 0.15}, "decay", seed, noise=1e-3, duration=5.0, start=(start, 0.0))
        rows = np.column_stack([swing.time, swing["angle"]])
        np.savetxt(folder / f"{name}.csv", rows, delimiter=",", header="time [s],angle [rad]", comments="")
    found = run(quiet, trials=4, data=tmp_path, out=tmp_path / "out", sources=["filmed pendulum"])
    assert found["false_names"]["rate"] == 0 and found["false_names"]["trials"] == 4
    assert run(quiet, trials=4, data=tmp_path, out=tmp_path / "out", sources=["filmed pendulum"]) == found
