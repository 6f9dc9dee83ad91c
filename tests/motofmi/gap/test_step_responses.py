"""Step responses of a slide with dry friction, each too short for an estimate of its noise."""

import json
from dataclasses import replace

import numpy as np
import pytest
from scipy.signal import lsim

import motofmi as mf
from fmus.effects.damping import CubicDamping
from fmus.mechanisms.mass_spring_damper import MassSpringDamper
from fmus.support.errors import InputError
from motofmi.gap.estimation.fitting import fit
from motofmi.gap.estimation.from_rest import fit_from_rest
from motofmi.gap.experiments.input_output import input_output_experiment
from motofmi.gap.experiments.sensor_offset import sensor_offset_parameter
from motofmi.gap.models.free_initial_state import FreeInitialStateModel
from motofmi.gap.preprocessing.sampled_run import excited
from motofmi.gap.preprocessing.sampled_run_preparation import prepare_sampled_run
from motofmi.gap.selection.any_component import investigate, with_unknown_offsets
from motofmi.gap.selection.staged_selection import Selection
from motofmi.recordings.joined import with_short_joined
from motofmi.recordings.recording import Recording
from tests import as_study
from tests.simulators.step_responses import DAMPING, FRICTION, MASS, RATE, step_response

FITTED, VALIDATION = (4.7, 9.4, -3.3, -9.4), (5.6, 10.8, -4.7)  # N
SLIDE = MassSpringDamper().with_values(spring_stiffness=0.0)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("base", "rate"),
    [as_study(SLIDE, RATE), ("mass_spring_damper", RATE), as_study("mass_spring_damper", 1000.0)],
    ids=["slide", "with a spring", "long recordings"],
)
def test_the_friction_of_step_responses_is_named(base, rate, tmp_path):
    """A spring in the base must not take the place of the force: the slide has none."""
    runs, checks = ([step_response(force, rate=rate) for force in forces] for forces in (FITTED, VALIDATION))
    found = mf.find_gap(runs, validation=checks, component=base)
    verdict = found.to_dict()
    assert [effect["name"] for effect in verdict["effects"]] == ["coulomb_friction"]
    # An encoder with steps of 15 um over 0.2 m, and a transition through zero rate: some parts in a thousand
    assert verdict["effects"][0]["parameters"]["friction_torque"]["value"] == pytest.approx(FRICTION, rel=0.005)
    assert verdict["base"]["mass"]["value"] == pytest.approx(MASS, rel=0.01)
    assert verdict["base"]["spring_damping"]["value"] == pytest.approx(DAMPING, rel=0.01)
    said = " ".join(verdict["limitations"])
    assert "begin at rest" in said and ("joined into one recording" in said) == (rate == RATE)
    page = found.report(tmp_path / "report.html").read_text("utf-8")
    drawn = json.loads(page.split('<script type="application/json">')[1].split("</script>")[0])["panels"][0]["curves"]
    gaps = len(VALIDATION) - 1 if rate == RATE else 0  # no line is drawn across the gaps of the joined recording
    assert [curve["y"].count(None) for curve in drawn] == [gaps] * len(drawn)


@pytest.mark.slow
@pytest.mark.parametrize("verdict", ["none", "named"])
def test_no_verdict_rests_on_a_model_without_any_determined_value(monkeypatch, verdict):
    """At constant rate from the first sample on, the force has no influence beside free initial states: neither is the
    model sufficient, nor may an effect be named beside a mass that is not determined."""
    selected = Selection.verdict
    monkeypatch.setattr(Selection, "verdict", lambda of: replace(selected(of), verdict=verdict))
    (run,), _ = with_short_joined([step_response(force, from_rest=False) for force in FITTED], 1000)
    experiment = input_output_experiment(MassSpringDamper(), run.columns)
    found = investigate(experiment, [prepare_sampled_run(run, experiment)], library=[CubicDamping]).verdict
    assert found.verdict == "unknown"
    assert "do not test the model" in found.withheld and "--component FILE.toml" in found.withheld


@pytest.mark.slow
def test_a_validation_run_that_begins_in_mid_swing_has_free_initial_states():
    """The recording of one step of the force, fitted from rest up to 4 s and compared from there on."""
    time, noise = np.arange(0, 12, 0.01), 2e-5 * np.random.default_rng(2).standard_normal(1200)
    force = np.full(len(time), 5.0)
    displacement = lsim(([1.0], [2.0, 1.2, 200.0]), force, time)[1] + noise
    units = {"force": "N", "displacement": "m"}
    fitted, validation = (
        Recording(name, time[part], {"force": force[part], "displacement": displacement[part]}, units)
        for name, part in (("fitted", slice(400)), ("validation", slice(430, None)))
    )
    found = mf.find_gap([fitted], validation=validation, component="mass_spring_damper").to_dict()
    assert any("begin at rest" in sentence for sentence in found["limitations"])
    # The noise is 0.3 % of the motion after 4.3 s.
    assert found["verdict"] == "none" and found["remainder"]["share"] < 0.01


def test_a_single_short_recording_is_refused_with_what_to_do():
    with pytest.raises(InputError, match=r"too few .* several such recordings of one sampling rate, which are joined"):
        mf.find_gap(step_response(9.4), component="mass_spring_damper")


@pytest.mark.parametrize(("forces", "one_way"), [((4.7, 9.4), True), ((4.7, -9.4), False)])
def test_pushes_in_one_direction_move_one_way(forces, one_way):
    """The ramp back, in the gap between the recordings, does not count."""
    (run,), _ = with_short_joined([step_response(force) for force in forces], 1000)
    prepared = prepare_sampled_run(run, input_output_experiment(MassSpringDamper(), run.columns))
    assert bool(prepared.direction) == one_way


@pytest.mark.parametrize(("change", "varying"), [(1e-15, False), (0.5, True)])
def test_an_input_that_is_constant_within_rounding_has_no_sensor_offset(change, varying):
    """With a prior of 1e-16 N for its offset, no other parameter would have an influence."""
    run = step_response(9.4, rate=1000.0)
    run.columns["force"][::2] += change
    prepared = prepare_sampled_run(run, input_output_experiment(MassSpringDamper(), run.columns))
    assert bool(with_unknown_offsets(prepared.experiment, [prepared]).sensor_offsets) == excited([prepared]) == varying


def test_a_deflected_mass_that_is_released_is_no_step_response():
    """x(t) = 0.01 exp(-t) cos(10 t) m begins at rest, and its small constant force does not move it."""
    time = np.arange(0.0, 4.0, 0.01)
    displacement = 0.01 * np.exp(-time) * (np.cos(10 * time) + 0.1 * np.sin(10 * time))
    template = step_response(1.0)
    released = replace(template, time=time, columns={"force": np.full(len(time), 1e-6), "displacement": displacement})
    opposite = replace(released, columns={**released.columns, "force": np.full(len(time), 2e-6)})
    experiment = input_output_experiment(MassSpringDamper(), released.columns)
    model = FreeInitialStateModel(experiment)
    start = np.log([1.0, 101.0, 2.0])
    runs = [prepare_sampled_run(each, experiment) for each in (released, opposite)]
    assert fit_from_rest(fit(model, runs, start)) is None


@pytest.mark.parametrize(("forces", "common"), [((4.7, 9.4), False), ((4.7, -9.4), True), ((-4.7, -9.4), False)])
def test_no_offset_of_each_run_is_fitted_in_place_of_friction(forces, common):
    """In a run of one direction an offset and dry friction are the same constant force; runs of both tell them apart."""
    recordings = [step_response(force, rate=1000.0) for force in forces]
    experiment = input_output_experiment(MassSpringDamper(), recordings[0].columns)
    runs = [prepare_sampled_run(r, experiment) for r in recordings]
    for run in runs:
        run.recording.columns["force"][:10] = 0.0  # an input that varies
    assert [run.direction for run in runs] == [np.sign(force) for force in forces]
    found = with_unknown_offsets(experiment, runs)
    of_all, of_each = found.measured_effects[sensor_offset_parameter("force")][1], found.sensor_offsets["force"]
    assert (of_each < 0.01 * of_all) == common
    assert (of_all < 0.01 * of_each) != common


@pytest.mark.parametrize(("swing", "direction"), [(0.0, -1.0), (0.1, 0.0)])
def test_noise_of_a_slowly_moving_sensor_is_no_change_of_direction(swing, direction):
    """From one sample to the next the motion advances by 0.3 mm, less than the noise of 1 mm."""
    time = np.arange(1000) / 100
    noise = 1e-3 * np.random.default_rng(5).uniform(-1, 1, len(time))
    columns = {"force": -time, "displacement": -0.03 * time + swing * np.sin(time) + noise}
    recording = Recording("slow", time, columns, {"force": "N", "displacement": "m"})
    run = prepare_sampled_run(recording, input_output_experiment(MassSpringDamper(), list(columns)))
    assert run.direction == direction
