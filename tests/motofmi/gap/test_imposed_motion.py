"""The band in which an imposed motion is resolved from its noise, on motions of known spectrum."""

import numpy as np
import pytest
from scipy.interpolate import CubicSpline
from scipy.signal import butter, sosfiltfilt

from fmus.mechanisms.mass_spring_damper import MassSpringDamper
from motofmi.gap.experiments.input_output import input_output_experiment
from motofmi.gap.preprocessing.decimation import OVERSAMPLING_OF_MOTION
from motofmi.gap.preprocessing.input_interpolation import (
    ABOVE_NOISE,
    RESOLVED_RATIO,
    motion_functions,
    resolved_frequency,
)
from motofmi.gap.preprocessing.sampled_run_preparation import END_SHARE, prepare_sampled_run
from motofmi.recordings.recording import Recording

RATE, COUNT = 200.0, 8000
CORNER = 2.0  # Hz


def motion(noise, seed=0):
    """A displacement of rms 1 whose power falls as f^-8 beyond CORNER, with white noise; and its noise-free samples."""
    rng = np.random.default_rng(seed)
    frequency = np.fft.rfftfreq(COUNT, 1 / RATE)
    clean = np.fft.irfft(np.fft.rfft(rng.standard_normal(COUNT)) / (1 + (frequency / CORNER) ** 4), COUNT)
    clean /= clean.std()
    return clean + noise * rng.standard_normal(COUNT), clean


def crossing(noise, ratio):
    """The frequency [Hz] at which the power of `motion` is `ratio` times that of its noise."""
    frequency = np.linspace(0, RATE / 2, 20001)
    power = 1 / (1 + (frequency / CORNER) ** 4) ** 2
    power /= power.mean()  # noise of rms 1 has power 1 everywhere
    return frequency[np.flatnonzero(power > ratio * noise**2)[-1]]


@pytest.mark.parametrize("noise", [1e-2, 1e-3, 1e-4])
@pytest.mark.parametrize("ratio", [ABOVE_NOISE, RESOLVED_RATIO])
def test_a_motion_is_resolved_up_to_where_it_meets_its_noise(noise, ratio):
    """A power falling as f^-8 scatters by a factor of 2 where few frequencies are averaged: f by 2^(1/8)."""
    assert resolved_frequency(motion(noise)[0], RATE, ratio) == pytest.approx(crossing(noise, ratio), rel=0.2)


@pytest.mark.parametrize("cut_off", [80.0, 50.0])
def test_the_floor_of_low_passed_noise_is_its_level_below_the_cut_off(cut_off):
    noise = 1e-3
    filtered = sosfiltfilt(butter(4, cut_off, fs=RATE, output="sos"), motion(noise)[0])
    assert resolved_frequency(filtered, RATE) == pytest.approx(crossing(noise, ABOVE_NOISE), rel=0.2)


def test_a_line_beyond_the_motion_is_not_motion():
    """Mains interference with a thousand times the power of the noise around it."""
    time = np.arange(COUNT) / RATE
    noisy = motion(1e-3)[0] + 1e-3 * np.sin(2 * np.pi * 50 * time)
    assert resolved_frequency(noisy, RATE) == pytest.approx(crossing(1e-3, ABOVE_NOISE), rel=0.2)


def imposed(noise):
    """A mass of 2 kg with a damper whose displacement is recorded with noise."""
    noisy, clean = motion(noise)
    cycles = 2j * np.pi * np.fft.rfftfreq(COUNT, 1 / RATE)
    force = np.fft.irfft((2.0 * cycles**2 + 30.0 * cycles + 400.0) * np.fft.rfft(clean), COUNT)
    force += 1e-3 * force.std() * np.random.default_rng(9).standard_normal(COUNT)
    columns = {"displacement": noisy, "force": force}
    return Recording("run", np.arange(COUNT) / RATE, columns, {"displacement": "m", "force": "N"})


def test_the_compared_band_ends_where_the_imposed_motion_is_20_db_above_its_noise():
    test = input_output_experiment(MassSpringDamper(), ["displacement", "force"], "displacement")
    run = prepare_sampled_run(imposed(1e-3), test)
    assert run.reduction_band == pytest.approx(crossing(1e-3, RESOLVED_RATIO), rel=0.2)
    # Power that falls as f^-8 loses the 10 dB between both ratios over a factor 10^(1/8) in frequency
    assert run.reduction_band == pytest.approx(crossing(1e-3, ABOVE_NOISE) / 10 ** (1 / 8), rel=0.2)
    assert any("not resolved" in note for note in run.notes)


def test_the_compared_band_ends_with_the_measured_force_where_the_motion_is_resolved_further():
    noisy, exact = imposed(1e-9), imposed(1e-9)
    rng = np.random.default_rng(4)
    noisy.columns["force"] = exact["force"] + 0.1 * exact["force"].std() * rng.standard_normal(COUNT)
    test = input_output_experiment(MassSpringDamper(), ["displacement", "force"], "displacement")
    run = prepare_sampled_run(noisy, test)
    assert run.reduction_band < resolved_frequency(exact["displacement"], RATE, RESOLVED_RATIO) / 2
    assert not any("not resolved" in note for note in run.notes)


def test_a_recording_of_an_imposed_motion_is_decimated_by_the_band_in_which_it_is_compared():
    """At 4 kHz a force with noise up to 2 kHz, and a motion that is resolved up to some 10 Hz."""
    slow, factor = imposed(1e-3), 20
    time = np.arange(COUNT * factor) / (RATE * factor)
    rng = np.random.default_rng(2)
    columns = {n: CubicSpline(slow.time, y)(time) for n, y in imposed(0.0).columns.items()}
    columns = {n: y + 1e-3 * np.sqrt(factor) * y.std() * rng.standard_normal(len(time)) for n, y in columns.items()}
    fast = Recording("fast", time, columns, slow.units)
    test = input_output_experiment(MassSpringDamper(), ["displacement", "force"], "displacement")
    run, as_recorded = prepare_sampled_run(fast, test), prepare_sampled_run(slow, test)
    assert run.recording.rate < 15 * run.reduction_band and any("decimated" in note for note in run.notes)
    # The noise density is that of the slow recording, so the band is, too: f^-8 scatters as above.
    assert run.reduction_band == pytest.approx(as_recorded.reduction_band, rel=0.2)
    assert run.recording.rate >= OVERSAMPLING_OF_MOTION * run.reduction_band


def test_the_simulation_needs_no_steps_for_what_is_not_compared():
    """A force at 80 Hz beside a motion that is resolved up to some 10 Hz: eight steps per cycle were four per sample."""
    noisy, half = imposed(1e-3), COUNT // 2  # less than the samples from which a recording is decimated
    time = noisy.time[:half]
    columns = {n: y[:half] for n, y in noisy.columns.items()}
    columns["force"] = columns["force"] + 0.1 * columns["force"].std() * np.sin(2 * np.pi * 80 * time)
    test = input_output_experiment(MassSpringDamper(), ["displacement", "force"], "displacement")
    run = prepare_sampled_run(Recording("vibrating", time, columns, noisy.units), test)
    assert run.recording.rate == pytest.approx(RATE) and run.steps_per_sample == 1


@pytest.mark.parametrize(("samples", "accuracy"), [(12, 0.0025), (OVERSAMPLING_OF_MOTION, 0.015)])
def test_the_acceleration_of_an_imposed_motion_is_accurate_up_to_the_end_of_the_band(samples, accuracy):
    """A sine with so many samples per period; with 8 the knots are 4 per period, the error 1.4 % as documented."""
    time, omega = np.arange(4000.0), 2 * np.pi / samples
    middle = slice(400, -400)
    found = motion_functions(time, np.sin(omega * time + 0.3), "rate")["der(rate)"](time)[middle]
    true = -(omega**2) * np.sin(omega * time + 0.3)[middle]
    assert accuracy / 2 < np.std(found - true) / np.std(true) < accuracy


def test_the_noise_free_motion_is_that_of_the_recording_and_computed_once():
    """All copies of a run share the splines of its recording, which take a second each for 25,000 samples."""
    test = input_output_experiment(MassSpringDamper(), ["displacement", "force"], "displacement")
    recording, (_, clean) = imposed(1e-3), motion(1e-3)
    run = prepare_sampled_run(recording, test)
    copy = run.with_scaled_noise(4.0).cut(1000)
    assert copy.noiseless.inputs is run.noiseless.inputs
    assert copy.noiseless.with_interpolation(run.kind).inputs is run.inputs
    compared = slice(int(END_SHARE * COUNT), -int(END_SHARE * COUNT))
    found = copy.noiseless.inputs(recording.time)["displacement"]
    # Noise is left up to the frequency f at which the motion has ABOVE_NOISE times its power, and beyond it the motion is
    # lost, whose power falls as f^-8: of 100 Hz the shares f and ABOVE_NOISE f / 7.
    left = crossing(1e-3, ABOVE_NOISE) / (RATE / 2) * (1 + ABOVE_NOISE / 7)
    assert np.std((found - clean)[compared]) == pytest.approx(1e-3 * np.sqrt(left), rel=0.1)  # as the spectrum is smoothed
