"""What a test could name, and which run resolves a tie: predicted, then simulated independently and evaluated."""

from types import SimpleNamespace

import numpy as np
import pytest

from motofmi.frequency_response.excitation import sweep as planned_sweep
from motofmi.gap.criteria import Criteria
from motofmi.gap.estimation.fitting import fit
from motofmi.gap.experiment_design.detectable_effects import detectable_effects
from motofmi.gap.experiment_design.discrimination import Prediction
from motofmi.gap.experiment_design.next_experiment import next_experiment
from motofmi.gap.experiment_design.planned_run import Channels, planned
from motofmi.gap.localisation.harmonic_places import cells
from motofmi.gap.localisation.locating import locate
from motofmi.gap.models.harmonic_model import HarmonicModel
from motofmi.gap.preprocessing.steer_test_run import prepare_steer_test_run
from motofmi.gap.selection.model_selection import select_model
from motofmi.gap.selection.ties import equivalent
from motofmi.gap.verdict import as_result
from motofmi.workflows.gap.rig import rig_effects, rig_experiment, with_bare_bar
from motofmi.workflows.gap.rig_proposals import rig_proposals

pytest.importorskip("numba", reason="the simulator of the hidden effects is compiled by numba")
from tests.simulators.as_recordings import as_recording
from tests.simulators.hidden_rig import RIDER, Rig, record, sweep
from tests.simulators.rig_runs import RIG

TRIO = ("cross_inertia", "steer_stiffness", "steer_damping")
LINEAR = [e for e in rig_effects() if e.family in TRIO]


def made(hidden, seed=3, excitation=None, rider=RIDER):
    arrays = record(excitation or sweep(0.5, 12, 2, 100.0), hidden, rider, np.random.default_rng(seed), Rig())
    return prepare_steer_test_run(as_recording("run", arrays), "steer_angle", "steer_torque", "steer_angle_command")


@pytest.mark.slow
def test_the_predicted_detectable_magnitude_is_that_of_the_independent_simulator():
    """delta chi-square of friction and asymmetry as foreseen, against noise-free differences of the other simulator."""
    experiment = rig_experiment(RIG)
    model = HarmonicModel(experiment)
    noise = 0.2**2 + (400 / 4096) ** 2 / 12
    channels = Channels(128.0, float(np.radians(0.03)), lambda f: noise + 0 * f)
    run = planned(
        planned_sweep(0.5, 12.0, 100.0, np.radians(2)),
        channels,
        experiment.columns,
        lambda r: model.outputs(r, model.start(), slopes=False)[0],
    )
    library = [
        e for e in rig_effects() if e.family in ("coulomb_friction", "asymmetry") and e.form in ("coulomb", "bilinear")
    ]
    predictions = {n.effect.family: n for n in detectable_effects(fit(model, [run], model.start()), library)}
    without = made({})
    base = fit(model, [without], model.start())
    basis = np.linalg.qr(base.jacobian / np.linalg.norm(base.jacobian, axis=0))[0][: base.count]
    for family, hidden in (("coulomb_friction", {"Tc": 0.2}), ("asymmetry", {"ra": 0.01})):
        change = (made(hidden).data - without.data) / without.deviation
        change -= basis @ (basis.T @ change)
        # `detected` is where delta chi-square is 12 + ln n; remnant, quantisation and linearisation differ: 30 %
        needed = next(iter(hidden.values())) * np.sqrt((12 + np.log(base.count)) / (change @ change))
        assert predictions[family].detected == pytest.approx(needed, rel=0.3)


@pytest.mark.slow
def test_a_run_of_a_fast_rig_is_planned_at_the_rate_at_which_it_is_compared():
    model = HarmonicModel(rig_experiment(RIG))
    channels = Channels(600.0, float(np.radians(0.03)), lambda f: 0.04 + 0 * f)
    run = planned(
        planned_sweep(0.5, 4.0, 60.0, np.radians(2)),
        channels,
        model.experiment.columns,
        lambda r: model.outputs(r, model.start(), slopes=False)[0],
    )
    assert run.recording.rate == pytest.approx(300.0)
    assert fit(model, [run], model.start()).reduced == pytest.approx(
        1.0, abs=0.2
    )  # 320 numbers: 2.5 standard deviations


@pytest.mark.slow
def test_three_linear_effects_at_one_port_are_tied_and_hands_are_the_bars_own():
    experiment = rig_experiment({})
    model = HarmonicModel(experiment)
    channels = Channels(128.0, float(np.radians(0.03)), lambda f: 0.04 + 0 * f)
    run = planned(
        planned_sweep(0.5, 12.0, 60.0, np.radians(2)),
        channels,
        experiment.columns,
        lambda r: model.outputs(r, model.start(), slopes=False)[0],
    )
    found = {
        n.effect.family: n
        for n in detectable_effects(
            fit(model, [run], model.start()), [*LINEAR, *(e for e in rig_effects() if e.family == "added_inertia")]
        )
    }
    # seven coefficients, six parameters of the base; a damper's opposite sign is no rival to a spring
    assert "cross_inertia" in found["steer_stiffness"].tied
    assert "cross_inertia" in found["steer_damping"].tied
    assert found["steer_damping"].named is None
    assert found["added_inertia"].detected is None


@pytest.mark.study
def test_a_tie_is_settled_by_the_run_that_was_proposed():
    hidden = {"ks": 40.0}
    experiment, run = rig_experiment({}), made(hidden)
    verdict = select_model(HarmonicModel(experiment), [run, made(hidden, 4, sweep(12, 0.5, 3.5, 100.0))], LINEAR)
    assert verdict.verdict == "tied"
    assert {"steer_stiffness", "cross_inertia"} <= {c.family for c in verdict.tied}
    proposed = next_experiment(verdict, rig_proposals)
    assert proposed["experiment"].startswith("bare_bar")
    assert proposed["expected_delta_chi2"] > 40
    settings = proposed["runs"][0]["settings"]
    bar = {"Is": RIDER["Is"], "It": 1e6, "ka": 1e-6, "kt": 1.0, "ca": 1e-6, "ct": 1.0}
    bare = made(
        hidden, 5, sweep(settings["from"], settings["to"], np.degrees(settings["amplitude"]), settings["duration"]), bar
    )
    settled = select_model(HarmonicModel(with_bare_bar(experiment, [bare])), list(verdict.best.runs), LINEAR)
    assert [c.family for c in settled.effects] == ["steer_stiffness"]


@pytest.mark.slow
def test_effects_that_differ_only_by_the_sign_are_reported_with_the_named_one():
    run = made({"cs": 1.5})
    verdict = select_model(HarmonicModel(rig_experiment(RIG)), [run], LINEAR)
    assert [c.family for c in verdict.effects] == ["steer_damping"]
    assert set(equivalent(verdict.best, verdict.effects[0], verdict.candidates)) == {"cross_inertia", "steer_stiffness"}
    said = [s for s in as_result(verdict, "N.m")["limitations"] if s.startswith("In these recordings ")]
    assert len(said) == 1 and "is not distinguishable from steer_damping" in said[0]


@pytest.mark.slow
def test_harmonics_distinguish_a_progressive_damper_from_linear_effects():
    run = made({"c2": 1.0})
    verdict = select_model(
        HarmonicModel(rig_experiment(RIG)),
        [run],
        [*LINEAR, *(e for e in rig_effects() if e.family == "progressive_damping")],
    )
    assert [c.family for c in verdict.effects] == ["progressive_damping"]
    assert equivalent(verdict.best, verdict.effects[0], verdict.candidates) == []


@pytest.mark.study
def test_no_place_is_found_where_nothing_is_hidden():
    """400 places of ten riders; at a false-discovery rate of 1 % one of them in ten such tests would be false."""
    model = HarmonicModel(rig_experiment(RIG))
    fits = [fit(model, [made({}, seed)], model.start()) for seed in range(10)]
    assert [p for found in fits for p in locate(found, cells)] == []
    p_values = np.array([p.p_value for found in fits for p in locate(found, cells, Criteria(false_discovery_rate=1.0))])
    # of 300 and more, 5 % and four of their deviations, (0.05 0.95 / 300)^0.5 = 0.0126
    assert np.mean(p_values < 0.05) < 0.05 + 4 * 0.0126


def candidate(family, delta_bic):
    """A fitted effect beside one parameter of the base, on which no planned run depends."""
    effect = type(family, (), {"family": family})
    model = SimpleNamespace(effects=(effect,), names=["stiffness"], base=["stiffness"], rows=[])
    found = SimpleNamespace(model=model, x=np.zeros(1), jacobian=np.eye(1))
    return SimpleNamespace(effect=effect, family=family, fit=found, delta_bic=delta_bic)


def tied_by(*delta_bic):
    """A verdict that ties spring and reflex; further candidates are a head and a drift."""
    found = [candidate(*each) for each in zip(("spring", "reflex", "head", "drift"), delta_bic, strict=True)]
    return SimpleNamespace(verdict="tied", tied=found[:2], candidates=found, base=None, criteria=Criteria())


def proposal(name, predicted, left=np.inf):
    """A planned run: data over the noise by family, and the delta chi-square that refitted rivals leave."""
    return SimpleNamespace(
        experiment=name,
        sentence=f"Run {name}.",
        settings={},
        predict=lambda rival: Prediction(np.array(predicted[rival.model.effects[0].family]), np.zeros((3, 1))),
        left=lambda truth, rival, enough: left,
    )


def test_what_is_near_a_tie_is_a_rival_and_what_is_far_is_none():
    families = ("spring", "reflex", "head", "drift")
    every = proposal("every", dict(zip(families, 10.0 * np.eye(4, 3), strict=True)))
    found = next_experiment(tied_by(99.0, 91.0, 70.0, 40.0), lambda base: [every])
    assert list(dict.fromkeys(row["truth"] for row in found["rivals"])) == ["spring", "reflex", "head"]


def test_the_members_of_a_tie_are_distinguished_before_near_rivals():
    families, verdict = ("spring", "reflex", "head"), tied_by(99.0, 91.0, 70.0, 40.0)
    # Delta chi-square: 35 between every two in the gyro's run, 300 between the spring and the others with the bare bar.
    gyro = proposal("gyro", dict(zip(families, np.sqrt(17.5) * np.eye(3), strict=True)))
    at_bar = dict(zip(families, np.sqrt(300.0) * np.array([[1, 0, 0], [0, 0, 0], [0, 0, 0]]), strict=True))
    # The gyro distinguishes all pairs a little, but only the bare bar separates the two of the tie.
    found = next_experiment(verdict, lambda base: [gyro, proposal("bare_bar", at_bar)])
    assert [run["experiment"] for run in found["runs"]] == ["bare_bar", "gyro"]
    assert {(r["truth"], r["rival"]): r["delta_chi2"] for r in found["rivals"]}["spring", "reflex"] == pytest.approx(335)
    # A rival that is refitted to the data of the bare bar leaves nothing there.
    found = next_experiment(verdict, lambda base: [gyro, proposal("bare_bar", at_bar, left=0.0)])
    assert [run["experiment"] for run in found["runs"]] == ["gyro"]
