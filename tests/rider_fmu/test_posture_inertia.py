"""The full rider on a moving frame: inertia that changes with posture."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.integrate import solve_ivp

from fmus import Component, System, linearise, parameter
from fmus.expressions.functions import NUMERIC
from fmus.interfaces.handlebar import port_input, port_state
from fmus.interfaces.posture_inertia import PostureInertia
from rider_fmu import riders
from rider_fmu.components.full_rider import on_rig
from rider_fmu.full_rider.limbs import motion
from rider_fmu.rigs.handlebar import Handlebar
from tests.truth import full_rider_by_angles

RIDER = riders.load("full_mean_2011")
WITHOUT_DAMPERS = {f"{joint}_damping": 0.0 for joint in ("waist", "shoulder", "elbow", "wrist")}
angles = st.tuples(st.floats(-0.15, 0.15), st.floats(-0.1, 0.1))
rates = st.tuples(st.floats(-5, 5), st.floats(-5, 5))


@pytest.mark.slow
@given(angles, rates, st.floats(-20, 20))
def test_the_bar_with_the_posture_inertia_has_the_equations_of_the_rig(at, moving, torque):
    """The port with the vehicle's bar gives the acceleration of the rig's equations, which have no port."""
    rig = on_rig(RIDER)
    state = dict(zip(("steer_angle", "torso_angle", "steer_rate", "torso_rate"), (*at, *moving), strict=True))
    inputs = {"servo_torque": torque, "handlebar_torque": 0.0, "frame_torque": 0.0}
    expected = dict(
        zip(
            rig.states,
            rig.derivatives(np.array([state[n] for n in rig.states]), np.array([inputs[n] for n in rig.inputs]))[0],
            strict=True,
        )
    )
    now = motion(SimpleNamespace(**RIDER.values), NUMERIC, at)
    momentum = now.M12 * moving[0] + now.M22 * moving[1]
    outputs = dict(
        zip(
            RIDER.outputs,
            RIDER.derivatives(np.array([at[1], momentum]), np.array([at[0], moving[0], 0.0]))[1],
            strict=True,
        )
    )
    port_inertia = RIDER.run(RIDER.start_values(), NUMERIC)["port_inertia"]
    bar = Handlebar("bar", steer_inertia=0.125, added_steer_inertia=port_inertia).with_effects(PostureInertia())
    found = bar.derivatives(
        np.array([at[0], moving[0]]), np.array([{**outputs, "servo_torque": torque}[n] for n in bar.inputs])
    )[0]
    assert found[1] == pytest.approx(expected["steer_rate"], rel=1e-11, abs=1e-9)  # rounding of torques of 1e3 N.m


class FreeFrame(Component):
    """A frame that turns freely about the steer axis, with a bar on it: momentum is kept, which accelerations would
    show.
    """

    frame_inertia = parameter("kg.m2", "Inertia of the frame about the steer axis", min=0.1, max=10, start=2.0)
    bar_inertia = parameter("kg.m2", "Inertia of the bar", min=0.01, max=10, start=0.3)
    added_steer_inertia = parameter("kg.m2", "Inertia that the rider adds to the bar", min=-5, max=5)
    handlebar_torque, frame_torque = port_input("handlebar_torque"), port_input("frame_torque")
    steer_angle, steer_rate = port_state("steer_angle"), port_state("steer_rate")
    frame_rate = replace(port_state("frame_rate"), role="state", exposed=True)

    def mass(self, v, m):
        bar = v.bar_inertia + v.added_steer_inertia
        return {("steer_rate", "steer_rate"): bar, ("steer_rate", "frame_rate"): bar, ("frame_rate", "steer_rate"): bar,
                ("frame_rate", "frame_rate"): bar + v.frame_inertia}  # fmt: skip

    def equations(self, v, m):
        return {
            "der(steer_angle)": v.steer_rate,
            "der(steer_rate)": v.handlebar_torque,
            "der(frame_rate)": v.handlebar_torque + v.frame_torque,
        }


@pytest.mark.study
@pytest.mark.parametrize("with_posture_inertia", [True, False])
def test_on_a_moving_frame_the_posture_inertia_conserves_momentum_and_energy(with_posture_inertia):
    rider = RIDER.with_values(**WITHOUT_DAMPERS, gravity=0.0)
    frame = FreeFrame("frame", added_steer_inertia=rider.run(rider.start_values(), NUMERIC)["port_inertia"])
    system = System(
        "free", {"vehicle": frame.with_effects(PostureInertia()) if with_posture_inertia else frame, "device": rider}
    )
    v = SimpleNamespace(**rider.values)

    def kept(x):
        """Momentum about the steer axis and energy, from the mass matrix of the limbs; the frame turns bar and torso
        alike.
        """
        at = dict(zip(system.states, x, strict=True))
        posture = at["vehicle.steer_angle"], at["device.torso_angle"]
        now, bar, frame_rate = (
            motion(v, NUMERIC, posture),
            at["vehicle.steer_rate"] + at["vehicle.frame_rate"],
            at["vehicle.frame_rate"],
        )
        torso = (at["device.torso_momentum"] - now.M12 * bar) / now.M22
        momentum = (now.M11 + 0.3 + now.M12) * bar + (now.M12 + now.M22) * torso + 2.0 * frame_rate
        kinetic = ((now.M11 + 0.3) * bar**2 + now.M22 * torso**2 + 2.0 * frame_rate**2) / 2 + now.M12 * bar * torso
        return momentum, kinetic + full_rider_by_angles.potential(rider.values, np.array(posture)).real

    start = np.array([{"vehicle.steer_angle": 0.1, "vehicle.frame_rate": 0.5}.get(n, 0.0) for n in system.states])
    none = np.zeros(len(system.inputs))
    solution = solve_ivp(
        lambda t, x: system.derivatives(x, none)[0], (0, 0.15), start, method="DOP853", rtol=1e-9, atol=1e-11
    )
    momentum, energy = np.array([kept(x) for x in solution.y.T]).T
    swing = np.ptp(solution.y[system.states.index("vehicle.steer_angle")])
    assert swing > 0.1
    errors = (
        np.ptp(momentum) / np.abs(momentum).max(),
        np.ptp(energy) / (energy.max() - full_rider_by_angles.potential(rider.values, np.zeros(2)).real),
    )
    if with_posture_inertia:
        assert max(errors) < 1e-7  # of the integration
    else:
        assert 1e-4 < max(errors) < 0.1  # what a vehicle with a constant inertia loses at 6 deg


@pytest.mark.study
def test_many_postures_linearise_at_once_as_one_by_one():
    """Away from rest the slopes of the mass matrix count, times accelerations that differ from posture to posture."""
    rig, steer = on_rig(RIDER), np.array([-0.1, 0.0, 0.07])
    together = linearise(rig, steer_angle=steer, servo_torque=20.0, steer_rate=1.0)
    for k, angle in enumerate(steer):
        alone = linearise(rig, steer_angle=float(angle), servo_torque=20.0, steer_rate=1.0)
        for name in "ABCD":
            matrix = getattr(together, name)
            one = matrix[k] if matrix.ndim == 3 else matrix
            assert np.allclose(one, getattr(alone, name), rtol=1e-11, atol=1e-8), name  # of entries of 1e3 and more
