"""Runs of a component before they are fitted: their rate, and segments where the base is unstable."""

from dataclasses import replace

import numpy as np
import pytest

from fmus import Component, input, parameter, state
from fmus.effects.hysteresis import DahlHysteresis
from fmus.mechanisms import DrivenJoint, MassSpringDamper, Pendulum
from motofmi.gap.estimation.base_fit import on_segments_like
from motofmi.gap.estimation.equation_error import EquationErrorFit
from motofmi.gap.estimation.fitting import fit
from motofmi.gap.estimation.initial_fit import stable_segments
from motofmi.gap.estimation.starting_values import poles
from motofmi.gap.experiments.input_output import input_output_experiment
from motofmi.gap.models.free_initial_state import FreeInitialStateModel
from motofmi.gap.models.segment_unknowns import groups, segment_solutions, segment_starts
from motofmi.gap.preprocessing.decimation import advice_on_rate
from motofmi.gap.preprocessing.sampled_run_preparation import prepare_sampled_run, sampled_run
from motofmi.recordings.recording import Recording
from tests.simulators.double_pendulum import TRUE, DoublePendulum
from tests.simulators.other_components import TwoCarts, carts_run


def test_a_recording_is_decimated_by_the_band_of_its_output_not_of_its_noisy_input():
    rng = np.random.default_rng(11)
    time = np.arange(0, 12, 0.001)
    force = np.sin(2 * np.pi * 0.5 * time) + rng.standard_normal(len(time))
    displacement = 0.1 * np.sin(2 * np.pi * 0.5 * time) + 0.02 * np.sin(2 * np.pi * 4.0 * time)
    units = {"force": "N", "displacement": "m"}
    recording = Recording("fast", time, {"force": force, "displacement": displacement + 1e-5 * rng.standard_normal(len(time))}, units)
    run = prepare_sampled_run(recording, input_output_experiment(MassSpringDamper(), recording.columns))
    # Twenty times 4 Hz is 80 Hz; at least 3,000 samples stay.
    assert 80 <= run.recording.rate <= 260 and any("decimated" in note for note in run.notes)
    # What lies below the new band is kept: 0.02 m at 4 Hz.
    kept = np.abs(np.fft.rfft(run.measured[:, 0] * np.hanning(len(run.measured)))) * 4 / len(run.measured)
    frequency = np.fft.rfftfreq(len(run.measured), 1 / run.recording.rate)
    assert kept[np.argmin(np.abs(frequency - 4.0))] == pytest.approx(0.02, rel=0.02)  # half a bin of a Hann window


@pytest.mark.parametrize(("duration", "share"), [(25.0, 0.01), (25.0, 0.1), (15.0, 0.01)])
def test_many_samples_with_little_power_at_high_frequencies_are_advised_to_be_reduced(duration, share):
    """60 Hz exceeds the noise, so that the recording is not decimated; with 10 % of the amplitude it is 1 % of the
    power, and with 15,000 samples the search is short."""
    time = np.arange(0, duration, 0.001)
    displacement = 0.1 * np.sin(2 * np.pi * 0.5 * time) + 0.1 * share * np.sin(2 * np.pi * 60.0 * time)
    columns = {"force": np.sin(2 * np.pi * 0.5 * time), "displacement": displacement}
    noisy = columns | {"displacement": displacement + 1e-6 * np.random.default_rng(5).standard_normal(len(time))}
    recording = Recording("fast", time, noisy, {"force": "N", "displacement": "m"})
    run = prepare_sampled_run(recording, input_output_experiment(MassSpringDamper(), recording.columns))
    assert len(run.measured) == len(time)
    said = advice_on_rate([run])
    if duration > 20 and share < 0.1:
        assert "25000 samples" in said and 10 <= float(said.split("--rate ")[1].split()[0]) <= 20
    else:
        assert said == ""


def test_poles_of_a_base_whose_fit_has_left_its_bounds_are_those_at_the_bounds():
    recording = Recording("any", np.arange(300) / 100, {"force": np.ones(300), "displacement": np.arange(300.0)}, {"force": "N", "displacement": "m"})
    model = FreeInitialStateModel(input_output_experiment(MassSpringDamper(), recording.columns))
    x = model.start()
    x[model.names.index("mass")] = np.log(1e9)  # the bound is 1e6 kg
    at_bound = np.roots([1e6, *(MassSpringDamper().values[n] for n in ("spring_damping", "spring_stiffness"))])
    assert sorted(poles(model, x), key=lambda p: p.imag) == pytest.approx(sorted(at_bound, key=lambda p: p.imag))


class Slider(Component):
    """A mass with dry friction F v / |v|, which is not defined at rest."""

    mass_of_slider = parameter("kg", "Mass", min=1e-3, start=1.0)
    friction = parameter("N", "Dry friction", min=0, start=0.5)
    force = input("N", "Driving force")
    position = state("m", "Position", exposed=True)
    velocity = state("m/s", "Velocity")

    def equations(self, v, m):
        resisting = v.friction * v.velocity / m.absolute(v.velocity)
        return {"der(position)": v.velocity, "der(velocity)": (v.force - resisting) / v.mass_of_slider}


def test_equations_that_are_not_defined_at_rest_are_no_crash():
    time = np.arange(400) / 100
    columns = {"force": np.sin(time), "position": np.cos(3 * time)}
    experiment = input_output_experiment(Slider(), list(columns))
    run = prepare_sampled_run(Recording("slider", time, columns, {"force": "N", "position": "m"}), experiment)
    x = FreeInitialStateModel(experiment).first_states(run, 0)
    assert x[0] == pytest.approx(1.0, abs=0.01) and np.all(np.isfinite(x))


def test_segments_are_short_where_the_recorded_motion_is_unstable():
    class NonlinearPendulum(DrivenJoint):
        """Pendulum with the sine of its angle, not damped."""

        def equations(self, v, m):
            v.joint_torque = v.stiffness * m.sin(v.angle)
            return {"der(angle)": v.rate, "der(rate)": (v.torque - v.joint_torque) / v.inertia}

    time = np.arange(0, 20, 0.01)  # about the stable equilibrium for 10 s, then about the unstable one
    angle = np.where(time < 10, 0.0, np.pi) + 0.1 * np.sin(2 * np.pi * 0.2 * time)
    recording = Recording("both", time, {"torque": 0.1 * np.cos(time), "angle": angle}, {"torque": "N.m", "angle": "rad"})
    experiment = input_output_experiment(NonlinearPendulum(inertia=1.0, damping=1e-9, stiffness=9.0), recording.columns)
    model = FreeInitialStateModel(experiment)
    whole = prepare_sampled_run(recording, experiment).cut(2000)
    cut = stable_segments(model, model.start(), whole)
    assert [a for a, _ in cut.segments[1:]] == [b for _, b in cut.segments[:-1]]  # no gap, no overlap
    assert (cut.segments[0][0], cut.segments[-1][1]) == (whole.segments[0][0], whole.segments[-1][1])
    lengths = {a: b - a for a, b in cut.segments}
    # About the unstable equilibrium it grows by exp(3 t): by a factor of 20 in 1 s, 100 samples. Whole segments fill
    # the run: they are up to a tenth longer.
    assert 100 <= max(length for a, length in lengths.items() if a >= 1000) <= 110
    assert lengths[0] > 900
    assert [b - a for a, b in whole.cut(500).segments] == [500] * 4


def test_the_motion_of_several_degrees_of_freedom_grows_by_a_factor_of_five_in_a_segment():
    """Upright links: the growth rate is the largest root of det(M s^2 + C s + K), from the matrices of the links."""
    time = np.arange(2000) / 100
    sway = 1e-3 * np.sin(time)  # changes the growth by a share of 1e-6
    columns = {"torque": sway, "elbow_torque": sway, "angle": np.pi + sway, "elbow_angle": sway}
    units = {"torque": "N.m", "elbow_torque": "N.m", "angle": "rad", "elbow_angle": "rad"}
    experiment = input_output_experiment(DoublePendulum().with_values(**TRUE), list(columns))
    run = prepare_sampled_run(Recording("upright", time, columns, units), experiment)
    model = FreeInitialStateModel(experiment)
    p = TRUE
    both = p["elbow_inertia"] + p["coupling"]
    mass = np.array([[p["inertia"] + both + p["coupling"], both], [both, p["elbow_inertia"]]])
    stiffness = -p["elbow_weight"] * np.ones((2, 2)) - np.diag([p["weight"], 0.0])
    damping = np.diag([p["damping"], p["elbow_damping"]])
    free = np.linalg.solve(mass, np.hstack([-stiffness, -damping]))
    growth = np.linalg.eigvals(np.vstack([np.eye(2, 4, 2), free])).real.max()
    lengths = stable_segments(model, model.start(), run).stable_length
    assert np.median(lengths) == pytest.approx(np.log(5.0) / growth * run.recording.rate, abs=1.0)  # whole samples


def test_a_state_of_an_effect_is_no_further_degree_of_freedom():
    """With a loop of 1 rad the deflection's rate is the rate of the loop's state as well."""
    time = np.arange(2000) / 100
    columns = {"torque": np.sin(time), "angle": 0.1 * np.sin(time)}
    recording = Recording("upright", time, columns, {"torque": "N.m", "angle": "rad"})
    experiment = input_output_experiment(Pendulum(inertia=1.0, damping=1e-9, gravity_stiffness=-9.0), list(columns))
    experiment = replace(experiment, given={experiment.parameter(DahlHysteresis, "width"): 1.0})
    run = prepare_sampled_run(recording, experiment).cut(2000)
    alone, loop = FreeInitialStateModel(experiment), FreeInitialStateModel(experiment, [DahlHysteresis])
    start = loop.start()
    start[loop.names.index(experiment.parameter(DahlHysteresis, "force"))] = 0.0
    lengths = [stable_segments(model, x, run).stable_length for model, x in ((alone, alone.start()), (loop, start))]
    np.testing.assert_array_equal(*lengths)


@pytest.mark.parametrize("stiffnesses", [(-9.0, -1.21), (-1.21, -9.0)])
def test_base_and_best_effect_are_both_stable_over_segments_of_validation_runs(stiffnesses):
    """Of growth rates of 3 and 1.1 per second the larger one determines the segments, of whichever model it is."""
    time = np.arange(2000) / 100
    columns = {"torque": np.sin(time), "angle": 0.1 * np.sin(time)}
    recording = Recording("upright", time, columns, {"torque": "N.m", "angle": "rad"})
    base, other = (Pendulum(inertia=1.0, damping=1e-9, gravity_stiffness=k) for k in stiffnesses)
    experiment = input_output_experiment(base, list(columns))
    model = FreeInitialStateModel(experiment)
    run = prepare_sampled_run(recording, experiment)
    found = fit(model, [run.cut(100)], model.start(), iterations=0)
    start = EquationErrorFit(None, np.log(np.abs([other.values[n] for n in model.base])), np.zeros(0), 1.0)
    (cut,) = on_segments_like(found, [start], [run.cut(2000)])
    assert np.median(cut.stable_length) == pytest.approx(np.log(20.0) / 3.0 * 100, abs=1.0)  # whole samples


def test_the_motion_of_a_joint_that_turns_on_and_on_is_that_in_a_segment():
    """The variance of n samples of a ramp is the square of its step times (n^2 - 1) / 12."""
    time, length = np.arange(1024) / 100, 128
    recording = Recording("turning", time, {"torque": 0 * time, "angle": 50 * time}, {"torque": "N.m", "angle": "rad"})
    run = sampled_run(recording, input_output_experiment(DrivenJoint(), ["torque", "angle"])).cut(length)
    assert {last - first for first, last in run.segments} == {length}
    assert run.motion_variance == pytest.approx([0.5**2 * (length**2 - 1) / 12], rel=1e-9)  # rounding


def test_segments_that_are_computed_together_are_those_computed_alone():
    """Segments of 111 and 112 samples, of which some samples are not compared."""
    recording = carts_run("carts", 2)
    experiment = input_output_experiment(TwoCarts(), recording.columns)
    run = sampled_run(recording, experiment, limits={"position": [(2.0, 2.3)]}).cut(110)
    assert len({last - first for first, last in run.segments}) == 2 and run.reduction.compared is not None
    model = FreeInitialStateModel(experiment)
    x0 = {i: model.first_states(run, i) for i in range(len(run.segments))}
    made, nodes = model.simulated(run, list(x0), model.values(model.start()), x0)
    samples, unbounded = dict(zip(x0, nodes.samples, strict=True)), np.full(4, np.inf)
    slopes = {i: made.slopes[where] for i, where in samples.items()}
    for alike in groups(run, x0):
        together = segment_starts(run, {i: x0[i] for i in alike}, made, samples, unbounded)
        of_data = run.reduction.reduce_segments(np.array([slopes[i] for i in alike]), alike)
        solved = segment_solutions(run, alike, together, of_data)
        for i in alike:
            alone = segment_starts(run, {i: x0[i]}, made, {i: samples[i]}, unbounded)
            assert alone[i].reduced == pytest.approx(together[i].reduced, abs=1e-9 * np.abs(together[i].reduced).max())
            assert alone[i].step == pytest.approx(together[i].step, rel=1e-6, abs=1e-9)
            (one,) = segment_solutions(run, [i], alone, run.reduction.reduce_segments(slopes[i][None], [i])).values()
            assert one.slopes == pytest.approx(solved[i].slopes, abs=1e-9 * np.abs(solved[i].slopes).max())
            assert one.x_slopes == pytest.approx(solved[i].x_slopes, rel=1e-6, abs=1e-9)
