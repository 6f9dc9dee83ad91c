"""Laws that no effect of the library names: they take names back, and say what is there instead."""

import json

import pytest

from identification.gap.models.model import Model
from identification.gap.naming import joining
from identification.gap.naming.decide import decide
from identification.gap.naming.fitted import parameters_of
from identification.gap.naming.screening import screen
from identification.gap.naming.starting import fit_base
from identification.gap.naming.unlisted import unlisted_laws
from identification.gap.proposing.next_test import next_experiment
from identification.gap.reporting.verdict import as_result
from identification.recordings import write_recording
from scenarios.command_line import main
from scenarios.rig_test import rig_effects, rig_test

pytest.importorskip("numba", reason="the simulator of the hidden effects is compiled by numba")
import numpy as np
from simulators.hidden_joint import JOINT, joint_run
from simulators.hidden_rig import sweep
from simulators.rig_runs import RIG, library, runs_of


def test_a_law_without_a_name_takes_a_name_back(monkeypatch):
    """A damping that is larger to one side: a sensor that is lopsided fits as well as noise lets it, and is not it."""
    runs = runs_of({"bx": 0.7}, sweep(0.5, 12, 2, 100.0), sweep(12, 0.5, 3.0, 80.0))
    some = library("hardening_stiffness", "sensor_nonlinearity", "asymmetry")
    verdict = decide(Model(rig_test(RIG)), runs[:1], some, runs[1:])
    assert (verdict.verdict, verdict.effects, verdict.unlisted.effect.form) == ("unknown", [], "product")
    assert any("the damping is larger to one side" in sentence.lower() for sentence in as_result(verdict, "N.m")["limitations"])
    assert "unlisted" in {rival["rival"] for rival in next_experiment(verdict)["rivals"]}
    monkeypatch.setattr("identification.gap.naming.decide.better_unlisted", lambda *_, **__: None)
    assert decide(Model(rig_test(RIG)), runs[:1], some, runs[1:]).verdict == "named"


def test_what_is_unknown_may_be_a_law_without_a_name():
    """Arms that soften, in a library in which nothing comes near: the law says what it is, and no name is given."""
    runs = runs_of({"k3": -2300.0}, sweep(0.5, 12, 2.5, 100.0), sweep(12, 0.5, 3.2, 100.0))
    verdict = decide(Model(rig_test(RIG)), runs[:1], library("hardening_stiffness"), runs[1:])
    assert (verdict.verdict, verdict.effects, verdict.unlisted.effect.form) == ("unknown", [], "softening")
    size, error, _ = parameters_of(verdict.unlisted.fit)["device.unlisted.size"]
    assert size == pytest.approx(2300, abs=3 * error) and error < 150
    assert any("spring softens" in sentence for sentence in as_result(verdict, "N.m")["limitations"])


def test_a_bar_whose_inertia_grows_with_its_angle_is_unknown_and_said_to():
    """Under a sine of amplitude a, j (q^2 q'' + q q'^2) has a third harmonic twice that of j q q'^2, and first harmonics are the base's inertia."""
    runs = runs_of({"ji": 1.5}, sweep(0.5, 10, 3.0, 60.0), sweep(10, 0.5, 4.0, 60.0))
    verdict = decide(Model(rig_test(RIG)), runs[:1], library("sensor_nonlinearity", "coulomb_friction", "channel_delay"), runs[1:])
    assert (verdict.verdict, verdict.effects, verdict.unlisted.effect.form) == ("unknown", [], "centrifugal")
    size, error, _ = parameters_of(verdict.unlisted.fit)["device.unlisted.size"]
    assert size == pytest.approx(3.0, abs=3 * error) and error < 0.3
    assert any("an inertia that changes with the angle" in sentence for sentence in as_result(verdict, "N.m")["limitations"])


@pytest.mark.parametrize("lag", [0.3, -0.3])
def test_a_sensor_that_lags_behind_its_load_is_told_by_its_own_law(lag):
    """A slider of 5 N.m between load and reading, which the simulator adds: with either sign the law gains most of the gap."""
    runs = runs_of({"hs": lag}, sweep(0.5, 12, 2, 100.0))
    base = fit_base(Model(rig_test(RIG)), runs)
    law = next(law for law in unlisted_laws(rig_effects()) if law.form == "sensor_memory")
    found = joining.fit_each(base, screen(base, [law], keep=1), [], np.inf, [])[0]
    assert found.delta_chi2 > 0.5 * (base.chi2 - base.freedom) > 50
    assert np.sign(found.fit.shared[len(base.model.names)]) == np.sign(lag)


def test_a_joint_that_softens_is_unknown_and_said_to_soften(tmp_path, capsys):
    """A limit that clips comes near, and is not it; no pair is tried beside a law that leaves nothing."""
    hidden = {"hardening": -0.1 * JOINT["k"]}
    for name, seed in (("fit", 4), ("held", 5)):
        write_recording(joint_run(hidden, "random", seed, 30.0, name=name), tmp_path / f"{name}.csv")
    fit, held = (str(tmp_path / f"{name}.csv") for name in ("fit", "held"))
    assert main(["gap", fit, "--component", "driven_joint", "--holdout", held, "--out", str(tmp_path / "out")]) == 0
    result = json.loads((tmp_path / "out" / "verdict.json").read_text("utf-8"))
    assert (result["verdict"], result["effects"]) == ("unknown", [])
    assert any("has no name" in sentence and "spring softens" in sentence for sentence in result["limitations"])
