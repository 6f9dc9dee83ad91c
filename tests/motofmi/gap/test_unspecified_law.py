"""Laws outside the library: they replace a named effect, and describe what is there instead."""

import json

import pytest

from motofmi.cli.main import main
from motofmi.gap.criteria import Criteria
from motofmi.gap.estimation import effect_fit
from motofmi.gap.estimation.fit_result import parameters_of
from motofmi.gap.estimation.laws_outside_library import laws_outside_library
from motofmi.gap.estimation.multi_start import fit_base
from motofmi.gap.estimation.screening import screen
from motofmi.gap.experiment_design.next_experiment import next_experiment
from motofmi.gap.models.harmonic_model import HarmonicModel
from motofmi.gap.selection.model_selection import select_model
from motofmi.gap.verdict import as_result
from motofmi.recordings.reading import write_recording
from motofmi.workflows.gap.rig import rig_effects, rig_experiment

pytest.importorskip("numba", reason="the simulator of the hidden effects is compiled by numba")
import numpy as np

from tests.simulators.hidden_joint import JOINT, joint_run
from tests.simulators.hidden_rig import sweep
from tests.simulators.rig_runs import RIG, library, runs_of


@pytest.mark.study
def test_a_law_outside_the_library_replaces_a_named_effect(monkeypatch):
    """A damping that is larger to one side: a sensor with unequal gains fits to within the noise, but is not the
    cause."""
    runs = runs_of({"bx": 0.7}, sweep(0.5, 12, 2, 100.0), sweep(12, 0.5, 3.0, 80.0))
    some = library("hardening_stiffness", "sensor_nonlinearity", "asymmetry")
    verdict = select_model(HarmonicModel(rig_experiment(RIG)), runs[:1], some, runs[1:])
    assert (verdict.verdict, verdict.effects, verdict.outside_library.effect.form) == ("unknown", [], "product")
    assert any(
        "the damping is larger to one side" in sentence.lower() for sentence in as_result(verdict, "N.m")["limitations"]
    )
    assert "outside_library" in {rival["rival"] for rival in next_experiment(verdict)["rivals"]}
    monkeypatch.setattr("motofmi.gap.selection.model_selection.better_outside_library", lambda *_, **__: None)
    assert select_model(HarmonicModel(rig_experiment(RIG)), runs[:1], some, runs[1:]).verdict == "named"


@pytest.mark.slow
def test_an_unknown_effect_has_an_unspecified_form():
    """Arms that soften, in a library in which nothing comes near: the law says what it is, and no name is given."""
    runs = runs_of({"k3": -2300.0}, sweep(0.5, 12, 2.5, 100.0), sweep(12, 0.5, 3.2, 100.0))
    verdict = select_model(HarmonicModel(rig_experiment(RIG)), runs[:1], library("hardening_stiffness"), runs[1:])
    assert (verdict.verdict, verdict.effects, verdict.outside_library.effect.form) == ("unknown", [], "softening")
    size, error, _ = parameters_of(verdict.outside_library.fit)["device.outside_library.size"]
    assert size == pytest.approx(2300, abs=3 * error) and error < 150
    assert any("spring softens" in sentence for sentence in as_result(verdict, "N.m")["limitations"])


@pytest.mark.slow
def test_a_bar_whose_inertia_grows_with_its_angle_is_unknown_and_said_to():
    """Under a sine of amplitude a, j (q^2 q'' + q q'^2) has a third harmonic twice that of j q q'^2, and first
    harmonics are the base's inertia."""
    runs = runs_of({"ji": 1.5}, sweep(0.5, 10, 3.0, 60.0), sweep(10, 0.5, 4.0, 60.0))
    verdict = select_model(
        HarmonicModel(rig_experiment(RIG)),
        runs[:1],
        library("sensor_nonlinearity", "coulomb_friction", "channel_delay"),
        runs[1:],
    )
    assert (verdict.verdict, verdict.effects, verdict.outside_library.effect.form) == ("unknown", [], "centrifugal")
    size, error, _ = parameters_of(verdict.outside_library.fit)["device.outside_library.size"]
    assert size == pytest.approx(3.0, abs=3 * error) and error < 0.3
    assert any(
        "a variable inertia" in sentence for sentence in as_result(verdict, "N.m")["limitations"]
    )


@pytest.mark.slow
@pytest.mark.parametrize("lag", [0.3, -0.3])
def test_hysteresis_of_a_sensor_is_explained_by_its_own_law(lag):
    """A slider of 5 N.m between load and reading, which the simulator adds: with either sign the law gains most of the
    gap."""
    runs = runs_of({"hs": lag}, sweep(0.5, 12, 2, 100.0))
    base = fit_base(HarmonicModel(rig_experiment(RIG)), runs)
    law = next(law for law in laws_outside_library(rig_effects()) if law.form == "sensor_memory")
    found = effect_fit.fit_each(base, screen(base, [law], keep=1), [], np.inf, [], Criteria())[0]
    assert found.delta_chi2 > 0.5 * (base.chi2 - base.freedom) > 50
    assert np.sign(found.fit.shared[len(base.model.names)]) == np.sign(lag)


@pytest.mark.slow
@pytest.mark.study
def test_a_joint_that_softens_is_unknown_and_said_to_soften(tmp_path, capsys):
    """A limit that clips comes near, and is not it; no pair is tried beside a law that leaves nothing."""
    hidden = {"hardening": -0.1 * JOINT["k"]}
    for name, seed in (("fit", 4), ("held", 5)):
        write_recording(joint_run(hidden, "random", seed, 30.0, name=name), tmp_path / f"{name}.csv")
    fit, held = (str(tmp_path / f"{name}.csv") for name in ("fit", "held"))
    assert main(["gap", fit, "--component", "driven_joint", "--holdout", held, "--out", str(tmp_path / "out")]) == 0
    result = json.loads((tmp_path / "out" / "verdict.json").read_text("utf-8"))
    assert (result["verdict"], result["effects"]) == ("unknown", [])
    assert any("outside the library" in sentence and "spring softens" in sentence for sentence in result["limitations"])
