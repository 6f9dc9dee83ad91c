"""Any FMU as a subsystem: its capabilities, its outputs, and what it refuses."""

import re
import tempfile
import zipfile

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import motofmi as mf
from fmus.cosimulation.ssp import read_ssp, write_ssp
from fmus.cosimulation.subsystems.fmu_subsystem import FmuSubsystem, model_description
from fmus.export.build import build
from fmus.support.errors import InputError, SimulationError
from rider_fmu import riders
from vehicle_fmu import motorcycles


@pytest.fixture
def subsystem(tmp_path):
    """Opens a component's FMU as a subsystem: subsystem(component, values, **options of build)."""
    made = []

    def open_subsystem(component, values=None, **options):
        made.append(FmuSubsystem(build(component, tmp_path, **options).path, "subsystem", values))
        return made[-1]

    yield open_subsystem
    for each in made:
        each.close()


RIDER = riders.load("mean_2011")


@pytest.mark.slow
@pytest.mark.parametrize("options", [{}, {"fmi": 3}, {"backend": "python"}], ids=str)
def test_outputs_follow_the_inputs_without_a_step(subsystem, options):
    rider = subsystem(RIDER, **options)
    p = RIDER.values
    outputs = dict(zip(rider.outputs, rider.exchange(np.array([0.1, 0.2, 0.3])), strict=True))
    # At rest: T_a = -k_a delta - c_a (w + s), T_w = -c_t w.
    assert outputs["handlebar_torque"] == pytest.approx(-p["arm_stiffness"] * 0.1 - p["arm_damping"] * 0.5, rel=1e-12)
    assert outputs["frame_torque"] == pytest.approx(-p["waist_damping"] * 0.3, rel=1e-12)


@pytest.mark.slow
@pytest.mark.parametrize("fmi", [2, 3])
@pytest.mark.parametrize("order", [0, 1, 2, 3])
def test_a_step_with_polynomial_inputs_solves_the_equations(subsystem, order, fmi):
    rider = subsystem(RIDER, fmi=fmi)
    coefficients = np.zeros((4, 3))
    coefficients[: order + 1] = np.arange(1.0, 3 * (order + 1) + 1).reshape(-1, 3) / 10
    step = 0.05

    def rates(time, state):
        powers = (time / step) ** np.arange(4)
        return RIDER.derivatives(state, powers @ coefficients)[0]

    solution = solve_ivp(rates, (0, step), np.zeros(2), rtol=1e-11, atol=1e-12, method="DOP853")
    rider.step(coefficients, step)
    assert rider.state_values() == pytest.approx(solution.y[:, -1], rel=1e-9)  # of the integrator


@pytest.mark.slow
@pytest.mark.parametrize("fmi", [2, 3])
def test_going_back_repeats_a_step_to_the_bit(subsystem, fmi):
    rider = subsystem(RIDER, fmi=fmi)
    coefficients = np.vstack([np.ones(3), np.zeros((3, 3))])
    rider.step(coefficients, 0.01)
    saved = rider.save()
    rider.step(coefficients, 0.01)
    first = rider.state_values().copy()
    rider.restore(saved)
    assert rider.time == 0.01
    rider.step(coefficients, 0.01)
    assert np.array_equal(first, rider.state_values())


@pytest.mark.slow
def test_abilities_are_what_the_archive_says(subsystem):
    compiled, python, third = subsystem(RIDER), subsystem(RIDER, backend="python"), subsystem(RIDER, fmi=3)
    assert (third.input_order, third.output_order, third.can_restore, third.has_directional_derivatives) == (
        3,
        3,
        True,
        True,
    )
    assert (
        compiled.input_order,
        compiled.output_order,
        compiled.can_restore,
        compiled.has_directional_derivatives,
    ) == (3, 3, True, True)
    assert (python.input_order, python.output_order, python.has_directional_derivatives) == (0, 0, False)


def without_dependencies(component, tmp_path):
    """The FMU of a component whose model description states no dependencies of its outputs."""
    whole, bare = build(component, tmp_path).path, tmp_path / "without_dependencies.fmu"
    with zipfile.ZipFile(whole) as source, zipfile.ZipFile(bare, "w") as made:
        for name in source.namelist():
            data = source.read(name)
            if name == "modelDescription.xml":
                data, count = re.subn(rb' dependencies(Kind)?="[^"]*"', b"", data)
                assert count
            made.writestr(name, data)
    return bare


def test_feedthrough_is_declared_or_found_by_trying(subsystem, tmp_path):
    rider = subsystem(RIDER)
    expected = {
        "torso_angle": [0, 0, 0],
        "handlebar_torque": [1, 1, 1],
        "frame_torque": [0, 1, 1],
        "torso_rate": [0, 1, 1],
    }
    cross = RIDER.values["cross_inertia"] != 0
    for k, name in enumerate(rider.outputs):
        if cross or name == "handlebar_torque":
            assert rider.feedthrough[k].tolist() == [bool(x) for x in expected[name]]
    with FmuSubsystem(without_dependencies(RIDER, tmp_path), "undeclared") as undeclared:
        tried = undeclared.feedthrough
    assert np.all(tried <= rider.feedthrough)
    assert tried[rider.outputs.index("handlebar_torque")].all()


def test_start_values_parameters_and_their_refusal(subsystem):
    motorcycle = subsystem(
        motorcycles.load("sharp_1971"), {"speed": 20.0, "steer_rate": 0.5, "added_steer_inertia": 0.1}
    )
    assert motorcycle.get("steer_rate") == 0.5
    assert motorcycle.get("added_steer_inertia") == 0.1
    assert motorcycle.present_inputs[motorcycle.inputs.index("speed")] == 20.0
    with pytest.raises(InputError, match="unknown variable of subsystem 'steer_rat', did you mean 'steer_rate'"):
        subsystem(motorcycles.load("sharp_1971"), {"steer_rat": 0.5})
    with pytest.raises(InputError, match=r"speed = -3 m/s is outside its bounds"):
        subsystem(motorcycles.load("sharp_1971"), {"speed": -3.0})


def test_a_step_that_fails_says_who_and_why(subsystem):
    motorcycle = subsystem(motorcycles.load("sharp_1971"))
    coefficients = np.zeros((4, len(motorcycle.inputs)))
    coefficients[:2, motorcycle.inputs.index("speed")] = 10.0, -20.0
    with pytest.raises(SimulationError, match=r"subsystem: fmi2DoStep failed.*speed"):
        motorcycle.step(coefficients, 0.01)


def test_what_is_no_fmu_is_named(tmp_path):
    with pytest.raises(InputError, match=r"cannot read .*none\.fmu: No such file"):
        model_description(tmp_path / "none.fmu")
    (tmp_path / "text.fmu").write_text("no archive")
    with pytest.raises(InputError, match=r"text\.fmu is not an FMU that can be read"):
        model_description(tmp_path / "text.fmu")


ENTITIES = '<?xml version="1.0"?><!DOCTYPE a [<!ENTITY b "c">]><a>&b;</a>'
UNSAFE = {
    r"resources/zeros: unpacks to \d+ times its size": {"resources/zeros": bytes(2**24)},
    r"extra/other\.xml: declares a document type or entities": {"extra/other.xml": ENTITIES},
    r"outside\.txt: the path leaves the folder": {"../outside.txt": "x"},
    r"the path leaves the folder of the archive, and 1 more fault": {"../a.txt": "x", "../b.txt": "x"},
}


@pytest.mark.parametrize(
    "opened",
    [model_description, FmuSubsystem, mf.simulate, mf.modes, mf.cosimulate, read_ssp],
    ids=lambda opened: opened.__name__,
)
@pytest.mark.parametrize("reason", UNSAFE)
def test_an_unsafe_archive_is_refused_before_it_is_unpacked(reason, opened, tmp_path, monkeypatch):
    path = tmp_path / "unsafe.fmu"
    path.write_bytes(build(RIDER, tmp_path).path.read_bytes())
    with zipfile.ZipFile(path, "a", zipfile.ZIP_DEFLATED) as archive:
        for name, data in UNSAFE[reason].items():
            archive.writestr(name, data)
    if opened is read_ssp:
        write_ssp(tmp_path / "safe.ssp", {"rider": build(RIDER, tmp_path).path}, {})
        with zipfile.ZipFile(tmp_path / "safe.ssp") as safe, zipfile.ZipFile(tmp_path / "unsafe.ssp", "w") as archive:
            for name in safe.namelist():
                archive.writestr(name, path.read_bytes() if name.endswith(".fmu") else safe.read(name))
        path = tmp_path / "unsafe.ssp"
    (tmp_path / "temporary").mkdir()
    monkeypatch.setattr(tempfile, "tempdir", str(tmp_path / "temporary"))
    with pytest.raises(InputError, match=rf"\.fmu is not an FMU that can be read: .*{reason}.*; nothing was unpacked"):
        opened(path)
    unpacked = [p for p in (tmp_path / "temporary").rglob("*") if p.is_file() and p.suffix != ".fmu"]
    assert unpacked == [] and not (tmp_path / "outside.txt").exists()


def test_a_missing_platform_is_named(tmp_path):
    whole = build(RIDER, tmp_path).path
    with zipfile.ZipFile(whole) as source, zipfile.ZipFile(tmp_path / "bare.fmu", "w") as bare:
        for name in source.namelist():
            if not name.startswith("binaries/"):
                bare.writestr(name, source.read(name))
    with pytest.raises(InputError, match=r"bare\.fmu cannot be loaded on this machine"):
        FmuSubsystem(tmp_path / "bare.fmu")


def test_an_instance_is_freed_at_the_end_of_a_with_block(tmp_path):
    with FmuSubsystem(build(RIDER, tmp_path).path) as rider:
        rider.step(np.zeros((4, len(rider.inputs))), 1e-3)
        rider.save()
    assert not rider.calls.alive
    rider.close()  # once more does nothing
    with pytest.raises(ZeroDivisionError), FmuSubsystem(build(RIDER, tmp_path).path) as failed:
        raise ZeroDivisionError
    assert not failed.calls.alive


@pytest.mark.slow
def test_the_repr_is_one_line_with_version_and_signals(subsystem):
    assert repr(subsystem(RIDER, fmi=3)) == (
        "<FmuSubsystem subsystem, FMI 3.0, inputs steer_angle, steer_rate, frame_rate, "
        "outputs torso_angle, handlebar_torque, frame_torque, torso_rate>")  # fmt: skip
    many = repr(subsystem(motorcycles.load("sharp_1971")))
    assert "\n" not in many and len(many) < 200
