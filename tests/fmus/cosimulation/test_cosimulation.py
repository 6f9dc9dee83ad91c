"""Runs of coupled FMUs against the exact motion of the one coupled system; files, power, divergence, bad input."""

import json

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.linalg import expm

from fmus.cosimulation.cosimulate import cosimulate, join, steps
from fmus.cosimulation.coupling import COUPLINGS
from fmus.cosimulation.network import Network
from fmus.cosimulation.profiles import Profile
from fmus.export.build import build
from fmus.linear_analysis.linearisation import linearise
from fmus.support.errors import InputError, SimulationError
from motofmi.cli.main import main
from motofmi.workflows.parts import GivenFmu, role_of
from motofmi.workflows.ridden_fmus import ridden_fmus
from tests.coupled import MOTORCYCLE, RIDER
from vehicle_fmu import dampers, ridden

SPEED, START = 30.0, 0.5


@pytest.fixture
def run():
    """Co-simulates rider and motorcycle: run(step, duration, coupling, device=..., **options)."""
    made = []

    def go(step, duration, coupling=None, device=RIDER, initial=None, speed=SPEED, **options):
        subsystems = ridden_fmus(MOTORCYCLE, device, {"steer_rate": START} if initial is None else initial, speed)
        made.extend(subsystems.values())
        return cosimulate(subsystems, step, duration, coupling, **options)

    yield go
    for subsystem in made:
        subsystem.close()


def exact_motion(times, speed=SPEED):
    """Steer angle (n,) of the one coupled system after a jump of the steer rate."""
    space = linearise(ridden(MOTORCYCLE, RIDER), **{"vehicle.speed": speed})
    state = np.zeros(len(space.states))
    state[space.states.index("vehicle.steer_rate")] = START
    row = space.C[space.outputs.index("vehicle.steer_angle")]
    return np.array([row @ expm(space.A * t) @ state for t in times])


@pytest.mark.slow
@pytest.mark.parametrize("name", [n for n in COUPLINGS if n != "interface_jacobian"])
def test_trajectories_converge_with_the_step_at_the_order_of_the_coupling(run, name):
    # Start-up included. The next order still shows at these steps: 0.75 of the power of two.
    coarse, fine = (8e-3, 4e-3) if COUPLINGS[name].order < 4 else (1.6e-2, 8e-3)
    error = []
    for step in (coarse, fine):
        found = run(step, 0.48, name)
        error.append(np.abs(found["vehicle.steer_angle"] - exact_motion(found["time"])).max())
    assert error[0] / error[1] > 0.75 * 2 ** COUPLINGS[name].order


@pytest.mark.slow
def test_the_interface_jacobian_leaves_nothing_of_linear_units_coupling_error(run):
    found = run(1e-2, 0.5, "interface_jacobian")
    exact = exact_motion(found["time"])
    assert found["vehicle.steer_angle"] == pytest.approx(exact, abs=1e-8 * np.abs(exact).max())


@pytest.mark.slow
def test_fmi_3_goes_with_fmi_2(tmp_path):
    third = GivenFmu(build(RIDER, tmp_path, fmi=3).path)
    subsystems = ridden_fmus(MOTORCYCLE, third, {"steer_rate": START}, SPEED)
    found = cosimulate(subsystems, 1e-2, 0.5)
    exact = exact_motion(found["time"])
    assert found.coupling == "interface_jacobian"
    assert found["vehicle.steer_angle"] == pytest.approx(exact, abs=1e-8 * np.abs(exact).max())


def eigenvalues_of(found, reach):
    """Of a free motion (1/s): rows with those of `reach` steps before obey x_(k+1) = P x_k, P by least squares."""
    rows = found.rows[3:, 1:]
    largest = np.abs(rows).max(axis=0)
    rows = rows[:, largest > 0] / largest[largest > 0]
    count = len(rows) - reach
    states = np.hstack([rows[k : k + count] for k in range(reach + 1)])
    multipliers = np.linalg.eigvals(np.linalg.pinv(states[:-1], rcond=1e-10) @ states[1:]).astype(complex)
    return np.log(multipliers[np.abs(multipliers) > 1e-8]) / found.step


@pytest.mark.slow
@pytest.mark.parametrize(("name", "step"), [("jacobi", 1e-3), ("jacobi", 5e-3), ("gauss_seidel", 2e-3), ("jacobi_linear", 2e-3), ("jacobi_quadratic", 4e-3),
                                            ("hermite", 4e-3), ("hermite", 8e-3), ("taylor", 1e-2), ("iterated", 5e-3), ("implicit_hermite", 1e-2)])  # fmt: skip
def test_predicted_errors_of_all_modes_below_15_hz_are_the_measured_ones_within_a_tenth_of_themselves(run, name, step):
    found = run(step, 400 * step, name, initial={"steer_rate": START, "roll_angle": 0.1, "yaw_rate": 0.3})
    prediction = found.predicted
    measured = eigenvalues_of(found, COUPLINGS[name].reach)
    below = prediction.oscillatory & (prediction.exact.imag < 2 * np.pi * 15)
    assert below.sum() == 3  # weave, rider-wobble, wobble
    for exact, predicted in zip(prediction.exact[below], prediction.coupled[below], strict=True):
        assert np.abs(measured - predicted).min() <= 0.1 * abs(predicted - exact)


@pytest.mark.slow
def test_rows_go_from_zero_to_the_duration_with_units_and_no_stale_feedthrough(run, tmp_path):
    out = tmp_path / "run.csv"
    found = run(1e-3, 0.7, out=out)
    header, *rows = out.read_text().splitlines()
    assert header.startswith("time [s],vehicle.lateral_velocity [m/s],vehicle.yaw_rate [rad/s]")
    table = np.array([[float(x) for x in row.split(",")] for row in rows])
    assert len(table) == 701 and table[0, 0] == 0.0 and table[-1, 0] == pytest.approx(0.7, rel=1e-12)
    column = {name.partition(" [")[0]: table[:, k] for k, name in enumerate(header.split(","))}
    p = RIDER.values
    relative = column["device.torso_rate"] - column["vehicle.frame_rate"]
    torque = p["arm_stiffness"] * (column["device.torso_angle"] - column["vehicle.steer_angle"]) + p["arm_damping"] * (
        relative - column["vehicle.steer_rate"]
    )
    assert column["device.handlebar_torque"] == pytest.approx(
        torque, rel=1e-9, abs=1e-9
    )  # mean rider: no cross inertia
    assert found.rows.size == 0


@pytest.mark.slow
def test_the_default_is_the_cheapest_that_meets_the_tolerance(run):
    assert run(1e-3, 0.01).predicted.worst <= 1e-5
    assert run(1e-3, 0.01, tolerance=0.1).coupling == "jacobi"
    assert run(1e-2, 0.01).coupling in ("interface_jacobian", "implicit_hermite")


@pytest.mark.slow
def test_power_residual_falls_with_the_step_and_counts_what_held_torques_do(run):
    coarse, fine = run(2e-3, 0.5, "jacobi"), run(1e-3, 0.5, "jacobi")
    assert 1.7 < coarse.power_residual / fine.power_residual < 2.3  # held inputs are wrong by one step
    assert run(1e-3, 0.5, "implicit_hermite").power_residual < 1e-9
    assert {bond.name for bond in fine.power_bonds} == {"vehicle.handlebar_torque", "vehicle.frame_torque"}
    assert all(bond.exchanged > 0 for bond in fine.power_bonds)


@pytest.mark.slow
def test_a_coupling_that_diverges_stops_and_says_where_when_and_what_to_change(run, tmp_path):
    out = tmp_path / "run.csv"
    with pytest.raises(
        SimulationError, match=r"stopped at [\d.]+ s at vehicle\.handlebar_torque .* take a smaller step than 0.05 s"
    ):
        run(0.05, 100.0, "jacobi", out=out)
    assert len(out.read_text().splitlines()) > 2


@pytest.mark.slow
@pytest.mark.parametrize(("step", "largest"), [(1e-3, 1e-4), (1e-2, 5e-4)])
def test_a_changing_speed_is_followed(step, largest):
    # The reference: the one coupled system, integrated with the same speed. At a constant speed the parabolas that the
    # default takes at 1 ms are off by 5e-5 of the largest angle.
    system, deceleration = ridden(MOTORCYCLE, RIDER), 20.0
    inputs = np.array([system.table[n].start for n in system.inputs])
    speed = system.inputs.index("vehicle.speed")

    def rates(time, state):
        inputs[speed] = 30.0 - deceleration * time
        return system.derivatives(state, inputs)[0]

    start = np.zeros(len(system.states))
    start[system.states.index("vehicle.steer_rate")] = START
    solution = solve_ivp(rates, (0, 0.5), start, rtol=1e-10, atol=1e-13, t_eval=np.arange(51) * 0.01)
    exact = solution.y[system.states.index("vehicle.steer_angle")]
    subsystems = ridden_fmus(MOTORCYCLE, RIDER, {"steer_rate": START}, 30.0)
    wiring = join(subsystems)
    profile = Profile.over_time(Network(subsystems, wiring), np.array([0.0, 0.5]), {"speed": np.array([30.0, 20.0])})
    found = cosimulate(subsystems, step, 0.5, wiring=wiring, profile=profile)
    every = found["vehicle.steer_angle"][:: round(0.01 / step)]
    assert np.abs(every - exact).max() <= largest * np.abs(exact).max()
    for subsystem in subsystems.values():
        subsystem.close()


@pytest.mark.slow
def test_devices_add_up_and_a_nonlinear_one_is_within_its_order(run):
    damper = dampers.load("progressive")
    ends = [
        run(step, 0.2, "interface_jacobian", device=damper, initial={"steer_rate": 3.0})["vehicle.steer_angle"][-1]
        for step in (4e-3, 2e-3, 1e-3)
    ]
    assert abs(ends[1] - ends[2]) < 0.5 * abs(ends[0] - ends[1])


@pytest.mark.slow
@pytest.mark.parametrize(("coupling", "tolerance"), [(None, 1e-4), ("hermite", 1e-4), ("jacobi", 1e-2)])
def test_an_automatic_step_follows_the_run(coupling, tolerance):
    subsystems = ridden_fmus(MOTORCYCLE, RIDER, {"steer_rate": 3.0}, 30.0)
    wiring = join(subsystems)
    profile = Profile.over_time(Network(subsystems, wiring), np.array([0.0, 1.0]), {"speed": np.array([30.0, 10.0])})
    found = cosimulate(subsystems, "auto", 1.0, coupling, wiring=wiring, profile=profile, tolerance=tolerance)
    lengths = np.diff(found["time"])
    assert found["time"][-1] == pytest.approx(1.0, rel=1e-12) and len(lengths) == found.steps
    assert found.longest > 1.3 * found.shortest
    # The last ones are a little shorter, so that they end with the run.
    assert lengths.max() <= found.longest * (1 + 1e-9) and np.median(lengths) >= found.shortest * (1 - 1e-9)
    # An energy error is one of damping, ten times the tolerance; the estimate comes a segment late, hence a factor.
    assert (
        max(abs(bond.energy_error) for bond in found.power_bonds if bond.name == "vehicle.handlebar_torque")
        < 5 * 10 * tolerance
    )
    for subsystem in subsystems.values():
        subsystem.close()


@pytest.mark.slow
def test_an_automatic_step_is_refused_in_words_that_are_no_step(run):
    with pytest.raises(InputError, match="'long' is neither a number of seconds nor auto"):
        run("long", 1.0)


@pytest.mark.slow
def test_a_run_without_a_device_is_the_vehicle_alone(run):
    found = run(1e-2, 0.2, device=None)
    space = linearise(MOTORCYCLE, speed=SPEED)
    state = np.zeros(8)
    state[space.states.index("steer_rate")] = START
    assert found["vehicle.steer_angle"][-1] == pytest.approx(
        (space.C @ expm(space.A * 0.2) @ state)[space.outputs.index("steer_angle")], rel=1e-10
    )


def test_the_step_divides_the_duration():
    assert steps(0.001, 5.0) == (0.001, 5000)
    step, count = steps(0.3, 1.0)
    assert count == 4 and step == 0.25


@pytest.mark.slow
@pytest.mark.parametrize(("words", "message"), [
    (["--step", "0"], "step = 0 s: a step must be positive"),
    (["--step", "nan"], "step = nan s"),
    (["--step", "-0.1"], "step = -0.1 s"),
    (["--step", "soon"], "neither a number of seconds nor auto"),
    (["--duration", "0"], "duration = 0 s"),
    (["--coupling", "foo"], "unknown coupling 'foo' (valid: gauss_seidel, hermite"),
    (["--initial", "foo=1"], "unknown state 'foo'"),
    (["--initial", "steer_rate=nan"], "not a finite number"),
    (["--speed", "-3"], "speed = -3 m/s is outside its bounds"),
    (["--tolerance", "0"], "tolerance = 0"),
    (["--fmu", "none.fmu"], "cannot read none.fmu"),
    (["--input", "none.csv"], "cannot read inputs from none.csv"),
])  # fmt: skip
def test_bad_input_is_one_line_with_status_2(words, message, capsys, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    assert main(["cosimulate", "--duration", "0.1", *words]) == 2
    error = capsys.readouterr().err
    assert message in error and error.count("\n") == 1
    assert list(tmp_path.glob("*.csv")) == []


@pytest.mark.slow
def test_an_fmu_without_the_port_is_refused_with_what_is_missing(tmp_path):
    wrong = build(ridden(MOTORCYCLE, RIDER), tmp_path).path
    with pytest.raises(InputError, match=r"does not have the handlebar port: as a .* it lacks input"):
        role_of(wrong)
    assert role_of(build(MOTORCYCLE, tmp_path).path) == "vehicle"
    assert role_of(build(RIDER, tmp_path).path) == "device"


@pytest.mark.slow
def test_anybodys_fmu_with_the_port_takes_a_side(tmp_path, capsys):
    rider = build(RIDER, tmp_path, backend="python").path
    out, result = tmp_path / "run.csv", tmp_path / "run.json"
    assert (
        main(
            [
                "cosimulate",
                "--fmu",
                str(rider),
                "--duration",
                "0.05",
                "--initial",
                "steer_rate=0.5",
                "--out",
                str(out),
                "--json",
                str(result),
            ]
        )
        == 0
    )
    found = json.loads(result.read_text())
    assert found["device"] == rider.name and found["step"] == 0.001
    assert set(found["predicted"]) == {"weave", "wobble", "rider_wobble"}
    assert all({"frequency_error", "damping_error"} <= set(mode) for mode in found["predicted"].values())
    assert {"coupling", "steps_per_second", "power_residual", "file"} <= set(found)
