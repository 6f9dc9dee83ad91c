"""Systems: the rider on the motorcycle against matrices written by hand, wiring, and what cannot be wired."""

from math import cos, sin

import numpy as np
import pytest
import scipy.linalg

from fmus import Component, InputError, System, input, linearise, output, parameter, state
from fmus.interfaces.handlebar import HandlebarDevice
from rider_fmu import riders
from vehicle_fmu import LinearDamper, motorcycles, over_speed, ridden


def hand_written(p, q, V):
    """(M, F) of M x' = F x for x = (v, r, p, s, phi, delta, Y_f, Y_r, theta, Omega), row by row from the papers.

    p: the motorcycle's values; q: the rider's. The rider's share of inertia is in I_fz wherever that appears.
    """
    c, S = cos(p["caster_angle"]), sin(p["caster_angle"])
    a, b, e, f, h, t, g, K = (p[n] for n in ("steer_axis_distance", "rear_contact_distance", "front_mass_offset", "front_mass_rise",
                                             "rear_mass_height", "trail", "gravity", "steering_damping"))  # fmt: skip
    Mf, Mr, Zf = p["front_mass"], p["rear_mass"], p["front_tyre_load"]
    Irx, Irz, Crxz = p["rear_roll_inertia"], p["rear_yaw_inertia"], p["rear_product_of_inertia"]
    Ifx, Ifz = p["front_cross_inertia"], p["front_steer_inertia"] + q["added_steer_inertia"]
    Cf1, Cf2, Cr1, Cr2 = (p[f"{end}_{kind}_stiffness"] for end in ("front", "rear") for kind in ("cornering", "camber"))
    sf, sr = p["front_relaxation_length"], p["rear_relaxation_length"]
    hf, hr = V * p["front_spin_inertia"] / p["front_wheel_radius"], V * p["rear_spin_inertia"] / p["rear_wheel_radius"]
    It, ka, kt, ca, ct = (
        q[n] for n in ("torso_inertia", "arm_stiffness", "waist_stiffness", "arm_damping", "waist_damping")
    )
    l, k, j = (a - t) / c, (a + e) * c - f * S, (a + e) * S + f * c
    G = -Zf * t + Mf * e * g
    Ixf, Izf, Cf = Ifx * c**2 + Ifz * S**2, Ifx * S**2 + Ifz * c**2, (Ifz - Ifx) * S * c

    M = np.eye(10)
    M[:4, :4] = [[Mf + Mr, Mf * k, Mf * j + Mr * h, Mf * e],
                 [Mf * k, Irz + Izf + Mf * k**2, Mf * j * k - Crxz + Cf, Mf * e * k + Ifz * c],
                 [Mf * j + Mr * h, Mf * j * k - Crxz + Cf, Irx + Ixf + Mr * h**2 + Mf * j**2, Mf * e * j + Ifz * S],
                 [Mf * e, Mf * e * k + Ifz * c, Mf * e * j + Ifz * S, Ifz + Mf * e**2]]  # fmt: skip
    M[6, 6], M[7, 7], M[9, 9] = sf / V, sr / V, It
    # theta' = Omega - w with w = r c + p S; T_a = ka (theta - delta) + ca (theta' - s), T_w = kt theta + ct theta'
    v, r, p_, s, phi, delta, Yf, Yr, theta, Omega = np.eye(10)
    relative = Omega - c * r - S * p_
    Ta, Tw = ka * (theta - delta) + ca * (relative - s), kt * theta + ct * relative
    F = np.array([
        Yf + Yr - (Mf + Mr) * V * r,
        l * Yf - b * Yr + (Ta + Tw) * c - Mf * k * V * r + (hf + hr) * p_ + hf * S * s,
        (Ta + Tw) * S - (Mf * j + Mr * h) * V * r - (hf + hr) * r - hf * c * s + (Mf * j + Mr * h) * g * phi + G * delta,
        -t * Yf + Ta - Mf * e * V * r - hf * S * r + hf * c * p_ - K * s + G * phi + G * S * delta,
        p_,
        s,
        -Yf + Cf1 * (c * delta - (v + l * r - t * s) / V) + Cf2 * (phi + S * delta),
        -Yr - Cr1 * (v - b * r) / V + Cr2 * phi,
        relative,
        -Ta - Tw,
    ])  # fmt: skip
    return M, F


@pytest.mark.slow
@pytest.mark.parametrize("speed", [1.0, 6.7, 17.8, 34.0, 60.0])
@pytest.mark.parametrize("rider", ["mean_2011", "7_2011", "9_2011", "10_2011", "3_2008"])
def test_rider_and_motorcycle_are_the_matrices_written_by_hand(rider, speed):
    motorcycle, device = motorcycles.load("sharp_1971"), riders.load(rider)
    M, F = hand_written(motorcycle.values, device.values, speed)
    expected = scipy.linalg.eigvals(F, M)
    found = np.linalg.eigvals(over_speed(ridden(motorcycle, device))(np.array([speed])).A[0])
    # 1e-9 of the eigenvalue: two ways of solving the same matrices, conditions of which are below 1e5.
    distance = np.abs(found[:, None] - expected).min(axis=1)
    assert (distance <= 1e-9 * np.abs(found)).all()
    assert len(found) == 10


@pytest.mark.slow
def test_a_damper_at_the_port_is_more_of_the_motorcycles_own():
    """T_h = -c s on the front and +c s on the rear frame is what the steering damper K does."""
    motorcycle = motorcycles.load("sharp_1971")
    speeds = np.array([5.0, 30.0, 55.0])
    own = motorcycle.with_values(steering_damping=motorcycle.values["steering_damping"] + 7.5)
    expected = np.sort_complex(np.linalg.eigvals(over_speed(ridden(own))(speeds).A))
    found = np.sort_complex(np.linalg.eigvals(over_speed(ridden(motorcycle, LinearDamper(damping=7.5)))(speeds).A))
    assert found == pytest.approx(expected, rel=1e-9)


@pytest.mark.slow
def test_a_riders_share_of_inertia_reaches_the_motorcycle():
    motorcycle, rider = motorcycles.load("sharp_1971"), riders.load("10_2011")
    system = ridden(motorcycle, rider)
    assert "vehicle.added_steer_inertia" not in system.table
    loaded = motorcycle.with_values(added_steer_inertia=0.1431)
    unbound = System("both", {"vehicle": loaded, "device": rider})
    assert linearise(system).A == pytest.approx(linearise(unbound).A, rel=1e-12)


@pytest.mark.slow
def test_torques_of_several_devices_add_up():
    motorcycle, rider = motorcycles.load("sharp_1971"), riders.load("mean_2011")
    both = System("both", {"vehicle": motorcycle, "rider": rider, "damper": LinearDamper(damping=3.0)})
    own = System(
        "own",
        {
            "vehicle": motorcycle.with_values(steering_damping=motorcycle.values["steering_damping"] + 3.0),
            "rider": rider,
        },
    )
    assert np.sort_complex(np.linalg.eigvals(linearise(both).A)) == pytest.approx(
        np.sort_complex(np.linalg.eigvals(linearise(own).A)), rel=1e-9
    )


@pytest.mark.slow
def test_a_system_in_a_system_is_the_same():
    motorcycle, rider = motorcycles.load("sharp_1971"), riders.load("mean_2011")
    inner = ridden(motorcycle, rider)
    outer = System("outer", {"all": inner})
    assert linearise(outer).A == pytest.approx(linearise(inner).A, rel=1e-12)
    assert outer.states == tuple(f"all.{n}" for n in inner.states)


@pytest.mark.slow
def test_values_of_the_parts_are_set_by_their_path():
    system = ridden(motorcycles.load("sharp_1971"), riders.load("mean_2011")).with_values(
        **{"device.arm_damping": 33.0}
    )
    assert system.values["device.arm_damping"] == 33.0
    expected = ridden(motorcycles.load("sharp_1971"), riders.load("mean_2011", arm_damping=33.0))
    assert linearise(system).A == pytest.approx(linearise(expected).A, rel=1e-12)


# What cannot be wired -----------------------------------------------------------------------------


class Gain(Component):
    """Answers its input times a gain, at once."""

    gain = parameter("1", "Gain", start=0.5)
    input_force = input("N", "Input")
    answer = output("N", "Output")

    def equations(self, v, m):
        return {"answer": v.gain * v.input_force}


class Speaker(Component):
    """Answers a length."""

    length = output("m", "A length")
    answer = output("N", "A force")
    level = state("1", "Level")

    def equations(self, v, m):
        return {"der(level)": -v.level, "length": 1.0, "answer": v.level}


def test_an_algebraic_loop_is_spelled_out():
    with pytest.raises(
        InputError, match=r"algebraic loop: .*a\.answer.*<-.*b\.answer.*; break it with a state or a delay"
    ):
        System("loop", {"a": Gain(), "b": Gain()}, {"a.input_force": ["b.answer"], "b.input_force": ["a.answer"]})


def test_a_loop_through_a_state_is_none():
    system = System("chain", {"speaker": Speaker(), "gain": Gain(gain=4.0)}, {"gain.input_force": ["speaker.answer"]})
    _, outputs = system.derivatives(np.array([2.0]), np.zeros(0))
    assert dict(zip(system.outputs, outputs, strict=True))["gain.answer"] == 8.0


def test_two_writers_of_one_motion_are_refused():
    motorcycle, other = motorcycles.load("sharp_1971"), motorcycles.load("reference_2011")
    with pytest.raises(InputError, match=r"device\.steer_angle has 2 writers: first\.steer_angle, second\.steer_angle"):
        System("two", {"first": motorcycle, "second": other, "device": LinearDamper()})


@pytest.mark.parametrize("wiring, message", [
    ({"gain.input_force": ["speaker.length"]}, r"speaker\.length \[m\] cannot drive gain\.input_force \[N\]: the units differ"),
    ({"gain.asked": ["speaker.answer"]}, r"unknown input of gain 'asked' \(valid: input_force\)"),
    ({"gain.input_force": ["speaker.loudness"]}, r"unknown output of speaker 'loudness' \(valid: answer, length, level\)"),
    ({"amplifier.input_force": ["speaker.answer"]}, r"unknown part of the system 'amplifier' \(valid: gain, speaker\)"),
])  # fmt: skip
def test_wiring_that_cannot_be_is_named(wiring, message):
    with pytest.raises(InputError, match=message):
        System("wrong", {"speaker": Speaker(), "gain": Gain()}, wiring)


def test_every_device_fits_where_every_other_does():
    motorcycle = motorcycles.load("sharp_1971")
    devices = [d for d in (riders.load("mean_2011"), LinearDamper()) if isinstance(d, HandlebarDevice)]
    inputs = {frozenset(ridden(motorcycle, device).inputs) for device in devices}
    assert inputs == {frozenset({"vehicle.speed", "vehicle.steer_torque", "vehicle.roll_torque", "vehicle.lateral_force"})}
