"""The noise of runs sample by sample: beside what is modelled, from repetitions, and in the rms of a misfit."""

import numpy as np
import pytest
from scipy.signal import lfilter

from fmus.declaration.variables import input
from fmus.mechanisms import DrivenJoint, MassSpringDamper
from motofmi.gap.estimation.fitting import fit
from motofmi.gap.experiments.input_output import input_output_experiment
from motofmi.gap.models.free_initial_state import FreeInitialStateModel
from motofmi.gap.preprocessing.flexible_noise_model import noise_density
from motofmi.gap.preprocessing.noise_sources import known_noise
from motofmi.gap.preprocessing.sampled_run_preparation import prepare_sampled_run
from motofmi.gap.validation.before_after import misfit_of
from motofmi.recordings.recording import Recording
from motofmi.recordings.resampling import is_white, white_noise


class TwoTorques(DrivenJoint):
    """A joint with torques at both ends."""

    other_torque = input("N.m", "Torque on the other end")

    def equations(self, v, m):
        return {"der(angle)": v.rate, "der(rate)": (v.torque + v.other_torque - v.stiffness * v.angle) / v.inertia}


def test_noise_is_found_beside_what_features_explain():
    rng = np.random.default_rng(1)
    u = rng.standard_normal(4000)
    filtered = np.convolve(u, [0.2, 0.5, -0.3, 0.1], "same") + 0.5 * np.convolve(u**3, [0.3, 0.7], "same")
    noise = 0.1 * rng.standard_normal(4000)
    density = noise_density(filtered + noise, [u, u**3], 100.0)
    # 2000 frequencies less a third for the terms: the density scatters by 3 %, and a filter is no polynomial in a band
    assert density(np.array([2.0, 20.0, 45.0])) == pytest.approx(0.01, rel=0.15)


def test_white_noise_in_a_smooth_signal_with_kinks():
    time = np.arange(0, 20, 0.01)
    y = np.abs(np.sin(2 * np.pi * time)) + 0.01 * np.random.default_rng(2).standard_normal(len(time))
    assert white_noise(y) == pytest.approx(0.01, rel=0.1)  # 2000 differences: 3 %


@pytest.mark.slow
def test_repeated_periods_give_the_noise():
    rng = np.random.default_rng(4)
    time = np.arange(0, 24, 0.01)
    drive = np.cos(2 * np.pi * 0.5 * time) + np.cos(2 * np.pi * 1.5 * time + 1)
    angle = 0.1 * np.cos(2 * np.pi * 0.5 * time - 0.3) + 0.01 * rng.standard_normal(len(time))
    recording = Recording("periodic", time, {"torque": drive, "angle": angle}, {"torque": "N.m", "angle": "rad"})
    test = input_output_experiment(DrivenJoint(), list(recording.columns))
    (run,) = known_noise([prepare_sampled_run(recording, test)], {})
    assert run.noise_source == "repeats"
    assert run.densities[0](np.array([1.0])) == pytest.approx(1e-4, rel=0.2)  # 1000 frequencies, in bands
    (run,) = known_noise([run], {"angle": 0.02})
    assert run.noise_source == "given"
    assert run.deviation == pytest.approx(0.02)


def test_the_response_to_a_second_input_is_no_noise():
    """One input is periodic, the other one random: the recording repeats only where both do."""
    rng, time = np.random.default_rng(4), np.arange(0, 24, 0.01)
    sources = {False: rng.standard_normal(len(time)), True: np.cos(2 * np.pi * 0.5 * time)}
    test = input_output_experiment(TwoTorques(), ["torque", "other_torque", "angle"])

    def source_of_noise(*repeats):
        first, second = (sources[each] for each in repeats)
        angle = lfilter([0.1], [1, -0.9], first + second) + 0.01 * rng.standard_normal(len(time))
        columns = {"torque": first, "other_torque": second, "angle": angle}
        units = {"torque": "N.m", "other_torque": "N.m", "angle": "rad"}
        (run,) = known_noise([prepare_sampled_run(Recording("run", time, columns, units), test)], {})
        return run.noise_source

    assert source_of_noise(True, False) == source_of_noise(False, True) == "flexible_model"
    assert source_of_noise(True, True) == "repeats"


def test_a_ramp_is_no_repetition():
    """One part of it differs from another by a constant, and so does a second run with an offset."""
    time = np.arange(0, 24, 0.01)
    noise = 1e-3 * np.random.default_rng(4).standard_normal((2, len(time)))
    test = input_output_experiment(DrivenJoint(), ["torque", "angle"])
    runs = [
        prepare_sampled_run(
            Recording(f"ramp_{k}", time, {"torque": 0.2 * time + 5 * k, "angle": 0.02 * time + k + noise[k]},
                      {"torque": "N.m", "angle": "rad"}),
            test,
        )
        for k in range(2)
    ]  # fmt: skip
    assert [run.noise_source for run in known_noise(runs, {})] == ["flexible_model"] * 2


def test_white_noise_is_no_motion_unless_an_input_explains_it():
    rng = np.random.default_rng(5)
    drive, noise = rng.standard_normal((2, 2000))
    assert is_white(noise) and is_white(noise, [drive])
    assert not is_white(np.roll(drive, 1) + 0.5 * noise, [drive]) and not is_white(np.cumsum(noise))


def test_the_rms_of_a_misfit_is_that_of_the_first_output():
    """The second output has another unit, and noise that is a thousand times as large in numbers."""
    rng, time = np.random.default_rng(1), np.arange(0, 20, 0.02)
    x = 0.02 * np.cos(3.0 * time)
    v = -0.06 * np.sin(3.0 * time)
    noise = {"displacement": 1e-4, "velocity": 0.1}
    columns = {n: y + noise[n] * rng.standard_normal(len(time)) for n, y in (("displacement", x), ("velocity", v))}
    recording = Recording("oscillator", time, columns, {"displacement": "m", "velocity": "m/s"})
    component = MassSpringDamper(mass=1.0, spring_stiffness=9.0, spring_damping=1e-6)
    experiment = input_output_experiment(component, list(columns), free=("spring_stiffness",))
    assert experiment.outputs == ("displacement", "velocity")
    run = prepare_sampled_run(recording, experiment)
    found = fit(FreeInitialStateModel(experiment), [run], FreeInitialStateModel(experiment).start(), iterations=0)
    # The rms of white noise in the compared share of the band; 10 % as some hundred coefficients are random
    compared = np.sqrt(sum(kept for *_, kept in run.reduction.spans) / len(time))
    assert misfit_of(found).rms == pytest.approx(1e-4 * compared, rel=0.1)
