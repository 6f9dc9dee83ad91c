"""Suspensions, tyre deflection and longitudinal slip of the touring motorcycle: preloads, limits, load transfer, names."""

import numpy as np
import pytest

from fmus.support.errors import InputError
from tests.vehicle_fmu.test_large_motion import LOCKED, TUM, in_plane
from vehicle_fmu.large_motion.corner_modes import corner_modes
from vehicle_fmu.large_motion.equations import ENDS, LargeMotion
from vehicle_fmu.large_motion.plane_modes import plane_modes
from vehicle_fmu.large_motion.steady_turning import SteadyTurning
from vehicle_fmu.large_motion.suspension import SUSPENSIONS, RearLinkage
from vehicle_fmu.large_motion.touring_tree import PLANE, check_large_motion

DEFLECTING = (*SUSPENSIONS, *(f"{end}_tyre_deflection" for end in ENDS))


@pytest.fixture(scope="module")
def turning():
    return SteadyTurning(LargeMotion(TUM), 30.0)


def test_printed_lengths_and_preloads_are_those_of_equilibrium():
    """The model prints the spring's length, the rod's length, and preloads found by simulation."""
    linkage = RearLinkage({**TUM.values, **TUM.supplement})
    assert linkage.length == pytest.approx(0.313521, abs=1e-6)  # digits printed
    assert linkage.rod == pytest.approx(0.17324, abs=2e-6)
    still = SteadyTurning(LargeMotion(TUM.with_values(drag=0.0, lift=0.0, pitching_moment=0.0)), 1.0).at(0.0)
    names, p = list(still.found.__dict__["sinking"]), {**TUM.values, **TUM.supplement}
    assert names == list(ENDS)
    motion = LargeMotion(TUM)
    for name in DEFLECTING:
        position = still.x[motion.states.index(f"{name}_position")]
        shortened = linkage.compression(position)[0] if name == "rear_suspension" else position
        # The springs' forces differ from the printed ones by what rounding of 0.01 N and the printed lengths leave.
        assert abs(p[f"{name}_stiffness"] * shortened) < 0.05, name


def test_the_linkage_moves_as_two_circles_and_a_rod():
    """Compression by the intersection of circles, found numerically, and its slope by differences."""
    from scipy.optimize import brentq  # noqa: PLC0415

    p = {**TUM.values, **TUM.supplement}
    linkage = RearLinkage(p)

    def point(name):
        return np.array([p[f"{name}_x"], p[f"{name}_z"]])

    def turned(angle, arm):
        return np.array([[np.cos(angle), np.sin(angle)], [-np.sin(angle), np.cos(angle)]]) @ arm

    def length(angle):
        joint = point("swingarm_axis") + turned(angle, point("swingarm_rod"))

        def excess(rocker):
            return np.linalg.norm(point("rocker_pivot") + turned(rocker, point("rocker_rod")) - joint) - linkage.rod

        rocker = brentq(excess, -0.6, 0.6, xtol=1e-15)
        return np.linalg.norm(point("rocker_pivot") + turned(rocker, point("rocker_spring")) - point("rear_spring_top"))

    for angle in (-0.1, 0.0, 0.05, 0.15):
        shortened, ratio = linkage.compression(angle)
        assert shortened == pytest.approx(linkage.length - length(angle), abs=1e-12)
        slope = -(length(angle + 1e-5) - length(angle - 1e-5)) / 2e-5
        assert ratio == pytest.approx(slope, rel=1e-7)  # differences
    at_rest, further = linkage.compression(np.array([0.0, 0.1]))[1]
    assert further > at_rest  # progressive


@pytest.mark.slow
@pytest.mark.parametrize("lean", [0.0, 30.0])
def test_stiff_suspensions_and_tyres_recover_the_rigid_motorcycle(lean):
    """The error of the modes out of the plane falls as 1 / k."""
    rigid = SteadyTurning(LargeMotion(in_plane(LOCKED, 0)), 30.0)
    wanted = np.linalg.eigvals(rigid.linearised(rigid.at(np.radians(lean)))[0])
    wanted = wanted[np.abs(wanted) < 100]
    errors = []
    for factor in (300.0, 3000.0):
        stiff = {f"{n}_stiffness": factor * TUM.supplement[f"{n}_stiffness"] for n in DEFLECTING}
        stiff = in_plane(TUM, 1, front_longitudinal_slip=0.0, rear_longitudinal_slip=0.0, **stiff)
        found = SteadyTurning(LargeMotion(stiff), 30.0)
        equilibrium = found.at(np.radians(lean))
        values = np.linalg.eigvals(found.linearised(equilibrium)[0])
        errors.append(np.abs(values[:, None] - wanted).min(axis=0).max())
    assert errors[1] / errors[0] == pytest.approx(0.1, rel=0.15)  # the next order in 1 / k


@pytest.mark.slow
def test_stiff_tyres_lengthwise_roll_without_slip():
    """The error of the modes falls as 1 / K_x, at a constant peak of the longitudinal force per stiffness.

    Without aligning moments: their equivalent slip angle has K_x kappa, which stays; and without combined slip of the
    side force, which is of order kappa too.
    """
    trail = {f"{end}_{n}": 0.0 for end in ENDS for n in ("qDz1", "qDz2", "qDz8", "qDz9")}
    no_trail = LOCKED.with_values(**trail)
    no_trail.supplement.update({f"{end}_{n}": 0.0 for end in ENDS for n in ("qDz10", "qDz11")})
    rigid = SteadyTurning(LargeMotion(no_trail), 30.0)
    wanted = np.linalg.eigvals(rigid.linearised(rigid.at(0.4))[0])
    errors = []
    for factor in (1e2, 1e3, 1e4):
        grip = {f"{end}_{n}": factor * TUM.supplement[f"{end}_{n}"] for end in ENDS
                for n in ("pDx1", "pDx2", "pKx1", "pKx2")}  # fmt: skip
        slipping = in_plane(no_trail, 0, front_longitudinal_slip=1.0, rear_longitudinal_slip=1.0, **grip)
        found = SteadyTurning(LargeMotion(slipping), 30.0)
        errors.append(np.abs(np.linalg.eigvals(found.linearised(found.at(0.4))[0])[:, None] - wanted).min(axis=0).max())
    assert np.divide(errors[1:], errors[:-1]) == pytest.approx(0.1, rel=0.15)  # the next order in 1 / K_x


@pytest.mark.parametrize("name", PLANE)
def test_freedoms_are_locked_one_by_one(name):
    turning = SteadyTurning(LargeMotion(in_plane(TUM, 1, **{name: 0.0})), 30.0)
    whole = LargeMotion(TUM).states
    missing = set(whole) - set(turning.motion.states)
    assert missing == ({name} if "slip" in name else {f"{name}_rate", f"{name}_position"})
    assert turning.at(0.0).residual < 1e-7
    with pytest.raises(InputError, match=rf"{name} = 0.5 must be 1 \(free\) or 0 \(locked\)"):
        check_large_motion(in_plane(TUM, 1, **{name: 0.5}))


# Longitudinal acceleration ------------------------------------------------------------------------


@pytest.mark.slow
@pytest.mark.parametrize("acceleration", [-6.0, -1.0, 4.0])
@pytest.mark.parametrize("lean", [0.0, 25.0])
def test_forces_balance_under_acceleration(turning, acceleration, lean):
    equilibrium = turning.at(np.radians(lean), acceleration)
    found, motion = turning.motion.at(equilibrium.x, equilibrium.u), turning.motion
    wanted = np.where(np.arange(len(equilibrium.x)) == 0, acceleration, 0.0)
    assert found.rates == pytest.approx(wanted, abs=1e-6)
    p, masses = motion.values, motion.tree.mass
    assert sum(equilibrium.load.values()) == pytest.approx(masses.sum() * p.gravity - p.lift * 30.0**2, rel=1e-10)
    # Newton's second law along the road: the mass centre has the acceleration a of A and that of the turn.
    along = sum(found.longitudinal_force[end] * found.wheels[end].ahead[0]
                + found.side_force[end] * found.wheels[end].right[0] for end in ENDS) - p.drag * 30.0**2  # fmt: skip
    yaw_rate, centre = equilibrium.x[2], masses @ motion.tree.centres(found.motion) / masses.sum()
    turned = acceleration - yaw_rate * (equilibrium.x[1] + yaw_rate * centre[0])
    assert along == pytest.approx(masses.sum() * turned, rel=1e-9)
    brakes = equilibrium.u[[4, 0]]
    if acceleration < 0:
        assert brakes[0] / brakes.sum() == pytest.approx(0.8)  # the published distribution
    else:
        assert brakes[0] == 0.0


@pytest.mark.slow
@pytest.mark.parametrize("speed, acceleration, front, reason", [
    (10.0, 20.0, 0.8, r"the front wheel carries \d+ N \(wheelie\)"),
    (20.0, -20.0, 1.0, r"the rear wheel carries \d+ N \(stoppie\)"),
    (20.0, -20.0, 0.8, r"the rear tyre gives (99|100) % of its greatest longitudinal force"),
])  # fmt: skip
def test_where_acceleration_ends_is_named(speed, acceleration, front, reason):
    with pytest.raises(InputError, match=rf"no equilibrium at {speed:g} m/s, a lean angle of 0 deg and a longitudinal "
                       rf"acceleration of {acceleration:g} m/s2: equilibria end near -?\d+\.\d+ m/s2, where {reason}"):  # fmt: skip
        SteadyTurning(LargeMotion(in_plane(TUM, 1, front_brake_share=front)), speed).at(0.0, acceleration)


@pytest.mark.slow
def test_little_grip_ends_acceleration_at_the_grip():
    slippery = in_plane(TUM, 1, front_pDx1=0.3, rear_pDx1=0.3)
    turning = SteadyTurning(LargeMotion(slippery), 20.0)
    with pytest.raises(InputError, match=r"the rear tyre gives (99|100) % of its greatest longitudinal force"):
        turning.at(0.0, 6.0)
    last = turning.accelerated[-1]
    greatest = turning.motion.tyres["rear"].longitudinal_use(last.load["rear"], 0.0)[0]
    assert 0.97 < last.longitudinal_force["rear"] / greatest <= 1.0


# Modes --------------------------------------------------------------------------------------------


def test_modes_in_the_plane_are_those_of_two_masses_in_series(turning):
    """With a light rear damper: hop and fork frequencies near those of the masses on their springs by themselves."""
    light = in_plane(TUM, 1, rear_suspension_damping=1165.0, fork_lengthwise_bending=0.0)
    found = SteadyTurning(LargeMotion(light), 30.0)
    upright = found.at(0.0)
    named = plane_modes(found.motion, found.linearised(upright)[0], upright.found, found.motion.states)
    assert set(named) == {"bounce", "pitch", "front_hop", "rear_hop"}
    p, s = TUM.values, TUM.supplement
    front = p["lower_fork_mass"] + p["front_wheel_mass"]
    k = s["front_tyre_deflection_stiffness"] + s["front_suspension_stiffness"]
    assert abs(named["front_hop"]) == pytest.approx(np.sqrt(k / front), rel=0.1)  # the frame moves little
    whole = sum(turning.motion.tree.mass)
    wheel_rate = s["rear_suspension_stiffness"] * (0.30395 / 0.549) ** 2
    in_series = [1 / (1 / a + 1 / b) for a, b in ((s["front_suspension_stiffness"], s["front_tyre_deflection_stiffness"]),
                                                  (wheel_rate, s["rear_tyre_deflection_stiffness"]))]  # fmt: skip
    assert abs(named["bounce"]) == pytest.approx(np.sqrt(sum(in_series) / whole), rel=0.15)  # pitch is coupled
    assert abs(named["pitch"]) > abs(named["bounce"])


@pytest.mark.slow
def test_modes_are_followed_over_lean_and_acceleration(turning):
    leans, accelerations = np.radians([0.0, 20.0, 20.0, 20.0]), np.array([0.0, 0.0, 2.0, -4.0])
    found = corner_modes(turning, TUM, [], leans, accelerations)
    assert {"weave", "wobble", "bounce", "pitch", "front_hop", "rear_hop", "fork_bending"} <= set(found.named)
    for k, (lean, acceleration) in enumerate(zip(leans, accelerations, strict=True)):
        A = turning.linearised(turning.at(lean, acceleration))[0][1:, 1:]  # forward speed is held
        wanted = np.linalg.eigvals(A)
        for name, mode in found.named.items():
            assert np.abs(wanted - mode.eigenvalue[k]).min() < 1e-6 * abs(mode.eigenvalue[k]), name
    frequency = {name: mode.frequency for name, mode in found.named.items()}
    assert (np.abs(frequency["wobble"] - 9.5) < 1.5).all() and (np.abs(frequency["weave"] - 3.3) < 0.6).all()
    assert (np.abs(frequency["bounce"] - 2.3) < 0.3).all() and (np.abs(frequency["front_hop"] - 12.2) < 1.0).all()


@pytest.mark.slow
def test_without_freedoms_in_the_plane_acceleration_has_the_modes_of_straight_running():
    turning = SteadyTurning(LargeMotion(LOCKED), 30.0)
    found = corner_modes(turning, LOCKED, [], np.zeros(2), np.array([0.0, -2.0]))
    assert set(found.named) == {"weave", "wobble", "capsize", "rear_wobble"}
    assert found.named["weave"].eigenvalue[0] == pytest.approx(-3.78 + 22.2j, abs=0.1)
    assert turning.at(0.0, -2.0).residual < 1e-8


@pytest.mark.parametrize("name, value, wanted", [
    ("front_suspension_stiffness", 0.0, "above 0"), ("rear_tyre_deflection_damping", -1.0, "0 or above"),
    ("front_brake_share", 1.5, "from 0 to 1"),
])  # fmt: skip
def test_values_without_meaning_are_refused(name, value, wanted):
    with pytest.raises(InputError, match=f"{name} = {value:g} must be {wanted}"):
        check_large_motion(in_plane(TUM, 1, **{name: value}))
