"""The command `gap` on runs of a component."""

import json

import numpy as np
import pytest

from benchmarks import gap_generic
from fmus.mechanisms import DrivenJoint
from fmus.support.errors import InputError
from motofmi.cli.main import main
from motofmi.gap.experiments.input_output import input_output_experiment
from motofmi.gap.preprocessing.sampled_run_preparation import prepare_sampled_run
from motofmi.gap.selection import noise_rounds
from motofmi.recordings.reading import write_recording
from motofmi.recordings.recording import Recording
from motofmi.workflows import components
from tests.motofmi.json_schemas import check_against_schema
from tests.simulators.hidden_joint import joint_run


def files(folder, hidden, kind="random"):
    for i, name in enumerate(("fit", "held")):
        write_recording(joint_run(hidden, kind, seed=9 + i, duration=8.0, name=name), folder / f"{name}.csv")
    return str(folder / "fit.csv"), str(folder / "held.csv")


@pytest.mark.slow
def test_the_command_writes_verdict_model_fmu_and_report(tmp_path, capsys):
    fit, held = files(tmp_path, {})
    out = tmp_path / "out"
    assert main(["gap", fit, "--component", "driven_joint", "--holdout", held, "--out", str(out)]) == 0
    result = json.loads((out / "verdict.json").read_text("utf-8"))
    check_against_schema("verdict", result)
    assert (result["verdict"], result["effects"], result["noise_source"]) == ("none", [], "flexible_model")
    assert any("flexible model" in sentence for sentence in result["limitations"])
    assert result["gap"]["holdout_after"] == pytest.approx(1.0, abs=0.5)
    assert all((out / result[key]).is_file() for key in ("model", "fmu", "report"))
    assert result["modes"]["after"][0]["frequency"][0] == pytest.approx(np.sqrt(14 / 0.08) / (2 * np.pi), rel=0.01)
    again = components.component(str(out / result["model"]))
    assert again.values["stiffness"] == pytest.approx(14.0, rel=0.02)


def test_a_run_and_its_experiment_are_shown_in_one_line():
    recording = joint_run({}, duration=6.0)
    experiment = input_output_experiment(DrivenJoint(), list(recording.columns))
    assert repr(prepare_sampled_run(recording, experiment)) == (
        "SampledRun('run', 600 samples, inputs torque, outputs angle)"
    )
    assert repr(experiment) == "InputOutputExperiment('DrivenJoint', inputs torque, outputs angle)"


@pytest.mark.slow
@pytest.mark.study
def test_a_fast_recording_reduced_while_it_is_read_has_the_verdict_of_a_slow_one(tmp_path):
    found = []
    for rate, options in ((800.0, ["--rate", "100"]), (100.0, [])):
        path = tmp_path / f"at_{rate:g}.csv"
        write_recording(joint_run({"friction": 0.3}, seed=5, duration=6.0, rate=rate), path)
        out = tmp_path / f"out_{rate:g}"
        assert main(["gap", str(path), "--component", "driven_joint", *options, "--out", str(out)]) == 0
        found.append(json.loads((out / "verdict.json").read_text("utf-8")))
    fast, slow = found
    assert fast["verdict"] == slow["verdict"] == "named"
    fast_effect, slow_effect = (verdict["effects"][0] for verdict in found)
    assert fast_effect["name"] == slow_effect["name"] == "coulomb_friction"
    reduced, sampled = (e["parameters"]["friction_torque"] for e in (fast_effect, slow_effect))
    scatter = np.hypot(reduced["standard_error"], sampled["standard_error"])
    assert abs(reduced["value"] - sampled["value"]) < 4 * scatter
    # Neither recording resolves the width of the friction: the filter widens its step to about a sample, in which the
    # rate changes by up to this.
    angle = joint_run({"friction": 0.3}, seed=5, duration=6.0, noise=0.0)["angle"]
    resolved = np.abs(np.diff(angle, 2)).max() * 100.0
    for effect in (fast_effect, slow_effect):
        assert effect["parameters"].get("sliding_rate", {"value": 0.0})["value"] < resolved
    assert any("appear wider" in sentence for sentence in fast["limitations"])


@pytest.mark.slow
def test_an_interrupted_run_leaves_what_it_had(tmp_path, monkeypatch, capsys):
    fit, _ = files(tmp_path, {})

    def interrupted(*_, **__):
        raise KeyboardInterrupt

    monkeypatch.setattr(noise_rounds, "select_model", interrupted)
    assert main(["gap", fit, "--component", "driven_joint", "--out", str(tmp_path / "out")]) == 130
    left = json.loads((tmp_path / "out" / "verdict.json").read_text("utf-8"))
    check_against_schema("verdict", left)
    assert (left["verdict"], left["effects"]) == ("unknown", [])
    assert "Interrupted" in left["limitations"][0]
    assert left["base"]["stiffness"]["value"] == pytest.approx(14.0, rel=0.02)


@pytest.mark.study
def test_the_study_of_blind_cases_counts_them():
    result = gap_generic.run(lambda numbers, _: numbers, cases=1)
    assert (result["cases"], result["settings"], result["confusion"]) == (
        1,
        {"mass_spring_damper": 1},
        {"none -> none": 1},
    )
    assert result["rates"]["nothing hidden: false alarms"]["rate"] == 0.0


OWN = '''from fmus import Component, input, output, parameter, state


class Gearbox(Component):
    """A gearbox on a spring that names no elements."""

    inertia = parameter("kg.m2", "Inertia", symbol="J", min=1e-6, max=100, start=0.05)
    stiffness = parameter("N.m/rad", "Stiffness", symbol="k", min=0, max=1e5, start=10.0)
    torque = input("N.m", "Torque", symbol="T")
    angle = state("rad", "Angle", symbol="q")
    rate = state("rad/s", "Rate", symbol="s")
    shaft_angle = output("rad", "Angle of the shaft", symbol="y")

    def equations(self, v, m):
        return {"der(angle)": v.rate, "der(rate)": (v.torque - v.stiffness * v.angle) / v.inertia, "shaft_angle": v.angle}
'''


def test_a_value_file_of_a_users_own_component_holds_its_effects(tmp_path):
    (tmp_path / "bench.py").write_text(OWN)
    (tmp_path / "fitted.toml").write_text(
        'component = "Gearbox"\ncomponent_file = "bench.py"\neffects = ["coulomb_friction.coulomb"]\n[parameters]\nstiffness = 12.0\n'
        '"coulomb_friction.friction_torque" = 0.5\n"coulomb_friction.sliding_rate" = 0.001\n')  # fmt: skip
    component = components.component(str(tmp_path / "fitted.toml"))
    rates, outputs = component.derivatives(np.array([0.1, 2.0]), np.array([3.0]))
    assert rates == pytest.approx([2.0, (3.0 - 1.2 - 0.5) / 0.05])
    assert outputs == pytest.approx([0.1])
    with pytest.raises(InputError, match=r"unknown component in .*bench\.py 'Gear'"):
        components.component_class(f"{tmp_path / 'bench.py'}:Gear")


@pytest.mark.slow
def test_recordings_that_cannot_be_used_are_refused(tmp_path, capsys):
    fit, _ = files(tmp_path, {})
    recording = joint_run({}, duration=8.0)

    def refused(*words, expected):
        assert main(["gap", *words, "--out", str(tmp_path / "out")]) == 2
        error = capsys.readouterr().err
        assert expected in error and "Traceback" not in error

    def changed(name, **columns):
        path = tmp_path / f"{name}.csv"
        units = {n: recording.units.get(n, "1") for n in columns}
        write_recording(Recording(name, recording.time, columns, units), path)
        return str(path)

    angle, torque = recording["angle"], recording["torque"]
    refused(fit, "--component", "driven_join", expected="unknown component")
    refused(fit, "--component", "driven_joint", "--impose", "torque", expected="--impose")
    refused(fit, "--component", "driven_joint", "--free", "mass", expected="--free")
    refused(changed("constant", torque=torque, angle=0 * angle), "--component", "driven_joint", expected="constant")
    refused(
        changed("still", torque=torque, angle=1e-3 * np.random.default_rng(0).standard_normal(len(angle))),
        "--component",
        "driven_joint",
        expected="no excitation",
    )
    refused(changed("nothing", torque=torque), "--component", "driven_joint", expected="no column is an output")
    short = Recording("short", recording.time[:80], {n: y[:80] for n, y in recording.columns.items()}, recording.units)
    write_recording(short, tmp_path / "short.csv")
    refused(str(tmp_path / "short.csv"), "--component", "driven_joint", expected="too few")
    refused(fit, "--component", str(tmp_path / "mine.py:Thing"), expected="no such file")


@pytest.mark.parametrize("wrong, reason", [
    ("v.shaft_angle = v.angle", "Gearbox sets 'shaft_angle', .* the equations return the values of outputs"),
    ("v.angel", "unknown variable of Gearbox 'angel', did you mean 'angle'"),
    ("m.bessel(v.angle)", "AttributeError: .*bessel"),
    ("deflection", "NameError: name 'deflection' is not defined"),
])  # fmt: skip
def test_equations_of_a_users_own_component_that_use_what_does_not_exist_are_refused(tmp_path, wrong, reason):
    written = OWN.replace("        return {", f"        {wrong}\n        return {{")
    (tmp_path / "bench.py").write_text(written)
    line = written.split(wrong)[0].count("\n") + 1
    with pytest.raises(InputError, match=rf"bench\.py, line {line}: .*{reason}"):
        components.component(f"{tmp_path / 'bench.py'}:Gearbox")


def test_a_file_that_cannot_be_loaded_is_refused_with_its_line(tmp_path):
    (tmp_path / "bench.py").write_text(OWN + "\nSPARE = Gearbo()\n")
    line = OWN.count("\n") + 2
    with pytest.raises(InputError, match=rf"cannot load .*bench\.py, line {line}: NameError: .*Gearbo"):
        components.component(f"{tmp_path / 'bench.py'}:Gearbox")
