"""The rider in roll as a device: named on the command line, and as FMU in every coupling, alone and with the rider who
turns.

The full rider, whose inertia at the bar changes with his posture, is coupled here, too.
"""

import json
from functools import cache

import numpy as np
import pytest
from scipy.linalg import expm

from fmus.cosimulation.cosimulate import cosimulate, join
from fmus.cosimulation.coupling import COUPLINGS, coupling
from fmus.cosimulation.coupling_error import linear_network, predict
from fmus.cosimulation.subsystems.fmu_subsystem import FmuSubsystem
from fmus.export.build import build
from fmus.linear_analysis.linearisation import linearise
from motofmi.cli.main import main
from motofmi.workflows.ridden_fmus import ridden_fmus
from rider_fmu import riders
from tests import as_study
from vehicle_fmu import modes, motorcycles, over_speed, ridden

SPEED, DURATION = 40.0, 0.25  # m/s, s
START = {"roll_angle": 0.02, "steer_rate": 0.1}
HELD = {"leaning": ("roll_1971",), "turning and leaning": ("mean_2011", "roll_1971"), "full rider": ("full_mean_2011",)}
ACCURATE = {"interface_jacobian", "implicit_hermite"}
SECOND = {"jacobi_quadratic", "hermite", "taylor"}


def system(held):
    return ridden(motorcycles.load("sharp_1971"), *map(riders.load, HELD[held]))


@cache
def units(held):
    return ridden_fmus(motorcycles.load("sharp_1971"), [riders.load(n) for n in HELD[held]], speed=SPEED)


@cache
def linear(held):
    return linear_network(units(held), join(units(held)))


def ends(held):
    """Outputs `part.name` of the one system at the end of the run, by the matrix exponential from its start."""
    space = linearise(system(held), **{"vehicle.speed": SPEED})
    start = np.array([START.get(n.partition(".")[2], 0.0) if n.startswith("vehicle.") else 0.0 for n in space.states])
    return dict(zip(space.outputs, space.C @ expm(space.A * DURATION) @ start, strict=True))


@pytest.mark.slow
@pytest.mark.parametrize("held", [*list(HELD)[:2], as_study("full rider")])
def test_the_coupled_fmus_are_the_one_system(held):
    """Mass taken out of the rear frame, inertia at the bar, signs of the roll port: all eigenvalues return."""
    one = np.linalg.eigvals(linearise(system(held), **{"vehicle.speed": SPEED}).A)
    coupled = np.linalg.eigvals(linear(held).linearised().A)
    assert len(one) == len(coupled)
    assert all(
        np.abs(coupled - e).min() <= 1e-8 * abs(e) for e in one if abs(e) > 1e-6
    )  # rounding of two eigensolutions


@pytest.mark.slow
@pytest.mark.parametrize("held", [*list(HELD)[:2], as_study("full rider")])
@pytest.mark.parametrize("name", COUPLINGS)
def test_every_coupling_keeps_the_modes_as_it_does_without_lean(name, held):
    prediction = predict(coupling(name), linear(held), 1e-3)
    swings = prediction.oscillatory & (prediction.exact.imag < 2 * np.pi * 15)
    # The targets of the couplings for the rider who turns; the plain ones are of first order and miss by per cents.
    frequency, damping = (1e-5, 1e-4) if name in ACCURATE else (1e-4, 1e-3) if name in SECOND else (3e-2, 0.3)
    assert prediction.stable
    assert np.abs(prediction.frequency_error[swings]).max() <= frequency
    assert np.abs(prediction.damping_error[swings]).max() <= damping


@pytest.mark.slow
@pytest.mark.parametrize("name", COUPLINGS)
def test_a_run_of_the_fmus_ends_where_the_one_system_does(name):
    held, errors = "turning and leaning", []
    expected = ends(held)
    scale = {"roll_angle": 0.02, "steer_rate": 0.1, "lean_angle": 0.02, "pelvis_shift": 0.005}
    for step in (4e-3, 2e-3):
        fmus = ridden_fmus(motorcycles.load("sharp_1971"), [riders.load(n) for n in HELD[held]], START, SPEED)
        run = cosimulate(fmus, step, DURATION, name)
        parts = {n: next(c for c in expected if c.endswith(f".{n}")) for n in scale}
        errors.append(max(abs(run[column][-1] - expected[column]) / scale[n] for n, column in parts.items()))
        for unit in fmus.values():
            unit.close()
    floor = 1e-9  # of the start: what the exact step and its tolerance leave
    assert errors[1] < max(errors[0] / 2 ** (coupling(name).order - 0.5), floor), errors


@pytest.mark.slow
def test_a_rider_who_leans_as_an_fmu_of_somebody_else(tmp_path, capsys):
    """By path, both riders as archives: the modes are those of the components."""
    paths = [str(build(riders.load(n), tmp_path).path) for n in HELD["turning and leaning"]]
    assert main(["modes", *(w for p in paths for w in ("--fmu", p)), "--speed", "40", "--json", "-"]) == 0
    found = json.loads(capsys.readouterr().out)["modes"]
    expected = modes(over_speed(system("turning and leaning")), [40.0])
    for mode, values in found.items():
        assert complex(*values["eigenvalue"][0]) == pytest.approx(expected[mode].eigenvalue[0], rel=1e-7), mode


@pytest.mark.slow
@pytest.mark.parametrize(
    "words",
    [["modes", "--device", "rider:roll_1971", "--speed", "20,40"], ["modes", "--device", "rider:mean_2011,rider:roll_1971,damper:2", "--speed", "40"],
     ["modes", "--device", "rider:roll_1971", "--set", "lean_stiffness=500", "--speed", "40"], ["device", "rider:roll_1971"]],
)  # fmt: skip
def test_commands_take_it(words, capsys):
    assert main([*words, "--json", "-"]) == 0
    assert json.loads(capsys.readouterr().out)["device"].endswith(("rider_roll_1971", "damper_2"))


@pytest.mark.slow
def test_both_co_simulate_from_the_command_line(tmp_path, capsys):
    out = tmp_path / "run.csv"
    words = [
        "cosimulate",
        "--device",
        "rider:mean_2011,rider:roll_1971",
        "--speed",
        "40",
        "--duration",
        "0.2",
        "--initial",
        "roll_angle=0.02",
    ]
    assert main([*words, "--out", str(out), "--json", "-"]) == 0
    result = json.loads(capsys.readouterr().out)
    assert {"weave", "wobble", "rider_wobble"} <= set(result["predicted"]) and "vehicle.roll_torque" in result["bonds"]
    assert "device_2.lean_angle [rad]" in out.read_text().splitlines()[0]


@pytest.mark.slow
@pytest.mark.parametrize(
    "words, said",
    [(["modes", "--device", "rider:roll_3_2008"], "lower saddle or rider"), (["modes", "--device", "rider:1_2011,rider:2_2011"], "cannot both hold the handlebar"),
     (["modes", "--vehicle", "benchmark_bicycle", "--device", "rider:roll_1971"], "use a motorcycle"), (["modes", "--device", "rider:mean_2011,motorcycle:sharp_1971"], "not a device"),
     (["cosimulate", "--device", "rider:roll_3_2008"], "lower saddle or rider")],
)  # fmt: skip
def test_what_cannot_be_ridden_is_refused_in_one_line(words, said, capsys):
    assert main(words) == 2
    error = capsys.readouterr().err
    assert said in error and error.count("\n") == 1


@pytest.mark.slow
def test_a_second_archive_of_a_leaning_rider_is_refused(tmp_path, capsys):
    path = build(riders.load("roll_1971"), tmp_path).path
    unit = FmuSubsystem(path)
    assert {"roll_torque", "lateral_force"} <= set(unit.outputs)
    unit.close()
    assert main(["modes", "--fmu", str(path), "--fmu", str(path)]) == 2
    assert "the vehicle: without 44.8016 kg" in capsys.readouterr().err  # nobody else is left in its rear frame
