"""The touring motorcycle in large motion: straight running, equilibria, energy, mirrored turns."""

import numpy as np
import pytest

from fmus import linearise
from fmus.expressions.functions import NUMERIC
from fmus.support.errors import InputError
from rider_fmu import riders
from vehicle_fmu import modes, motorcycles, over_speed, ridden
from vehicle_fmu.components.touring_motorcycle import FLEXIBLE
from vehicle_fmu.large_motion import plane_modes
from vehicle_fmu.large_motion.corner_modes import corner_modes, held
from vehicle_fmu.large_motion.equations import ENDS, LargeMotion
from vehicle_fmu.large_motion.steady_turning import SteadyTurning
from vehicle_fmu.large_motion.touring_tree import PLANE, check_large_motion


def in_plane(motorcycle, free, **values):
    """The motorcycle with all freedoms in its plane free (1) or locked (0), and supplementary values."""
    changed = motorcycle.with_values()
    changed.supplement.update(dict.fromkeys(PLANE, float(free)) | values)
    return changed


TUM = motorcycles.load("tum_2020")
LOCKED = in_plane(TUM, 0)
RIGID = LOCKED.with_values(**dict.fromkeys(FLEXIBLE, 0.0))
STEP = 1e-30


@pytest.fixture(scope="module")
def turning():
    return SteadyTurning(LargeMotion(LOCKED), 30.0)


@pytest.fixture(scope="module")
def free():
    return SteadyTurning(LargeMotion(TUM), 30.0)


# Straight running ---------------------------------------------------------------------------------


@pytest.mark.slow
@pytest.mark.parametrize("speed", [5.0, 20.0, 45.0, 80.0])
@pytest.mark.parametrize(
    "motorcycle", [LOCKED, LOCKED.with_values(fork_bending=0.0, rider_lean=0.0, added_steer_inertia=0.3)]
)
def test_upright_it_is_the_linear_motorcycle(motorcycle, speed):
    upright = SteadyTurning(LargeMotion(motorcycle), speed)
    A, B, C, _ = upright.linearised(upright.at(0.0))
    straight = linearise(ridden(motorcycle), **{"vehicle.speed": speed})
    rows = [straight.states.index(f"vehicle.{n}") for n in upright.motion.states[1:]]
    own = range(1, len(A))
    wanted = straight.A[np.ix_(rows, rows)]
    # Rounding of two independent derivations, against the largest entry of each row.
    assert (np.abs(A[np.ix_(own, own)] - wanted) <= 1e-11 * np.abs(wanted).max(axis=1, keepdims=True)).all()
    assert (
        np.abs(A[0, 1:]).max() < 1e-7 and np.abs(A[1:, 0]).max() < 1e-9
    )  # forward speed is apart, to the equilibrium's residual
    inputs = [straight.inputs.index(f"vehicle.{n}") for n in ("steer_torque", "handlebar_torque", "frame_torque")]
    assert B[np.ix_(own, [1, 2, 3])] == pytest.approx(straight.B[np.ix_(rows, inputs)], rel=1e-9, abs=1e-10)
    frame_rate = straight.C[straight.outputs.index("vehicle.frame_rate")]
    assert C[4, own] == pytest.approx(frame_rate[rows], abs=1e-12)


def test_upright_loads_are_those_of_the_linear_motorcycle(turning):
    equilibrium = turning.at(0.0)
    computed = TUM.run({**TUM.start_values(), "speed": 30.0}, NUMERIC)
    assert list(equilibrium.load.values()) == pytest.approx([computed["front_load"], computed["rear_load"]], rel=1e-12)


# Equilibria ---------------------------------------------------------------------------------------


@pytest.mark.slow
@pytest.mark.parametrize("lean", [15.0, 30.0, 45.0])
@pytest.mark.parametrize("which", ["turning", "free"])
def test_forces_balance_in_steady_turning(request, which, lean):
    turning = request.getfixturevalue(which)
    equilibrium = turning.at(np.radians(lean))
    p, mass = turning.motion.values, turning.motion.tree.mass.sum()
    assert equilibrium.residual < 1e-8  # N, N.m: rounding of weights of 2500 N
    assert np.abs(turning.motion.at(equilibrium.x, equilibrium.u).rates).max() < 1e-7
    assert sum(equilibrium.load.values()) == pytest.approx(mass * p.gravity - p.lift * 30.0**2, rel=1e-11)
    # The mass centre circles about the axis of the turn: its acceleration is across its velocity, r times it.
    found = turning.motion.at(equilibrium.x, equilibrium.u)
    across = sum(
        found.side_force[end] * found.wheels[end].right[1] + found.longitudinal_force[end] * found.wheels[end].ahead[1]
        for end in ENDS
    )
    yaw_rate = equilibrium.x[2]
    masses = turning.motion.tree.mass
    along = found.w[0] - yaw_rate * (masses @ turning.motion.tree.centres(found.motion)[:, 1]) / mass
    assert across == pytest.approx(mass * yaw_rate * along, rel=1e-9)


@pytest.mark.slow
@pytest.mark.parametrize("which, acceleration", [("turning", 0.0), ("free", 0.0), ("free", 3.0), ("free", -4.0)])
def test_left_is_the_mirror_of_right(request, which, acceleration):
    turning = request.getfixturevalue(which)
    for lean in (15.0, 40.0) if which == "turning" else (30.0,):
        right, left = (turning.at(np.radians(side * lean), acceleration) for side in (1, -1))
        names = turning.motion.states
        sign = np.where(plane_modes.in_plane(names), 1, -1)
        assert left.x == pytest.approx(sign * right.x, abs=1e-10)
        assert left.u == pytest.approx(right.u * [1, -1, 1, 1, 1], abs=1e-7)
        spectra = [np.sort_complex(np.linalg.eigvals(turning.linearised(each)[0])) for each in (left, right)]
        assert spectra[0] == pytest.approx(spectra[1], rel=1e-8)


@pytest.mark.slow
def test_the_end_of_equilibria_is_named():
    with pytest.raises(
        InputError,
        match=r"no steady turning at 20 m/s and a lean angle of 70 deg: equilibria end near 6\d\.\d deg, "
        r"where the (front|rear) tyre gives (99|100) % of its greatest side force",
    ):
        SteadyTurning(LargeMotion(RIGID), 20.0).at(np.radians(70.0))
    with pytest.raises(InputError, match="no equilibrium at 95 m/s, upright: drag or lift unloads a wheel"):
        SteadyTurning(LargeMotion(RIGID), 95.0)


@pytest.mark.slow
@pytest.mark.parametrize("speed, lean, last", [(70.0, 40.0, 25.0), (10.0, 56.0, 35.0)])
def test_where_loads_are_not_determined_there_are_no_modes(speed, lean, last):
    turning = SteadyTurning(LargeMotion(LOCKED), speed)
    assert np.isfinite(turning.linearised(turning.at(np.radians(last)))[0]).all()
    equilibrium = turning.at(np.radians(lean))
    deflecting = SteadyTurning(LargeMotion(TUM), speed)
    assert np.isfinite(deflecting.linearised(deflecting.at(np.radians(lean)))[0]).all()  # tyres determine their loads
    assert equilibrium.residual < 1e-8
    with pytest.raises(
        InputError, match=f"no modes at {speed:g} m/s and a lean angle of {lean:.1f} deg: there is an eq"
    ):
        turning.linearised(equilibrium)


@pytest.mark.study
def test_less_grip_ends_turning_earlier():
    ends = []
    for grip in (1.3, 0.9, 0.5):
        motorcycle = RIGID.with_values()
        motorcycle.supplement.update(front_pDy1=grip, rear_pDy1=grip)
        turning = SteadyTurning(LargeMotion(motorcycle), 20.0)
        with pytest.raises(InputError, match="greatest side force"):
            turning.at(np.radians(75.0))
        accelerations = [each.x[2] * 20.0 / motorcycle.values["gravity"] for each in turning.known]
        ends.append(max(accelerations))
    # Lateral acceleration in units of g and grip agree, but for the position of the speed, A, beside the mass centre.
    assert all(0.95 * grip < end < 1.01 * grip for end, grip in zip(ends, (1.3, 0.9, 0.5), strict=True))


# Energy -------------------------------------------------------------------------------------------


def energy(motion, found):
    """Kinetic and potential energy [J]."""
    mass, _, _ = motion.tree.inertia_terms(found.motion)
    height = motion.tree.centres(found.motion)[..., 2]
    kinetic = 0.5 * (found.w[..., None, :] @ mass @ found.w[..., None])[..., 0, 0]
    p = vars(motion.values)
    deflected = {n: motion.applied.compression(n, found.q)[0] for n in motion.free}
    deflected |= {f"{end}_tyre_deflection": wheel.deflection for end, wheel in found.wheels.items()}
    springs = sum(p.get(f"{n}_preload", 0.0) * s + p[f"{n}_stiffness"] * s**2 / 2 for n, s in deflected.items())
    return kinetic - motion.values.gravity * (height @ motion.tree.mass) + springs


def power(motion, found, u):
    """Power [W] of what is neither weight nor spring: torques of wheels and port, wind, dampers, slip of the tyres."""
    given = sum(force @ found.w for name, force in motion.forces(found, u).items() if name not in ("weight", "springs"))
    slip = sum(found.side_force[end] * wheel.across for end, wheel in found.wheels.items())
    turning = sum(found.yaw_moment[end] * (wheel.turn[2] @ found.w) for end, wheel in found.wheels.items())
    lengthwise = sum(found.longitudinal_force[end] * (wheel.slides @ found.w) for end, wheel in found.wheels.items())
    damped = [getattr(motion.values, f"{end}_tyre_deflection_damping") * found.sinking[end] ** 2 for end in ENDS]
    return given + slip + turning + lengthwise - sum(damped)


def random_state(motion, generator):
    x = generator.normal(size=len(motion.states)) * 0.05
    x[0], x[1], x[motion.states.index("roll_angle")] = 20.0, generator.normal() * 0.5, generator.uniform(-0.8, 0.8)
    x[["tyre_deflection_position" in name for name in motion.states]] *= 0.1
    return x, np.array([50.0, -3.0, 4.0, 2.0, -20.0])


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(5))
@pytest.mark.parametrize("motorcycle", [LOCKED, TUM, in_plane(TUM, 1, front_tyre_deflection=0.0, rear_suspension=0.0),
                                        in_plane(TUM, 0, rear_longitudinal_slip=1.0)])  # fmt: skip
def test_energy_changes_by_the_power_of_the_forces(motorcycle, seed):
    """Along the motion x' = f(x) the derivative of the energy, by a complex step, is the power at x."""
    motion = LargeMotion(motorcycle)
    x, u = random_state(motion, np.random.default_rng(seed))
    found = motion.at(x, u)
    ahead = motion.posed(x + 1j * STEP * found.rates, u + 0j)
    rate = energy(motion, ahead).imag / STEP
    scale = abs(motion.values.gravity * motion.tree.mass.sum() * x[0])  # W: weight times speed
    assert rate == pytest.approx(power(motion, found, u), abs=1e-9 * scale)


def test_the_power_of_the_port_is_that_of_its_definition():
    """T_h (s + w) + T_f w in any motion (`fmus.interfaces.handlebar`)."""
    motion = LargeMotion(TUM)
    x, u = random_state(motion, np.random.default_rng(7))
    found = motion.posed(x, u)
    found.side_force, found.load = dict.fromkeys(ENDS, 0.0), dict.fromkeys(ENDS, 0.0)  # not asked for
    given = motion.outputs(found)
    wanted = u[2] * (given["steer_rate"] + given["frame_rate"]) + u[3] * given["frame_rate"]
    assert abs(wanted) > 0.01  # W
    assert motion.forces(found, u)["handlebar_port"] @ found.w == pytest.approx(wanted, rel=1e-12)


@pytest.mark.study
@pytest.mark.parametrize("which", ["turning", "free"])
def test_energy_balance_of_a_simulated_free_motion(request, which):
    """A push on the bar at 30 deg of lean: the energy gained is the integral of the power."""
    from scipy.integrate import solve_ivp  # noqa: PLC0415

    turning = request.getfixturevalue(which)
    equilibrium, motion = turning.at(np.radians(30.0)), turning.motion
    start = equilibrium.x.copy()
    start[motion.states.index("steer_rate")] += 0.5

    def rates(t, x):
        found = motion.at(x[:-1], equilibrium.u)
        return np.append(found.rates, power(motion, found, equilibrium.u))

    run = solve_ivp(rates, (0.0, 0.3), np.append(start, 0.0), method="DOP853", rtol=1e-9, atol=1e-10)
    ends = [energy(motion, motion.posed(run.y[:-1, k], equilibrium.u)) for k in (0, -1)]
    change = np.abs(run.y[:-1].T - equilibrium.x).max()
    assert change > 0.1  # rad/s: it is no rest
    # The integration's tolerance, against the energy of the motion (0.1 MJ) and its change.
    assert ends[1] - ends[0] == pytest.approx(run.y[-1, -1], abs=1e-9 * abs(ends[0]))


# Modes --------------------------------------------------------------------------------------------


@pytest.mark.parametrize("rider", [pytest.param(None, marks=pytest.mark.slow),
                                   pytest.param("mean_2011", marks=pytest.mark.study)])  # fmt: skip
def test_modes_in_corners_begin_as_those_of_straight_running(rider):
    devices = [riders.load(rider)] if rider else []
    turning = SteadyTurning(LargeMotion(held(LOCKED, devices)), 30.0)
    leans = np.radians([-20.0, 0.0, 20.0])
    found = corner_modes(turning, LOCKED, devices, leans)
    straight = modes(over_speed(ridden(TUM, *devices)), np.array([30.0]))
    for mode in straight.unstable:
        value = found.named[mode].eigenvalue
        # Rounding of two derivations, and of eigenvalues near others.
        assert value[1] == pytest.approx(straight[mode].eigenvalue[0], rel=1e-7)
        assert value[0] == pytest.approx(value[2], rel=1e-6)  # left as right
    nearest = [np.abs(found.eigenvalues[2] - named.eigenvalue[2]).min() for named in found.named.values()]
    assert max(nearest) == 0.0


def test_values_that_corners_need_are_asked_for():
    bare = TUM.with_values()
    bare.supplement.clear()
    with pytest.raises(InputError, match=r"corners need \d+ more values, such as frame_yy; give them in \[supplement\]"):
        check_large_motion(bare)
    with pytest.raises(InputError, match="motorcycle_sharp_1971 is a Motorcycle, which has no equations for corners"):
        check_large_motion(motorcycles.load("sharp_1971"))
