"""Co-simulation from Python: the same physics as the command line, and as one coupled linear system; one FMU by itself."""

import json
import re

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.linalg import expm

import motofmi as mf
from fmus.cosimulation.cosimulate import cosimulate as run_subsystems
from fmus.cosimulation.subsystems.fmu_subsystem import FmuSubsystem
from fmus.support import progress
from motofmi.cli.main import main
from vehicle_fmu import ridden

SPEED = 30.0  # m/s


def exact(vehicle, devices, initial, times):
    """States (times, nx) by name of the one linear system of vehicle and devices: x(t) = exp(A t) x(0)."""
    system = ridden(vehicle, *devices)
    space = mf.linearise(system, **{"vehicle.speed": SPEED})
    start = np.array([initial.get(name, 0.0) for name in space.states])
    return space.states, np.array([expm(space.A * t) @ start for t in times])


DEVICES = {
    "a rider's inertia moves with the handlebar": ["rider:1_2011"],
    "a rider who leans brings his own mass": ["rider:1_2011", "rider:roll_1971"],
}


@pytest.mark.slow
@pytest.mark.parametrize("names", DEVICES.values(), ids=DEVICES)
def test_the_run_is_the_motion_of_the_coupled_linear_system(names):
    bike, devices = mf.vehicle("sharp_1971"), [mf.rider(name) for name in names]
    run = mf.cosimulate(bike, devices, speed=SPEED, duration=1.0, initial={"vehicle.steer_rate": 0.5})
    times = run["time"][::100]
    states, motion = exact(bike, devices, {"vehicle.steer_rate": 0.5}, times)
    angle = motion[:, states.index("vehicle.steer_angle")]
    # The coupling's error is within its tolerance of 1e-5 of a mode's frequency and 1e-4 of its damping. Measured:
    # leaving the rider's inertia out changes the angle by 0.7 %, counting the leaning rider's mass twice by 69 %.
    np.testing.assert_allclose(run["vehicle.steer_angle"][::100], angle, rtol=0, atol=2e-4 * np.abs(angle).max())


@pytest.mark.slow
@pytest.mark.parametrize("names", DEVICES.values(), ids=DEVICES)
def test_python_and_the_command_line_give_the_same_run(names, tmp_path, capsys):
    options = ["--device", ",".join(names), "--speed", "30", "--duration", "0.5", "--initial", "vehicle.steer_rate=0.5"]
    assert main(["cosimulate", *options, "--out", str(tmp_path / "run.csv"), "--json", "-"]) == 0
    printed = json.loads(capsys.readouterr().out)
    run = mf.cosimulate("sharp_1971", names, speed=30, duration=0.5, initial={"vehicle.steer_rate": 0.5})
    np.testing.assert_array_equal(run.rows, np.loadtxt(tmp_path / "run.csv", delimiter=",", skiprows=1))
    timed = {"steps_per_second", "file", "units"}
    given = json.loads(json.dumps(run.to_dict(), default=float))
    assert {k: v for k, v in given.items() if k not in timed} == {k: v for k, v in printed.items() if k not in timed}


@pytest.mark.slow
def test_fmus_give_the_same_run_as_components(tmp_path):
    options = {"speed": 30, "duration": 0.2, "initial": {"vehicle.steer_rate": 0.5}}
    bike, rider = (mf.build(name, tmp_path).path for name in ("sharp_1971", "rider:mean_2011"))
    given = mf.cosimulate("sharp_1971", "rider:mean_2011", **options)
    np.testing.assert_array_equal(mf.cosimulate(bike, rider, **options).rows, given.rows)


@pytest.mark.slow
def test_subsystems_made_by_hand_without_the_riders_inertia_give_a_warning(tmp_path):
    bike, rider = (mf.build(name, tmp_path).path for name in ("sharp_1971", "rider:1_2011"))
    with FmuSubsystem(rider) as held, FmuSubsystem(bike, values={"speed": SPEED}) as alone:
        with pytest.warns(UserWarning, match="added_steer_inertia is 0, but device adds 0.0027 kg.m2"):
            run_subsystems({"vehicle": alone, "device": held}, 0.001, 0.01)
        needed = held.get("port_inertia")
    values = {"speed": SPEED, "steer_rate": 0.5, "added_steer_inertia": needed}
    with FmuSubsystem(rider) as held, FmuSubsystem(bike, values=values) as carrying:
        run = run_subsystems({"vehicle": carrying, "device": held}, 0.001, 0.2)
    given = mf.cosimulate("sharp_1971", "rider:1_2011", speed=SPEED, duration=0.2, initial={"vehicle.steer_rate": 0.5})
    np.testing.assert_allclose(run["vehicle.steer_angle"], given["vehicle.steer_angle"], rtol=0, atol=1e-12)


@pytest.mark.slow
def test_two_riders_cannot_hold_one_handlebar():
    with pytest.raises(mf.InputError, match="cannot both hold the handlebar"):
        mf.cosimulate("sharp_1971", ["rider:mean_2011", "rider:1_2011"], duration=0.01)


@pytest.mark.slow
def test_inputs_are_a_file_or_columns(tmp_path):
    times, torque = [0.0, 0.1, 0.2], [0.0, 1.0, 0.0]
    (tmp_path / "inputs.csv").write_text(
        "time [s],steer_torque [N.m]\n" + "".join(f"{t},{m}\n" for t, m in zip(times, torque, strict=True))
    )
    of_columns = mf.cosimulate("sharp_1971", inputs={"time": times, "steer_torque": torque}, speed=20, duration=0.2)
    of_file = mf.cosimulate("sharp_1971", inputs=tmp_path / "inputs.csv", speed=20, duration=0.2)
    np.testing.assert_array_equal(of_columns.rows, of_file.rows)
    assert np.abs(of_columns["vehicle.steer_angle"]).max() > 0


WRONG = {
    "no time": ({"inputs": {"steer_torque": [0.0]}}, "unknown column 'time'"),
    "lengths": ({"inputs": {"time": [0, 1], "steer_torque": [0.0]}}, "differ in shape"),
    "speed twice": ({"inputs": {"time": [0], "speed": [20]}, "speed": 30}, "given twice"),
    "state": ({"initial": {"steer_rat": 1.0}}, "did you mean"),
    "parameter": ({"set": {"steering_dampin": 1.0}}, "did you mean 'steering_damping'"),
    "coupling": ({"coupling": "jacoby"}, "did you mean 'jacobi'"),
    "tolerance": ({"tolerance": 0.0}, "must be positive"),
    "speed": ({"speed": -3.0}, "outside its bounds"),
}


@pytest.mark.slow
@pytest.mark.parametrize(("options", "message"), WRONG.values(), ids=WRONG)
def test_what_cannot_be_run_is_an_error_that_says_why(options, message):
    with pytest.raises(mf.InputError, match=message):
        mf.cosimulate("sharp_1971", "rider:mean_2011", **{"duration": 0.01, **options})


@pytest.mark.slow
@pytest.mark.parametrize("fmi", [2, 3])
def test_one_fmu_by_itself_moves_as_its_equations_do(fmi, tmp_path):
    rider = mf.rider("mean_2011", arm_damping=20.0)
    path = mf.build(rider, tmp_path, fmi=fmi).path
    times = np.linspace(0, 1, 21)
    steer = 0.05 * np.sin(2 * np.pi * times)
    run = mf.simulate(path, inputs={"time": times, "steer_angle": steer}, step=0.001, duration=1.0)
    given = {"steer_angle": lambda t: np.interp(t, times, steer)}

    def rates(t, x):
        return rider.derivatives(x, np.array([given[n](t) if n in given else 0.0 for n in rider.inputs]))[0]

    found = solve_ivp(
        rates, (0, 1), np.zeros(len(rider.states)), rtol=1e-10, atol=1e-12, max_step=0.01, t_eval=run["time"]
    )
    outputs = np.array(
        [
            rider.derivatives(x, np.array([given[n](t) if n in given else 0.0 for n in rider.inputs]))[1]
            for t, x in zip(found.t, found.y.T, strict=True)
        ]
    )
    torque = outputs[:, rider.outputs.index("handlebar_torque")]
    # Linear, and linear inputs within a step: the FMU's step is exact, what differs is the reference's own error.
    np.testing.assert_allclose(run[f"{path.stem}.handlebar_torque"], torque, rtol=0, atol=1e-6 * np.abs(torque).max())
    np.testing.assert_allclose(
        run[f"{path.stem}.steer_angle"], np.interp(run["time"], times, steer), rtol=0, atol=1e-15
    )


def test_a_simulation_takes_values_by_name_and_writes_rows(tmp_path, capsys):
    run = mf.simulate("rider:mean_2011", set={"torso_angle": 0.1}, step=0.01, duration=0.1)
    assert run["rider_mean_2011.torso_angle"][0] == 0.1 and len(run["time"]) == 11
    assert main(["simulate", "rider:mean_2011", "--set", "torso_angle=0.1", "--step", "0.01", "--duration", "0.1",
                 "--out", str(tmp_path / "run.csv"), "--json", "-"]) == 0  # fmt: skip
    printed = json.loads(capsys.readouterr().out)
    assert printed["rows"] == 11 and printed["out"] == str(tmp_path / "run.csv")
    np.testing.assert_array_equal(np.loadtxt(tmp_path / "run.csv", delimiter=",", skiprows=1), run.rows)
    with pytest.raises(mf.InputError, match="torso_angl"):
        mf.simulate("rider:mean_2011", set={"torso_angl": 0.1})
    with pytest.raises(mf.InputError, match="unknown input 'steer'"):
        mf.simulate("rider:mean_2011", inputs={"time": [0], "steer": [0]})


@pytest.mark.slow
def test_building_the_fmus_of_a_run_shows_progress(tmp_path, monkeypatch, capsys):
    monkeypatch.setenv("MOTOFMI_CACHE", str(tmp_path))  # nothing is built yet
    monkeypatch.setattr(progress, "SECONDS", 0.1)
    mf.cosimulate("sharp_1971", "damper:7.5", speed=SPEED, duration=0.01)
    assert re.search(r"building the FMUs after \d+ s\n", capsys.readouterr().err)
