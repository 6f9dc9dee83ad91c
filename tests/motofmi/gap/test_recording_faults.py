"""Recordings as rigs make them: corners of a sweep, mains in the wires, gaps in the log."""

import numpy as np
import pytest
from scipy.signal import butter, lfilter

pytest.importorskip("numba", reason="the simulator of the hidden effects is compiled by numba")
from fmus.mechanisms import DrivenJoint
from motofmi.gap.estimation.fitting import fit
from motofmi.gap.experiments.input_output import input_output_experiment
from motofmi.gap.models.free_initial_state import FreeInitialStateModel
from motofmi.gap.models.harmonic_model import HarmonicModel
from motofmi.gap.preprocessing.mains_interference import without_mains_interference
from motofmi.gap.preprocessing.sampled_run_preparation import prepare_sampled_run
from motofmi.gap.preprocessing.steer_test_run import prepare_steer_test_run
from motofmi.gap.preprocessing.undisturbed_intervals import undisturbed
from motofmi.gap.selection.result import Verdict
from motofmi.recordings.recording import Recording
from motofmi.recordings.resampling import white_noise
from motofmi.reports.gap_component import pictures
from motofmi.workflows.gap.rig import rig_experiment
from tests.simulators.hidden_joint import joint_run
from tests.simulators.hidden_rig import RIDER, Rig, record, sweep

UNITS = {"steer_angle_command": "rad", "steer_angle": "rad", "steer_torque": "N.m"}


def recorded(excitation=None, hidden=None, seed=3, **rig):
    """time and columns of a run of a quiet rig."""
    rig = Rig(**{"rate": 128, "bits": 16, "angle_noise": 2e-4, "torque_noise": 0.1, "remnant": 0.1, "lag": 0.03, **rig})
    time, *columns, _ = record(
        excitation or sweep(0.5, 10, 3, 120.0), hidden or {}, RIDER, np.random.default_rng(seed), rig
    )
    return time, dict(zip(UNITS, columns, strict=True))


def run_of(time, columns):
    return prepare_steer_test_run(
        Recording("run", time, columns, UNITS), "steer_angle", "steer_torque", "steer_angle_command"
    )


def reduced(run):
    """The reduced chi-square of the truth; some 600 numbers scatter by 0.06."""
    model = HarmonicModel(rig_experiment({}))
    return fit(model, [run], model.start()).reduced


@pytest.mark.slow
@pytest.mark.parametrize("commanded", [True, False])
def test_a_sweep_that_turns_around_is_followed_through_the_corner(commanded):
    """Its frequency has a kink at 10 Hz, where splines 2.5 s apart left a thousandth of the angle, and a reduced
    chi-square of 43 or 2."""
    half, slope = 60.0, 2 * 9.5 / 120.0

    def cycles(t):
        before, after = np.minimum(t, half), np.maximum(t - half, 0)
        return 0.5 * before + slope / 2 * before**2 + 10 * after - slope / 2 * after**2

    time, columns = recorded((lambda t: np.radians(3) * np.sin(2 * np.pi * cycles(np.clip(t, 0, 2 * half))), 2 * half))
    columns["steer_angle_command"] *= commanded
    assert reduced(run_of(time, columns)) == pytest.approx(1.0, abs=0.2)


@pytest.mark.slow
@pytest.mark.parametrize("drift", [0.0, 0.03])
def test_mains_interference_in_the_torque_is_left_out(drift):
    """Order 5 and on cross 50 Hz: as noise of a broad band it left a reduced chi-square of 1.3. The mains frequency
    drifts by 0.03 Hz within a minute."""
    time, columns = recorded(rate=500)
    phase = 2 * np.pi * (50.02 * time - drift * 20 * np.cos(time / 20))
    columns["steer_torque"] = columns["steer_torque"] + 1.5 * np.cos(phase) + 0.7 * np.sin(2 * phase)
    run = run_of(time, columns)
    assert any("mains interference at 5" in note and "100" in note for note in run.notes)
    assert reduced(run) == pytest.approx(1.0, abs=0.2)


@pytest.mark.slow
@pytest.mark.parametrize("hidden", [{}, {"g": 3e-3}, {"Tc": 1.0}])
@pytest.mark.parametrize("quiet", [{}, {"bits": 30, "angle_noise": 1e-9, "torque_noise": 1e-7, "remnant": 1e-9}])
def test_the_response_of_an_effect_is_not_mains_interference(hidden, quiet):
    """Play responds at orders beyond all columns, without any noise as well; its response sweeps with the excitation,
    mains interference does not."""
    run = run_of(*recorded(hidden=hidden, **quiet))
    assert not any("mains interference" in note for note in run.notes)


@pytest.mark.slow
def test_gaps_in_the_log_are_not_compared():
    """Straight lines over a fifth of a second are no motion, and no torque: they left a reduced chi-square of 1.4."""
    time, columns = recorded(seed=4)
    rng, kept = np.random.default_rng(1), np.ones(len(time), bool)
    for at in rng.integers(500, len(time) - 500, 5):
        kept[at : at + 25] = False
    for at in rng.integers(500, len(time) - 500, 10):  # a spline bridges two
        kept[at : at + 2] = False
    run = run_of(time[kept], {name: values[kept] for name, values in columns.items()})
    assert reduced(run) == pytest.approx(1.0, abs=0.2)
    assert any("were bridged" in note for note in run.notes)


@pytest.mark.slow
def test_segments_of_a_component_s_run_do_not_cross_gaps():
    """Bridged by a straight line, gaps in the log made a linear oscillator `unknown` at a reduced chi-square of 3."""
    whole = joint_run({}, "random", seed=5, duration=20.0)
    kept = np.ones(len(whole.time), bool)
    for at in (300, 800):
        kept[at : at + 10] = False
    broken = Recording(
        "broken", whole.time[kept] + 5.0, {name: y[kept] for name, y in whole.columns.items()}, whole.units
    )
    test = input_output_experiment(DrivenJoint(), ["torque", "angle"])
    run, model = prepare_sampled_run(broken, test), FreeInitialStateModel(test)
    covered = np.zeros(len(whole.time), bool)
    for first, last in run.segments:
        covered[first:last] = True
    assert np.array_equal(np.flatnonzero(~covered), np.flatnonzero(~kept))
    run = run.with_densities(prepare_sampled_run(whole, test).densities, "given")
    # The noise is white, and known as what remains of fourth differences; some 200 numbers scatter by 0.1
    with_gaps, without = (fit(model, [each], model.start()) for each in (run, prepare_sampled_run(whole, test)))
    assert with_gaps.reduced == pytest.approx(without.reduced, abs=0.3)
    # The report shows input and output of the same samples: ten apart, at 1 Hz they would be a tenth of a turn off.
    (f, shown), (g, expected) = (drawn(each) for each in (with_gaps, without))
    assert np.median(np.abs(np.interp(g, f, shown) / expected - 1)) < 0.15


def drawn(found):
    """Frequency and response of the measured output, as the report draws it."""
    figures = {caption: figure for figure, caption in pictures(Verdict("none", found, found)).before_and_after}
    captions = "Frequency response of the first output to the first input.", "The same in the Nyquist plane."
    magnitude, plane = (figures[caption].panels[0].curves[0] for caption in captions)
    assert magnitude.name == plane.name == "measured"
    return magnitude.x, plane.x + 1j * plane.y


def test_stretches_of_a_ride_do_not_cross_gaps():
    time = np.arange(0, 60, 0.01)
    ride = Recording("ride", time, {"speed": np.full(len(time), 5.0)}, {"speed": "m/s"}, gaps=((20.0, 20.5),))
    # A second is left out beside them, as at both ends
    assert undisturbed(ride, "speed", ["speed"])[0] == [(100, 1901), (2150, 5900)]


@pytest.mark.slow
def test_mains_in_the_sensor_of_a_component_are_taken_out():
    """They were named a body more, on a spring that nothing damps."""
    clean = joint_run({}, "random", seed=5, duration=30.0)
    interference = 0.02 * np.sin(2 * np.pi * 16.67 * clean.time + 0.4)
    noisy = Recording("noisy", clean.time, clean.columns | {"angle": clean["angle"] + interference}, clean.units)
    test = input_output_experiment(DrivenJoint(), ["torque", "angle"])
    run, known = prepare_sampled_run(noisy, test), prepare_sampled_run(clean, test)
    assert any("angle has mains interference at 16.67 Hz (0.02 rad)" in note for note in run.notes) and not any(
        "mains interference" in note for note in known.notes
    )
    # What noise leaves uncertain of two numbers out of 3000
    assert np.std(run.measured - known.measured) < 5 * white_noise(clean["angle"]) / np.sqrt(3000)


@pytest.mark.slow
def test_drifting_mains_that_a_controller_feeds_back_are_taken_out():
    """The frequency drifts by 0.03 Hz in 30 s, and the torque contains a thousandth of the interference."""
    clean = joint_run({}, "random", seed=5, duration=30.0)
    phase = 2 * np.pi * (16.67 * clean.time + 0.03 * clean.time**2 / 60)
    columns = {
        "angle": clean["angle"] + 0.02 * np.sin(phase) + 0.002 * np.sin(2 * phase + 0.7),
        "torque": clean["torque"] + 5e-4 * clean["torque"].std() * np.sin(phase + 1.0),
    }
    test = input_output_experiment(DrivenJoint(), ["torque", "angle"])
    run, known = (prepare_sampled_run(Recording("loop", clean.time, clean.columns | c, clean.units), test) for c in (columns, {}))
    assert any("angle has mains interference at 16.6" in note for note in run.notes)
    # 15 phases out of 3000 samples are estimated with the part of the motion at 16.67 Hz.
    left = run.measured - known.measured
    assert np.std(left) < 0.02 / np.sqrt(2) / 10
    # The harmonic at 33.3 Hz, beyond the motion, drifts twice as fast; noise of 2e-3 rad is at that frequency alone.
    turn = np.exp(2j * phase) * np.hanning(len(phase))[:, None].T
    assert abs(turn @ left)[0] / np.sum(np.hanning(len(phase))) * 2 < 0.002 / 10
    # A torque whose lines have a share of its power that excites the joint, as a periodic one has.
    periodic = columns | {"torque": clean["torque"] + 0.01 * clean["torque"].std() * np.sin(phase + 1.0)}
    excited = prepare_sampled_run(Recording("periodic", clean.time, clean.columns | periodic, clean.units), test)
    assert not any("mains interference" in note for note in excited.notes)


def response(what, rng):
    """Force and displacement (n,) of what has lines of its own."""
    time = np.arange(0, 60, 0.01)
    force = lfilter(*butter(2, 0.3), rng.standard_normal(len(time)))
    if what == "light_mode":  # 6 Hz, damped by 0.2 %
        return time, force, lfilter([1e-3], [1, -2 * np.exp(-0.0754e-2) * np.cos(0.377), np.exp(-0.1508e-2)], force)
    if what == "decay":
        return time, 0 * force, np.exp(-time / 30) * np.cos(2 * np.pi * 6 * time)
    drive = np.sin(2 * np.pi * 2.5 * time)
    return time, drive, drive + 0.05 * drive**3  # a hardening spring responds at 7.5 Hz too


@pytest.mark.parametrize("what", ["light_mode", "decay", "harmonics"])
def test_lines_in_the_response_of_a_component_are_not_mains_interference(what):
    rng = np.random.default_rng(1)
    time, force, displacement = response(what, rng)
    run = Recording(
        what,
        time,
        {"force": force, "displacement": displacement + 1e-5 * rng.standard_normal(len(time))},
        {"force": "N", "displacement": "m"},
    )
    assert without_mains_interference(run, ["force"], ["displacement"])[1] == ()
