"""The transition of dry friction, on a driven mass that sticks a third of the time.

The recordings are those of Moreau's time stepping, in which the rate is exactly zero while the mass sticks.

Source: Moreau, Unilateral contact and dry friction in finite freedom dynamics (1988).
"""

from dataclasses import replace

import numpy as np
import pytest
from scipy.signal import butter, sosfiltfilt

from fmus.effects.damping import CoulombFriction, StribeckFriction
from fmus.mechanisms.mass_spring_damper import MassSpringDamper
from motofmi.gap.comparison.compared_model import CommonBlocks
from motofmi.gap.comparison.search import with_narrower_transitions
from motofmi.gap.criteria import Criteria
from motofmi.gap.estimation.candidate import Candidate
from motofmi.gap.estimation.fit_result import parameters_of_effect
from motofmi.gap.estimation.fitting import fit
from motofmi.gap.estimation.friction_transition import has_transition, worth_narrowing
from motofmi.gap.experiments.input_output import input_output_experiment
from motofmi.gap.models.free_initial_state import FreeInitialStateModel
from motofmi.gap.preprocessing.sampled_run_preparation import prepare_sampled_run
from motofmi.gap.selection.any_component import Investigation, investigate
from motofmi.gap.selection.narrower_friction import in_narrower_transition
from motofmi.gap.selection.result import Verdict
from motofmi.recordings.recording import Recording
from motofmi.workflows.gap.limitations import limitations_of

RATE, SUBSTEPS = 200, 20  # samples per second, and simulation steps per sample
MASS, STIFFNESS, DAMPING, FRICTION = 1.0, 400.0, 3.0, 2.0


def record(seed: int, duration: float = 30.0, width: float = 0.0) -> Recording:
    """A mass under a random force of 2.5 N (rms) up to 6 Hz, with exact friction, or with a transition of that width
    [m/s]."""
    rng, step = np.random.default_rng(seed), 1 / RATE / SUBSTEPS
    force = sosfiltfilt(butter(4, 6.0, fs=1 / step, output="sos"), rng.standard_normal(int(duration / step)))
    force *= 2.5 / force.std()
    x, v, limit, places = 0.0, 0.0, step * FRICTION / MASS, np.empty(len(force))
    for i, u in enumerate(force):
        places[i] = x
        free = v + step * (u - STIFFNESS * x - DAMPING * v) / MASS
        v = free - (limit * np.tanh(v / width) if width else np.clip(free, -limit, limit))
        x += step * v
    noisy = places[::SUBSTEPS] + 1e-6 * rng.standard_normal(len(places[::SUBSTEPS]))
    columns = {"force": force[::SUBSTEPS], "displacement": noisy}
    return Recording(f"run_{seed}", np.arange(len(noisy)) / RATE, columns, {"force": "N", "displacement": "m"})


def fitted(recording: Recording, effect: type[CoulombFriction], **starts: float):
    """The base, and the fit of an effect in the wide transition."""
    experiment = input_output_experiment(MassSpringDamper(), ["force", "displacement"])
    run = prepare_sampled_run(recording, experiment)
    rate = np.gradient(recording["displacement"], 1 / RATE)
    experiment = experiment.scaled(float(np.abs(recording["displacement"]).max()), float(np.abs(rate).max()))
    model = FreeInitialStateModel(experiment)
    base = fit(model, [run], model.start())
    joined = model.with_added_effects(effect)
    own = {"friction_torque": FRICTION, **starts}
    start = np.concatenate([base.x[: len(model.names)], [own[n] for n in effect.free_parameters()]])
    return base, fit(joined, [run], start)


@pytest.fixture(scope="module")
def stick():
    return fitted(record(4), CoulombFriction)


def friction_of(found) -> float:
    return parameters_of_effect(found, found.model.effects[0])["friction_torque"][0]


@pytest.mark.parametrize("effect, starts", [
    (CoulombFriction, {}), (StribeckFriction, {"breakaway": 0.5, "stribeck_rate": 0.02}),
])  # fmt: skip
def test_narrower_transitions_give_the_friction_of_a_mass_that_sticks(effect, starts):
    """Both forms err by more than 1 % in the wide transition, one above and one below."""
    _, wide = fitted(record(5), effect, **starts)
    (narrow,) = worth_narrowing(wide, [wide], 40)
    assert wide.chi2 > 5 * narrow.chi2
    # Sliding begins between samples, and the force there is interpolated.
    assert friction_of(narrow) == pytest.approx(FRICTION, rel=0.005)
    assert abs(friction_of(wide) - FRICTION) > 0.01 * FRICTION


def test_a_transition_that_is_as_wide_is_not_narrowed():
    """1 % of the largest rate of 0.6 m/s is 0.006 m/s."""
    _, wide = fitted(record(2, width=0.012), CoulombFriction)
    assert worth_narrowing(wide, [wide], 40) == []


def test_few_blocks_do_not_show_a_narrower_transition(stick):
    """A single block has ln 1 = 0 for each parameter: any decrease is enough. In the noise that the fit leaves, a
    decrease of chi-square to 95 % is none on 40 blocks: 40 ln 0.95 = -2 > -ln 40."""
    _, wide = stick
    narrow, *_ = worth_narrowing(wide, [wide], 40)
    near = wide.with_scaled_noise(wide.chi2 / (narrow.chi2 / 0.95))  # the same fit with nearly the narrow chi-square
    assert worth_narrowing(near, [wide], 40) == [] and len(worth_narrowing(near, [wide], 1)) == 1


def test_models_that_are_compared_are_narrowed_too(stick):
    base, wide = stick
    blocks = CommonBlocks(wide, [prepare_sampled_run(record(3), wide.model.experiment)], Criteria())
    models = [blocks.evaluated(wide), blocks.evaluated(base)]
    (narrow,) = with_narrower_transitions(blocks, models)
    assert narrow.effects == (CoulombFriction,)
    assert narrow.losses.mean() < models[0].losses.mean() - np.log(10)  # a tenth of the mean square on left-out blocks
    assert friction_of(narrow.fit) == pytest.approx(FRICTION, rel=0.005)


def test_an_excess_near_standstill_gives_way_to_a_narrower_transition(stick):
    """In the wide transition a Stribeck curve takes the place of the missing stick."""
    base, coulomb = stick
    _, stribeck = fitted(record(4), StribeckFriction, breakaway=0.5, stribeck_rate=0.02)
    assert stribeck.chi2 < coulomb.chi2 and has_transition(stribeck.model.effects)
    candidates = [Candidate.gained(base, f.model.effects[0], f) for f in (stribeck, coulomb)]
    wide = Verdict("named", base, stribeck, candidates[:1], candidates=candidates, criteria=Criteria())
    verdict = in_narrower_transition(wide, [prepare_sampled_run(record(3), stribeck.model.experiment)])
    assert [c.effect for c in verdict.effects] == [CoulombFriction] == list(verdict.best.model.effects)
    assert verdict.candidates[0].effect is CoulombFriction and verdict.validation_gap is not None
    assert friction_of(verdict.best) == pytest.approx(FRICTION, rel=0.005)
    found = Investigation(verdict, verdict.best.model.experiment, 1.0, 0.0)
    said, unsaid = (
        limitations_of(each, {"noise_source": "given", "verdict": "named"}, MassSpringDamper(), held=False)
        for each in (found, replace(found, verdict=wide))
    )
    # 1 % of the largest rate, multiplied by 0.7 twelve times, and by the square root of it
    (sentence,) = (each for each in said if "within 0.00011 m/s" in each and "(0.0098 m/s)" in each)
    assert "that the wider one leaves" in sentence
    assert not any("within" in sentence for sentence in unsaid)
    unnamed = wide.as_unknown()
    assert in_narrower_transition(unnamed, []) is unnamed


def test_an_imposed_motion_keeps_its_transition():
    experiment = input_output_experiment(MassSpringDamper(), ["force", "displacement"], "displacement").scaled(0.1, 2.0)
    assert experiment.least_sliding_rate == experiment.sliding_rate == 0.002


@pytest.mark.slow
@pytest.mark.parametrize("seed, compared", [(4, True), (7, False)], ids=["by comparison", "by chi-square"])
def test_a_verdict_has_the_narrower_transition(seed, compared):
    experiment = input_output_experiment(MassSpringDamper(), ["force", "displacement"])
    fitted_run, validation = record(seed, duration=15.0), record(3, duration=15.0)
    found = investigate(experiment, [prepare_sampled_run(fitted_run, experiment)], validation=[validation],
                        library=[CoulombFriction, StribeckFriction]).verdict  # fmt: skip
    assert found.verdict == "named" and (found.comparison is not None) is compared
    assert [c.effect.form for c in found.effects] == ["coulomb"]
    wide, narrow = (each.model.experiment.sliding_rate for each in (found.base, found.best))
    assert narrow < wide / 5
    assert friction_of(found.best) == pytest.approx(FRICTION, rel=0.005)
