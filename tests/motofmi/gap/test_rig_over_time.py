"""Rig runs that follow no swept or stepped sine: compared over time, with the same effects and the same files."""

import json

import numpy as np
import pytest
from scipy.fft import dct
from scipy.linalg import toeplitz

from fmus.support.errors import InputError
from motofmi.cli.main import main
from motofmi.gap.estimation.fitting import fit
from motofmi.gap.preprocessing.blocks import blocks_of
from motofmi.gap.preprocessing.input_interpolation import NOISELESS, motion_functions
from motofmi.gap.preprocessing.steer_test_run import prepare_steer_test_run
from motofmi.recordings.reading import write_recording
from motofmi.recordings.resampling import LEAST_SIGNAL, white_noise

pytest.importorskip("numba", reason="the simulator of the hidden effects is compiled by numba")
from tests.simulators.as_recordings import as_recording
from tests.simulators.hidden_rig import RIDER, Rig, record, sweep


def multisine(seed, amplitude=3.0, duration=45.0):
    """Angle (n,) of random phases at 76 frequencies from 0.4 to 10 Hz, faded in and out within a second."""
    rng = np.random.default_rng(seed)
    frequency, phase = np.arange(0.4, 10, 0.128), rng.uniform(0, 2 * np.pi, 75 + 1)

    def angle(t):
        fade = np.clip(np.minimum(t, duration - t), 0, 1.0)
        waves = sum(np.cos(2 * np.pi * f * t + p) for f, p in zip(frequency, phase[: len(frequency)], strict=True))
        return (
            np.radians(amplitude) * np.sqrt(2 / len(frequency)) / 1.6 * fade**3 * (10 - 15 * fade + 6 * fade**2) * waves
        )

    return angle, duration


def recorded(folder, hidden, *seeds):
    rng = np.random.default_rng(7)
    for seed in seeds:
        write_recording(
            as_recording(f"run_{seed}", record(multisine(seed), hidden, RIDER, rng, Rig())), folder / f"run_{seed}.csv"
        )
    (folder / "rig.json").write_text(
        json.dumps({"handlebar_inertia": {"value": 0.125, "standard_error": 0.00125, "unit": "kg.m2"}})
    )


@pytest.mark.slow
@pytest.mark.study
def test_a_head_is_found_in_a_multisine(tmp_path, monkeypatch):
    recorded(tmp_path, {"Ih": 0.06, "fh": 4.2, "zh": 0.3}, 1, 2)
    monkeypatch.chdir(tmp_path)
    assert main(["gap", "run_1.csv", "--holdout", "run_2.csv", "--out", "gap"]) == 0
    result = json.loads((tmp_path / "gap" / "verdict.json").read_text())
    assert (result["verdict"], [e["name"] for e in result["effects"]]) == ("named", ["extra_mode"])
    found = result["effects"][0]["parameters"]
    assert found["frequency"]["value"] == pytest.approx(4.2, abs=3 * found["frequency"]["standard_error"])
    assert result["gap"]["holdout_after"] == pytest.approx(
        1.0, abs=0.15
    )  # 1,200 cosines scatter by 0.04, their noise is a flexible model's
    assert result["gap"]["holdout_before"] > 2
    assert any("no swept or stepped sine" in sentence for sentence in result["limitations"])
    for file in (result["model"], result["fmu"], result["report"]):
        assert (tmp_path / "gap" / file).exists()


@pytest.mark.study
@pytest.mark.usefixtures("without_compiler")
def test_nothing_is_found_in_a_multisine_where_nothing_is_hidden(tmp_path, monkeypatch):
    recorded(tmp_path, {}, 3)
    monkeypatch.chdir(tmp_path)
    assert main(["gap", "run_3.csv", "--out", "gap"]) == 0
    result = json.loads((tmp_path / "gap" / "verdict.json").read_text())
    assert (result["verdict"], result["fmu"]) == ("none", None) and (tmp_path / "gap" / result["model"]).exists()
    (said,) = (s for s in result["limitations"] if "FMU" in s)
    assert said.startswith("No FMU was built: no C compiler")


@pytest.mark.slow
def test_a_sweep_that_is_sampled_coarsely_is_no_noise():
    """Fourth differences take a sine near the sampling rate for noise; what lies beside the harmonics is what
    counts."""
    arrays = record(sweep(8, 12, 2, 60.0), {}, RIDER, np.random.default_rng(0), Rig(rate=40))
    run = as_recording("run", arrays)
    assert np.std(run["steer_angle"]) < LEAST_SIGNAL * white_noise(run["steer_angle"])
    assert prepare_steer_test_run(run, "steer_angle", "steer_torque", "steer_angle_command").reduction.columns


@pytest.mark.slow
@pytest.mark.parametrize(("motion", "message"), [(1.0, "no swept or stepped sine"), (1e-4, "no excitation")])
def test_another_motion_and_no_excitation_have_different_messages(motion, message):
    run = as_recording("run", record(multisine(5, motion), {}, RIDER, np.random.default_rng(0), Rig()))
    with pytest.raises(InputError, match=message):
        prepare_steer_test_run(run, "steer_angle", "steer_torque", "steer_angle_command")


def test_the_variance_of_a_cosine_is_that_of_its_noise():
    """Noise that falls steeply leaks into the cosines beyond; the covariance matrix, transformed, says by how much."""
    n, rate = 160, 128.0

    def density(f):
        return 0.01 + np.where(f < 10, 1.0, 0.0) + 5 / (1 + (f / 2) ** 4)

    made = blocks_of([(0, n)], 1, rate, rate).deviations([density]) ** 2
    covariance = toeplitz(np.fft.irfft(density(np.fft.rfftfreq(4 * n, 1 / rate)))[:n])
    transform = dct(np.eye(n), axis=0, norm="ortho")
    np.testing.assert_allclose(
        made, np.diag(transform @ covariance @ transform.T)[: len(made)], rtol=1e-9
    )  # rounding of sums of 160


def test_a_noiseless_motion_is_that_without_its_noise():
    time = np.arange(0, 30, 1 / 128)
    motion = multisine(4, duration=30.0)[0](time)
    noisy = motion + 5e-4 * np.random.default_rng(0).standard_normal(len(time))
    h = 1e-3
    before, after = (multisine(4, duration=30.0)[0](time + step) for step in (-h, h))
    acceleration = (after - 2 * motion + before) / h**2  # right to (w h)^2 / 12 = 3e-4
    inside = slice(128, -128)
    error = {
        kind: np.std(motion_functions(time, noisy, "rate", kind)["der(rate)"](time)[inside] - acceleration[inside])
        for kind in ("smooth", NOISELESS)
    }
    # Noise of 5e-4 up to 10 Hz alone is 5e-4 sqrt(10 / 64) (2 pi 10)^2 / sqrt(5) = 0.35 rad/s2; the ends of the record
    # add to it
    assert error[NOISELESS] < 0.8 < 2 < error["smooth"]


def test_a_step_that_reaches_its_bounds_goes_on():
    """Each parameter cut to its own reach may lead uphill: the whole step is then shortened, and the fit goes on."""

    class Valley:
        """chi-square of two parameters that almost make up for each other, far from the start."""

        base, own, names, sizes, effects = [], ["a", "b"], ["a", "b"], [], ()
        magnitudes = np.zeros(0), np.zeros(0)

        def __init__(self):
            rows = {n: type("Row", (), {"min": 0.0, "max": 1e6})() for n in self.own}
            self.component = type("Component", (), {"table": rows})()
            self.rows = list(rows.values())
            self.experiment = type("Stand", (), {"free": (), "measured_effects": {}})()

        def reduced(self, run, q):
            matrix = 1e3 * np.array([[1.0, 1.0], [0.0, 0.01]])
            return matrix @ q, matrix

    run = type("Run", (), {"data": np.array([21.0, 0.2]), "deviation": np.full(2, 1e-3)})()  # a = 1, b = 20
    found = fit(Valley(), [run], np.array([20.0, 1.0]), iterations=60)
    np.testing.assert_allclose(found.x, [1.0, 20.0], rtol=0.05)
