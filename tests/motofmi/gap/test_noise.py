"""The noise that a verdict rests on: what a reconstructed motion brings of it, and whether the truth leaves a reduced chi-square of 1."""

import numpy as np
import pytest

from motofmi.gap.estimation.fitting import fit
from motofmi.gap.models.harmonic_model import HarmonicModel
from motofmi.gap.preprocessing.excitation_phase import phase_of
from motofmi.gap.preprocessing.harmonics import noise_of, reduction_of, variance_of
from motofmi.gap.preprocessing.reconstructed_motion import motion_reconstruction
from motofmi.gap.preprocessing.steer_test_run import prepare_steer_test_run
from motofmi.recordings.recording import Recording
from motofmi.workflows.gap.rig import rig_experiment
from tests import as_study
from tests.simulators.hidden_rig import RIDER, Rig, record, stepped, sweep

INERTIA, DAMPING, STIFFNESS = 0.2, 1.5, 60.0
RATE, DURATION = 128.0, 120.0
UNITS = {"steer_angle_command": "rad", "steer_angle": "rad", "steer_torque": "N.m"}


def swept():
    """Time, angle and the torque of an oscillator moved by it, whose rates are exact."""
    time = np.arange(0, DURATION, 1 / RATE)
    w, a = 2 * np.pi * (0.5 + 9.5 * time / DURATION), 2 * np.pi * 9.5 / DURATION
    phi = 2 * np.pi * (0.5 * time + 4.75 * time**2 / DURATION)
    angle, rate, acceleration = np.sin(phi), w * np.cos(phi), a * np.cos(phi) - w**2 * np.sin(phi)
    return time, 0.04 * angle, 0.04 * (INERTIA * acceleration + DAMPING * rate + STIFFNESS * angle)


@pytest.mark.slow
def test_the_error_of_a_rebuilt_motion_is_that_of_many_rebuilt_ones():
    time, angle, _ = swept()
    phase = phase_of(angle, RATE)
    reduction, reconstruction = reduction_of(phase, RATE), motion_reconstruction(time, phase)
    first = np.array([c.order == 1 for c in reduction.columns])
    said = reconstruction.response_variance(reduction.bases, lambda order: np.full(len(time), 2j))[first]
    rng = np.random.default_rng(1)
    draws = [reconstruction.motion(rng.standard_normal(len(time))) for _ in range(60)]
    responses = [2 * reduction.reduce(m(time)[0])[first] for m in draws]  # the phase of the answer changes no variance
    seen = np.mean(np.square(responses), axis=0)
    degree = np.array([c.degree for c in reduction.columns])[first]
    for each in (0, 1):
        # 60 draws of some 100 columns, whose errors are shared by half as many splines: 2 to 3 % of scatter.
        assert seen[degree == each].mean() / said[degree == each].mean() == pytest.approx(1.0, abs=0.08)


@pytest.mark.slow
def test_the_error_of_a_motion_that_has_no_command_counts_what_its_own_phase_brings():
    """A phase finer than the splines of the motion left three times the error that was said, in the slopes over a
    window."""
    angle, duration = sweep(1.0, 10.0, 2.0, 200.0)
    time, said, seen, rng = np.arange(0.125, duration, 1 / 64), [], [], np.random.default_rng(4)
    for _ in range(8):
        measured = angle(time) + 7e-4 * rng.standard_normal(len(time))
        phase = phase_of(measured, 64.0, noisy=True)
        reduction, reconstruction = reduction_of(phase, 64.0), motion_reconstruction(time, phase)
        slopes = np.array([c.order == 1 and c.degree == 1 and 2 < c.frequency < 9 for c in reduction.columns])
        said.append(7e-4**2 * reconstruction.response_variance(reduction.bases, lambda order: np.ones(len(time)))[slopes])
        seen.append(reduction.reduce(reconstruction.motion(measured)(time)[0] - angle(time))[slopes] ** 2)
    # 8 runs of some 100 columns, whose errors are shared by half as many splines: 7 % of scatter.
    assert np.mean([np.mean(a / b) for a, b in zip(seen, said, strict=True)]) == pytest.approx(1.0, abs=0.25)


@pytest.mark.slow
@pytest.mark.parametrize("angle_noise", [0.0, as_study(1e-3)])
def test_the_truth_leaves_a_chi_square_of_one_in_every_kind_of_column(angle_noise):
    time, angle, torque = swept()
    rng = np.random.default_rng(2)
    squares: dict[tuple[int, int], list[float]] = {}
    for _ in range(12):
        columns = {"steer_angle_command": angle, "steer_angle": angle + (angle_noise + 1e-7) * rng.standard_normal(len(time)),
                   "steer_torque": torque + 0.2 * rng.standard_normal(len(time))}  # fmt: skip
        run = prepare_steer_test_run(
            Recording("truth", time, columns, UNITS), "steer_angle", "steer_torque", "steer_angle_command"
        )
        x, v, a = run.motion(time)
        left = (run.data - run.reduction.reduce(INERTIA * a + DAMPING * v + STIFFNESS * x)) / run.deviation
        for column, z in zip(run.reduction.columns, left, strict=True):
            squares.setdefault((min(column.order, 2), column.degree), []).append(z**2)
    for kind, values in squares.items():
        # 12 runs of about 100 columns scatter by 0.04; those of order 1 share the noise of splines.
        assert np.mean(values) == pytest.approx(1.0, abs=0.16), kind
    assert set(squares) == {(1, 0), (1, 1), (2, 0)}


@pytest.mark.slow
@pytest.mark.parametrize("dwell", [8.0, 10.0])
@pytest.mark.parametrize("lag", [0.016, 0.1])
def test_a_servo_that_lags_behind_a_stepped_command_leaves_a_chi_square_of_one(lag, dwell):
    """Its phase against the command's jumps where the frequency steps; a spline that cannot follow rings on into the
    windows."""
    rig = Rig(rate=200, bits=16, lag=lag, angle_noise=2e-4, torque_noise=0.1, remnant=0.1)
    time, *columns, _ = record(stepped(0.5, 8.5, 0.5, 4, dwell), {}, RIDER, np.random.default_rng(1), rig)
    run = prepare_steer_test_run(
        Recording("stepped", time, dict(zip(UNITS, columns, strict=True)), UNITS),
        "steer_angle",
        "steer_torque",
        "steer_angle_command",
    )
    model = HarmonicModel(rig_experiment({}))
    # 272 numbers scatter by 0.086; a ringing spline left 1.3 to 83.
    assert fit(model, [run], model.start()).reduced == pytest.approx(1.0, abs=0.25)


@pytest.mark.parametrize("first, last, duration", [(10.0, 0.3, 80.0), (0.3, 15.0, 100.0)])
def test_the_motion_of_a_fast_logarithmic_sweep_is_rebuilt_behind_a_servo_that_lags(first, last, duration):
    """Its phase bends more at 10 Hz than splines of a slow phase follow: without any noise a thousandth of the angle
    was amiss."""
    angle, _ = sweep(first, last, 3.0, duration, logarithmic=True)
    time = np.arange(0, duration, 1 / 250)
    phase, measured = phase_of(angle(time), 250.0), angle(time - 0.047)
    rebuilt = motion_reconstruction(time, phase).motion(measured)(time)[0]
    inner = [(a, b) for a, b in phase.windows[1:-1] if phase.frequency[a] > 2.0]
    # 2e-5 of this motion, which is 37 mrad (rms), is a tenth of what splines leave of 0.01 deg of noise; next to the
    # ends the analytic signal swings.
    assert max(np.std((rebuilt - measured)[a:b]) for a, b in inner[3:-3]) < 2e-5 * np.std(measured)


@pytest.mark.slow
@pytest.mark.parametrize("column", ["steer_angle", "steer_torque"])
def test_a_sensor_s_offset_and_drift_are_not_compared(column):
    time, angle, torque = swept()
    rng = np.random.default_rng(4)
    columns = {"steer_angle_command": angle, "steer_angle": angle + 1e-4 * rng.standard_normal(len(time)),
               "steer_torque": torque + 0.1 * rng.standard_normal(len(time))}  # fmt: skip
    shifted = columns | {column: columns[column] + np.ptp(columns[column]) * (1 + time / DURATION)}
    responses = []
    for each in (columns, shifted):
        run = prepare_steer_test_run(
            Recording("truth", time, each, UNITS), "steer_angle", "steer_torque", "steer_angle_command"
        )
        x, v, a = run.motion(time)
        responses.append((run.data - run.reduction.reduce(INERTIA * a + DAMPING * v + STIFFNESS * x)) / run.deviation)
    # A line is among what every window leaves out; the spline of the motion takes it up to the ridge that keeps it
    # tame.
    assert responses[1] == pytest.approx(responses[0], abs=1e-2)


@pytest.mark.slow
def test_a_fast_recording_is_compared_at_the_rate_that_its_harmonics_need():
    rig = Rig(rate=1000, bits=16, angle_noise=2e-4, torque_noise=0.3, remnant=0.1)
    time, *columns, _ = record(sweep(0.5, 8, 2, 60.0), {}, RIDER, np.random.default_rng(2), rig)
    columns[2] += 40.0
    run = prepare_steer_test_run(
        Recording("fast", time, dict(zip(UNITS, columns, strict=True)), UNITS),
        "steer_angle",
        "steer_torque",
        "steer_angle_command",
    )
    assert run.recording.rate == pytest.approx(250) and any("250 Hz" in note for note in run.notes)
    model = HarmonicModel(rig_experiment({}))
    # Some 300 numbers scatter by 0.08
    assert fit(model, [run], model.start()).reduced == pytest.approx(1.0, abs=0.25)


@pytest.mark.slow
def test_a_burst_over_slow_harmonics_raises_their_noise():
    """At 0.5 Hz harmonics leave three lines below 3 Hz: that a burst is there shows above them only."""
    angle, duration = stepped(0.5, 4.0, 0.5, 2.0, 10.0)
    time = np.arange(0, duration, 1 / RATE)
    phase = phase_of(angle(time), RATE)
    reduction, rng = reduction_of(phase, RATE), np.random.default_rng(5)
    first, last = phase.windows[0]
    raised = []
    for _ in range(60):
        noise = rng.standard_normal(len(time))
        at = rng.integers(first, last - int(2 * RATE))
        noise[at : at + int(2 * RATE)] *= 5
        raised.append(noise_of(reduction, noise).of_window(0, np.array([1.0]))[0])
    true = 1 + (5**2 - 1) * 2 * RATE / (last - first)
    # Three lines with two numbers each scatter by 0.6, and count for less than half.
    assert np.mean(raised) == pytest.approx(true, rel=0.15) and min(raised) > 0.3 * true


@pytest.mark.slow
@pytest.mark.parametrize("burst", [0.0, 8.0])
def test_a_burst_at_a_window_s_end_raises_its_noise_as_much_as_one_within(burst):
    """One taper is nothing at the ends: an estimate of the noise of slow harmonics does not locate bursts."""
    time = np.arange(0, DURATION, 1 / RATE)
    phase = phase_of(np.sin(2 * np.pi * (0.5 * time + 4.75 * time**2 / DURATION)), RATE)
    reduction, rng, n, raised = reduction_of(phase, RATE), np.random.default_rng(6), int(RATE / 2), []
    first, last = phase.windows[5]
    for at in (first, (first + last - n) // 2, last - n):
        noise = rng.standard_normal((20, len(time)))
        noise[:, at : at + n] *= np.sqrt(1 + burst**2)
        raised.append(np.mean([noise_of(reduction, each).of_window(5, np.array([40.0])) for each in noise]))
    # A burst of 64 numbers in 20 records scatters by 0.04; five tapers are blind at the last tenth of 0.5 s still. One
    # of them alone would see four tenths. What is not clear counts as 1.
    assert raised == pytest.approx([1 + burst**2 * n / (last - first)] * 3, rel=0.35)


@pytest.mark.slow
def test_the_variance_of_a_white_burst_over_decaying_remnant_is_right_at_every_order():
    """The remnant is larger than the burst at 4 Hz; at 40 Hz the burst is 25 times the noise. One factor for both left
    a chi-square of 3 in its window."""
    time = np.arange(0, DURATION, 1 / RATE)
    phase = phase_of(np.sin(2 * np.pi * (0.5 * time + 4.75 * time**2 / DURATION)), RATE)
    reduction, f, rng, chi2 = (
        reduction_of(phase, RATE),
        np.fft.rfftfreq(len(time), 1 / RATE),
        np.random.default_rng(9),
        [],
    )
    first, last = phase.windows[20]
    inside = [i for i, c in enumerate(reduction.columns) if c.window == 20]
    for _ in range(40):
        slow = np.fft.irfft(np.fft.rfft(rng.standard_normal(len(time))) / (1 + (f / 2) ** 2), len(time))
        noise = 0.75 * slow / slow.std() + 0.09 * rng.standard_normal(len(time))
        noise[first : last - 40] += 0.45 * rng.standard_normal(last - 40 - first)
        chi2.append(reduction.reduce(noise)[inside] ** 2 / variance_of(reduction, noise_of(reduction, noise))[inside])
    # 40 windows of 16 numbers scatter by 0.06, and so does the estimate of each burst.
    assert np.mean(chi2) == pytest.approx(1.0, abs=0.25)


@pytest.mark.slow
def test_a_sensor_that_shakes_for_half_of_the_run_leaves_the_slow_noise_known():
    """Above 12 Hz alone: what a white burst would bring is not there below, and windows without it say what is."""
    time = np.arange(0, DURATION, 1 / RATE)
    reduction = reduction_of(phase_of(np.sin(2 * np.pi * (0.5 * time + 4.75 * time**2 / DURATION)), RATE), RATE)
    white = np.random.default_rng(8).standard_normal(len(time))
    fast = np.fft.irfft(np.fft.rfft(white) * (np.fft.rfftfreq(len(time), 1 / RATE) > 12), len(time))
    noise = 0.05 * white + 3 * fast * (time > DURATION / 2)
    known = noise_of(reduction, noise)
    assert known.density.min() == pytest.approx(
        0.05**2, rel=0.3
    )  # of 24 bands, the least of which rests on some 30 lines
    # Below 12 Hz too much is expected where it shakes, a quarter of the numbers.
    assert 0.7 < np.mean(reduction.reduce(noise) ** 2 / variance_of(reduction, known)) < 1.1


@pytest.mark.slow
def test_large_slow_noise_is_not_attributed_to_the_fast_harmonics():
    """Remnant below 2 Hz leaks from the ends of a window as 1 / f: without a taper the mean is 0.8."""
    time = np.arange(0, DURATION, 1 / RATE)
    reduction = reduction_of(phase_of(np.sin(2 * np.pi * (0.5 * time + 4.75 * time**2 / DURATION)), RATE), RATE)
    f, rng, chi2 = np.fft.rfftfreq(len(time), 1 / RATE), np.random.default_rng(8), []
    for _ in range(40):
        slow = np.fft.irfft(np.fft.rfft(rng.standard_normal(len(time))) / (1 + (f / 2) ** 2), len(time))
        noise = slow / slow.std() + 0.02 * rng.standard_normal(len(time))
        chi2.append(np.mean(reduction.reduce(noise) ** 2 / variance_of(reduction, noise_of(reduction, noise))))
    # 40 runs of about 700 numbers each scatter by 0.01; bands join a steep spectrum by straight lines.
    assert np.mean(chi2) == pytest.approx(1.0, abs=0.06)
