"""The virtual rig: against the exact solution of a driven bar, energy, converters, and its own equations integrated by scipy."""

import numpy as np
import pytest
import sympy
from scipy.integrate import solve_ivp

from fmus import System, linearise
from fmus.expressions.functions import NUMERIC
from fmus.expressions.symbolic_functions import SYMBOLIC
from fmus.linear_analysis.exact_motion import exact_response
from motofmi.frequency_response.excitation import multisine, stepped_sine, sweep
from motofmi.virtual_rig.simulated_rig import QUIET, Noise, steer_test
from rider_fmu import SteerRig, riders

RIDER = riders.load("mean_2011")


@pytest.mark.slow
@pytest.mark.parametrize("excitation", [sweep(), sweep(12, 0.5), stepped_sine(), multisine()], ids=lambda e: e.name)
def test_rate_of_the_command_is_its_slope(excitation):
    time = np.linspace(0, excitation.duration, 200_001)
    angle, rate = excitation.motion(time)
    # central differences at 1 ms: h^2/6 times the third derivative of 4 deg at 12 Hz
    assert (
        np.abs(np.gradient(angle, time) - rate)[1:-1].max()
        < (time[1] ** 2 / 6) * np.radians(4) * (2 * np.pi * 12) ** 3 * 1.5
    )
    assert angle[0] == 0 and rate[0] == 0 and np.all(angle[time > excitation.duration - 1.9] == 0)


def test_sweep_and_steps_are_those_of_the_papers():
    up, steps = sweep(), stepped_sine()
    time = np.linspace(100, 101, 10_001)
    angle, rate = up.motion(time)
    assert np.abs(angle).max() == pytest.approx(np.radians(2), rel=1e-6)
    # at the middle of the sweep the frequency is 6.25 Hz
    assert np.hypot(angle, rate / (2 * np.pi * 6.25)) == pytest.approx(np.radians(2), rel=0.01)
    middle = np.linspace(45, 50, 10_001)  # the fifth of 10 s each: 2.5 Hz
    angle, rate = steps.motion(middle)
    np.testing.assert_allclose(np.hypot(angle, rate / (2 * np.pi * 2.5)), np.radians(4), rtol=1e-9)


@pytest.mark.study
def test_motion_is_scipys_solution():
    space = linearise(System("test", {"rig": SteerRig("rig"), "rider": RIDER}))
    command = sweep(0.5, 12, 4.0, ramp=0.5)
    step = 1 / 2048
    time = np.arange(int(5 / step)) * step
    angle, rate = command.motion(time)
    inputs, slopes = np.zeros((2, len(time), len(space.inputs)))
    k = space.inputs.index("rig.steer_angle_command")
    inputs[:, k], slopes[:, k] = angle, rate
    states, outputs = exact_response(space, inputs, step, slopes)
    solution = solve_ivp(lambda t, x: space.A @ x + space.B[:, k] * command.motion(np.array([t]))[0], (0, time[-1]), np.zeros(len(space.A)),
                         method="DOP853", t_eval=time[::64], rtol=1e-10, atol=1e-13)  # fmt: skip
    # a cubic through 12 Hz at 2048 Hz misses by (w h)^4 / 384 = 5e-9 of it
    largest = np.abs(states).max(axis=0)
    np.testing.assert_allclose(states[::64] / largest, solution.y.T / largest, atol=1e-7)
    np.testing.assert_allclose(
        outputs[:, space.outputs.index("rig.steer_angle")], states[:, space.states.index("rig.steer_angle")]
    )


def test_motion_of_an_integrator_is_exact_for_a_cubic():
    space = linearise(SteerRig("rig"))
    space = type(space)(np.zeros((1, 1)), np.ones((1, 1)), np.ones((1, 1)), np.zeros((1, 1)), ("x",), ("u",), ("x",))
    time = np.linspace(0, 2, 21)
    states, _ = exact_response(space, (time**3 - time)[:, None], time[1], (3 * time**2 - 1)[:, None])
    np.testing.assert_allclose(states[:, 0], time**4 / 4 - time**2 / 2, atol=1e-13)


def test_the_servo_imposes_the_angle():
    """Both papers call the angle imposed: a rider on the bar moves it by a few percent at most."""
    run = steer_test(RIDER, 0.125, sweep(), QUIET)
    command, angle = run["steer_angle_command"], run["steer_angle"]
    assert np.std(angle) == pytest.approx(np.std(command), rel=0.02)


@pytest.mark.slow
def test_torque_is_the_bars_inertia_less_the_riders_torque():
    """The torsiometer shows I_s s' - T_h, whatever the servo does: two servos, one impedance."""
    soft = SteerRig("rig", servo_stiffness=500.0, servo_bandwidth=60.0)
    for rig in (None, soft):
        run = steer_test(RIDER, 0.125, sweep(0.5, 12, 20), QUIET, rig=rig, oversampling=16)
        w = 2 * np.pi * np.fft.rfftfreq(len(run.time), 1 / 128)[30:200]
        theta, torque = (np.fft.rfft(run[c])[30:200] for c in ("steer_angle", "steer_torque"))
        p = RIDER.values
        arms, waist = p["arm_stiffness"] + 1j * w * p["arm_damping"], p["waist_stiffness"] + 1j * w * p["waist_damping"]
        torso = waist - w**2 * p["torso_inertia"]
        stiffness = -(w**2) * 0.125 + arms * torso / (arms + torso)
        # the ends of a 22 s record and aliases
        np.testing.assert_allclose(torque, stiffness * theta, atol=2e-5 * np.abs(torque).max())


def test_channels_have_the_stated_noise_and_steps():
    still = sweep(duration=20, amplitude=0.0)
    noise = Noise(remnant=0.0)
    run = steer_test(RIDER, 0.125, still, noise, seed=3)
    # 2816 samples: 1.3 % scatter; quantisation adds step^2/12
    assert np.std(run["steer_angle"]) == pytest.approx(np.hypot(noise.angle, noise.angle_step / 12**0.5), rel=0.05)
    assert np.std(run["steer_torque"]) == pytest.approx(np.hypot(noise.torque, noise.torque_step / 12**0.5), rel=0.05)
    for channel, step in (("steer_angle", noise.angle_step), ("steer_torque", noise.torque_step)):
        np.testing.assert_allclose(run[channel] / step, np.round(run[channel] / step), atol=1e-9)
    assert np.all(steer_test(RIDER, 0.125, still, noise, seed=3)["steer_torque"] == run["steer_torque"])
    assert np.any(steer_test(RIDER, 0.125, still, noise, seed=4)["steer_torque"] != run["steer_torque"])


def test_remnant_shows_in_the_torque():
    still = sweep(duration=200, amplitude=0.0)
    run = steer_test(RIDER, 0.125, still, Noise(0.0, 0.0, 0.4, 2.0, 0.0, 0.0), seed=1)
    # a stiff servo holds the bar: the torsiometer carries the remnant; 200 s of 2 Hz noise scatter by 4 %
    assert np.std(run["steer_torque"]) == pytest.approx(0.4, rel=0.12)


def test_quantised_means_the_same_in_numbers_and_symbols():

    x, step = sympy.symbols("x step", real=True)
    expression = SYMBOLIC.quantised(x, step)
    assert sympy.diff(expression, x) == 1
    function = sympy.lambdify([x, step], expression, "numpy")
    values = np.linspace(-1, 1, 37)
    for size in (0.0, 0.1, 0.25):
        np.testing.assert_array_equal(function(values, size), NUMERIC.quantised(values, size))
    np.testing.assert_array_equal(NUMERIC.quantised(values, 0.0), values)
    assert NUMERIC.quantised(0.26, 0.1) == pytest.approx(0.3)


@pytest.mark.slow
def test_the_rig_and_its_rider_as_one_fmu(opened):
    """A commanded angle held from the start: the FMU's converters give what the exact motion says, to one step."""
    values = {"angle_step": np.radians(40) / 4096, "torque_step": 400 / 4096}
    system = System("rig_with_rider", {"rig": SteerRig("rig", **values), "rider": RIDER})
    fmu = opened(system).start()
    time = np.arange(0, 0.3, 0.002)
    names = ("rig.measured_angle", "rig.measured_torque", "rig.steer_angle")
    rows = fmu.run(time, lambda now: {"rig.steer_angle_command": 0.05}, names)
    space = linearise(system)
    inputs = np.zeros((len(time), len(space.inputs)))
    inputs[:, space.inputs.index("rig.steer_angle_command")] = 0.05
    _, outputs = exact_response(space, inputs, 0.002)
    angle, torque, true_angle = (outputs[:, space.outputs.index(n)] for n in names)
    np.testing.assert_allclose(rows[:, 2], true_angle, atol=1e-12)  # both are exact
    for channel, exact, step in (
        (rows[:, 0], angle, values["angle_step"]),
        (rows[:, 1], torque, values["torque_step"]),
    ):
        np.testing.assert_allclose(channel / step, np.round(channel / step), atol=1e-9)
        assert np.abs(channel - exact).max() <= 0.5001 * step
        assert len(np.unique(channel)) > 10
