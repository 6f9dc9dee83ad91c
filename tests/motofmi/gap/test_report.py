"""The figures and modes of the report show the validation run, with the values of verdict.json."""

from collections import Counter
from dataclasses import replace

import numpy as np
import pytest

from motofmi.gap.models.harmonic_model import HarmonicModel
from motofmi.gap.preprocessing.steer_test_run import prepare_steer_test_run
from motofmi.gap.selection.model_selection import select_model
from motofmi.gap.verdict import as_result
from motofmi.reports.gap_before_after import LAGS, figures, shown_run, without_and_with
from motofmi.workflows.gap.augmented_rider import effect_on_modes, motion_of
from motofmi.workflows.gap.rig import rig_effects, rig_experiment
from rider_fmu import riders
from rider_fmu.effects.head import SteeringFriction
from tests.simulators.as_recordings import as_recording
from tests.simulators.hidden_rig import RIDER, record, sweep

FRICTION = 0.7


@pytest.fixture(scope="module")
def case():
    rng = np.random.default_rng(5)
    excitations = {"up": sweep(0.5, 10, 2.0, 60.0), "down": sweep(10, 0.5, 3.0, 60.0)}
    recordings = [as_recording(name, record(e, {"Tc": FRICTION}, RIDER, rng)) for name, e in excitations.items()]
    up, down = (prepare_steer_test_run(r, "steer_angle", "steer_torque", "steer_angle_command") for r in recordings)
    rig = {"handlebar_inertia": {"value": 0.125, "standard_error": 0.00125}}
    return select_model(
        HarmonicModel(rig_experiment(rig)), [up], [e for e in rig_effects() if e.family == "coulomb_friction"], [down]
    )


@pytest.mark.slow
def test_figures_are_of_the_validation_run_and_their_residuals_agree_with_the_verdict(case):
    gap = as_result(case, "N.m")["gap"]
    shown = without_and_with(case)
    assert [label for _, _, label in shown] == ["base", "with the effects found"] and "Validation runs" in shown_run(
        case
    )
    drawn = figures(shown)
    assert len(drawn) == 5
    residuals = drawn[1][0].panels[1].curves
    for (fit, _, _), line, key in zip(shown, residuals[:2], ("holdout_before", "holdout_after"), strict=True):
        assert fit.runs[0].name == "down"
        samples = np.array([last - first for first, last, _ in fit.runs[0].reduction.bases])
        assert np.sqrt(line.y**2 @ samples / samples.sum()) == pytest.approx(gap["rms"][key])
    fitted = replace(case, validation_gap=None)
    assert without_and_with(fitted)[0][0].runs[0].name == "up" and "No validation run" in shown_run(fitted)


def with_residuals(found, residuals):
    """The fit with other residuals (m,) of its first run, in units of the noise."""
    return replace(found, residuals=np.concatenate([residuals, found.residuals[len(residuals) :]]))


@pytest.mark.slow
def test_the_amplitude_of_an_order_is_that_of_its_sine(case):
    found = case.validation_gap[1].fit
    run = found.runs[0]
    time = run.recording.time
    angle, rate, _ = run.motion_at(time)
    phase = np.unwrap(np.arctan2(-rate / (2 * np.pi * np.interp(time, [0, 60], [10, 0.5])), angle))
    for k in (1, 3):
        residuals = run.reduction.reduce(0.4 * np.cos(k * phase)) / run.effort.deviation
        by_order = figures([(with_residuals(found, residuals), "found", "sine")])[2][0]
        amplitudes = by_order.panels[k - 1].curves[0].y
        # Where a slow sweep begins and ends its phase is only nearly that of angle and rate.
        assert np.median(amplitudes) == pytest.approx(0.4, rel=0.02)


@pytest.mark.slow
def test_the_autocorrelation_is_over_time_of_each_cosine_and_sine(case):
    """Neighbours are numbers of one order, degree and phase in successive windows."""
    found = case.validation_gap[1].fit
    columns, seen, sequence = found.runs[0].reduction.columns, Counter(), []
    for i, column in enumerate(columns):
        seen[column.window, column.order, column.degree] += 1  # the cosine first, then the sine
        kind = column.order, column.degree, seen[column.window, column.order, column.degree]
        sequence.append((*kind, column.window, i))
    noise = np.random.default_rng(1).standard_normal(len(columns))
    ordered = noise[[i for *_, i in sorted(sequence)]]
    figure = figures([(with_residuals(found, noise), "found", "noise")])[-1][0]
    expected = [ordered[:-k] @ ordered[k:] / (ordered @ ordered) for k in range(1, LAGS + 1)]
    assert figure.panels[1].curves[0].y == pytest.approx(expected, abs=1e-12)


@pytest.mark.slow
def test_the_describing_function_of_friction_is_a_damper_and_not_a_lock(case):
    """Under a sweep of amplitude a it is between 4 F / (pi a w) at the lowest and at the highest frequency; at rest it
    locks the bar."""
    plain = riders.load("mean_2011")
    rubbing = plain.with_effects(SteeringFriction()).with_values(**{"coulomb_friction.friction_torque": FRICTION})
    motion = motion_of(case.best, rubbing)
    assert set(motion) == {"vehicle.steer_angle", "vehicle.steer_rate", "device.torso_angle", "device.torso_momentum"}
    assert np.std(motion["vehicle.steer_angle"]) == pytest.approx(np.radians(2) / np.sqrt(2), rel=0.05)
    found = effect_on_modes(plain, rubbing, motion)
    before, rest, moving = (
        np.array(found[label]["wobble"]["frequency"], float) for label in ("before", "after", "in_motion")
    )
    assert np.all(np.abs(moving / before - 1) < 0.05) and np.all(rest < 0.8 * before)
