"""The benchmark of public leaderboards: what is skipped, its scores on simulated tanks, and its table in the docs."""

from pathlib import Path

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from benchmarks.gap_leaderboard import BOARDS, entry, run, table

NOISE = 0.03  # V


def quiet(items, _):
    return items


def write_tanks(path: Path, seed: int) -> None:
    """500 samples of the documented tanks in the layout of the public recordings, with noise in the level."""
    rng, time = np.random.default_rng(seed), 4.0 * np.arange(500)
    pump = np.interp(time, 80.0 * np.arange(26), 1.5 + 2.5 * rng.random(26))

    def rates(t, x):
        upper, lower = np.sqrt(np.maximum(x, 1e-6))
        return [0.04 * np.interp(t, time, pump) - 0.045 * upper, 0.045 * upper - 0.04 * lower]

    made = solve_ivp(rates, (0, time[-1]), [5.0, 5.5], t_eval=time, max_step=4.0, rtol=1e-6)
    rows = np.column_stack([time, pump, made.y[1] + NOISE * rng.standard_normal(len(time))])
    np.savetxt(path, rows, delimiter=",", header="time [s],pump [V],level [V]", comments="")


def test_recordings_that_are_not_there_are_skipped_with_the_command_that_gets_them(tmp_path):
    found = run(quiet, data=tmp_path)
    assert set(found) == {"skipped"} and set(found["skipped"]) == set(BOARDS)
    for name, reason in found["skipped"].items():
        assert f"git clone https://github.com/{BOARDS[name].source.repository}" in reason and str(tmp_path) in reason


@pytest.mark.slow
def test_tanks_that_miss_nothing_are_predicted_within_the_noise(tmp_path):
    (tmp_path / "cascaded_tanks").mkdir()
    for seed, name in enumerate(("estimation", "validation")):
        write_tanks(tmp_path / "cascaded_tanks" / f"{name}.csv", seed)
    found = entry(BOARDS["cascaded tanks"], tmp_path)
    assert found["verdict"] == "none" and found["effects"] == []
    # Three coefficients, the offset of the pump and that of the level.
    assert found["fitted_numbers"] == 5
    score = found["tests"]["validation"]
    # The upper level at the beginning rests on 50 samples of the lower one, and decays within some 100 samples.
    assert 0.9 * NOISE < score["refitted"] < 1.3 * NOISE
    assert {"linear", "best", "target", "as_found"} < set(score)
    assert "none" in table({"boards": {"cascaded tanks": found}})
