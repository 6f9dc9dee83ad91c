"""FMUs through fmpy, as an importer uses them: against exact solutions, and both back ends against each other."""

import os
import re
from dataclasses import replace

import fmpy
import numpy as np
import pytest
from fmpy.validation import validate_fmu

from fmus.export.build import build
from fmus.export.compilers import host_compiler
from fmus.support.errors import InputError, MissingToolError
from rider_fmu import riders
from tests import as_study
from tests.importer import COMPONENTS, drive_of, held_solution
from vehicle_fmu import motorcycles


@pytest.mark.slow
@pytest.mark.parametrize("name", COMPONENTS)
@pytest.mark.parametrize("backend", ["compiled", as_study("python")])
def test_steps_are_the_exact_solution_with_held_inputs(name, backend, opened):
    component = COMPONENTS[name]()
    start = {n: 0.1 * row.nominal for n, row in component.rows("state").items()}
    fmu = opened(component, backend=backend).start(**start)
    times = np.cumsum([0.0] + [0.01, 0.003, 0.02, 0.04] * 12)
    drive = drive_of(component)
    names = component.states + component.outputs
    found = fmu.run(times, drive, names)
    states = held_solution(component, times, drive, start)
    exact = np.array(
        [
            [*x, *component.derivatives(x, np.array(list(drive(t).values())), t)[1]]
            for t, x in zip(times, states, strict=True)
        ]
    )
    scale = np.abs(exact).max(axis=0) + 1e-12
    # Exact steps differ by roundings, which a fast mode amplifies; the nonlinear ones by their tolerance 1e-10 per
    # step.
    assert np.abs(found - exact).max(axis=0) / scale == pytest.approx(0, abs=1e-9)


@pytest.mark.slow
@pytest.mark.parametrize("name", COMPONENTS)
def test_both_back_ends_give_the_same_trajectory(name, opened):
    component = COMPONENTS[name]()
    names = component.states + component.outputs
    times, drive = np.linspace(0, 1, 201), drive_of(component)
    one, other = (opened(component, backend=b).start().run(times, drive, names) for b in ("compiled", "python"))
    assert one == pytest.approx(other, rel=1e-9, abs=1e-9 * np.abs(one).max())
    assert np.abs(one).max() > 0


@pytest.mark.slow
@pytest.mark.parametrize("name", COMPONENTS)
def test_model_exchange_gives_the_derivatives_of_the_equations(name, opened):
    component = COMPONENTS[name]()
    fmu = opened(component, exchange=True).start()
    random = np.random.default_rng(1)
    for _ in range(10):
        x, u = random.normal(size=len(component.states)), random.uniform(1, 30, len(component.inputs))
        time = random.uniform(0, 9)
        fmu.fmu.setTime(time)
        fmu.set(**dict(zip(component.inputs, u, strict=True)))
        rates, outputs = component.derivatives(x, u, time)
        if len(x):
            fmu.set_states(x)
        found = fmu.get(*(f"der({n})" for n in component.states), *component.outputs)
        # Sums in another order: a few roundings, weighed by the largest term.
        expected = np.concatenate([rates, outputs])
        assert found == pytest.approx(expected, rel=1e-9, abs=1e-11 * max(1, np.abs(expected).max()))


def test_model_exchange_and_cosimulation_agree_in_fmpy(tmp_path):
    path = build(motorcycles.load("sharp_1971"), tmp_path).path
    start = {"roll_angle": 0.05, "speed": 25.0}
    ends = [fmpy.simulate_fmu(path, fmi_type=kind, start_values=start, stop_time=0.5, relative_tolerance=1e-10, output=["roll_angle"])["roll_angle"][-1]
            for kind in ("ModelExchange", "CoSimulation")]  # fmt: skip
    assert ends[0] == pytest.approx(ends[1], rel=1e-6)  # the importer's integrator is held to 1e-10 per step


@pytest.mark.slow
@pytest.mark.parametrize("backend", ["compiled", "python"])
def test_builds_are_valid_and_identical_to_the_byte(backend, tmp_path, monkeypatch):
    component = riders.load("mean_2011")
    first = build(component, tmp_path / "one", backend=backend)
    monkeypatch.setenv("MOTOFMI_CACHE", str(tmp_path / "empty"))
    second = build(component, tmp_path / "two", backend=backend)
    assert validate_fmu(first.path) == []
    assert first.path.read_bytes() == second.path.read_bytes()
    assert second == replace(first, path=second.path)
    assert first.path.name == {"compiled": "rider_mean_2011.fmu", "python": "rider_mean_2011_python.fmu"}[backend]


@pytest.mark.slow
def test_another_value_gives_another_identifier(tmp_path):
    one, other = (build(riders.load("mean_2011", arm_damping=d), tmp_path) for d in (19.0, 20.0))
    assert one.sha256 != other.sha256


@pytest.mark.slow
@pytest.mark.skipif(os.name == "nt" or host_compiler() is None, reason="needs a shell and a C compiler")
def test_equations_are_compiled_once_and_each_fmu_has_its_own_values(tmp_path, monkeypatch):
    calls, compiler = tmp_path / "calls", tmp_path / "cc"
    compiler.write_text(f'#!/bin/sh\necho "$@" >> {calls}\nexec {host_compiler()[0]} "$@"\n')
    compiler.chmod(0o755)
    monkeypatch.setenv("CC", str(compiler))
    monkeypatch.setenv("MOTOFMI_CACHE", str(tmp_path / "empty"))
    dampings, torques = (19.0, 20.0), []
    for damping in dampings:
        path = build(riders.load("mean_2011", arm_damping=damping), tmp_path / f"{damping}").path
        torques.append(fmpy.simulate_fmu(str(path), stop_time=0.0, start_values={"steer_rate": 1.0}, output=["handlebar_torque"])[0][1])
    assert re.findall(r"-c (\S+)", calls.read_text()) == ["fmi2_fmu.c", "variables.c", "variables.c"]
    # at rest in all else the torque is arm_damping times the rate, whatever its sign
    assert np.abs(torques) == pytest.approx(dampings, rel=1e-12)


def test_wrong_choices_are_named(tmp_path):
    rider = riders.load("mean_2011")
    for options, message in (({"fmi": 4}, "FMI version"), ({"backend": "java"}, "back end"), ({"platforms": "amiga"}, "platform"),
                             ({"fmi": 3, "backend": "python"}, "FMI 2 only")):  # fmt: skip
        with pytest.raises(InputError, match=message):
            build(rider, tmp_path, **options)


def test_a_folder_that_cannot_be_written_is_named(tmp_path):
    (tmp_path / "file").write_text("")
    with pytest.raises(InputError, match="cannot write to folder"):
        build(riders.load("mean_2011"), tmp_path / "file")


@pytest.mark.usefixtures("without_compiler")
def test_without_a_compiler_the_error_says_how_to_get_one(tmp_path):
    assert host_compiler() is None
    with pytest.raises(MissingToolError, match=r"pip install motofmi\[platforms\]"):
        build(riders.load("mean_2011"), tmp_path / "out")
    assert list((tmp_path / "out").iterdir()) == []


def test_a_wrong_CC_is_named(tmp_path, monkeypatch):
    monkeypatch.setenv("CC", "no_such_compiler")
    with pytest.raises(InputError, match="no_such_compiler"):
        build(riders.load("mean_2011"), tmp_path)
