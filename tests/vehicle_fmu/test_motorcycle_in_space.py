"""The touring motorcycle in large motion as a component and as an FMU: the model of `vehicle_fmu.large_motion`."""

import time

import numpy as np
import pytest

from fmus.cosimulation.simulate import simulate
from fmus.cosimulation.subsystems.fmu_subsystem import FmuSubsystem
from fmus.export.build import build
from fmus.expressions.functions import NUMERIC
from fmus.support.errors import InputError
from tests.vehicle_fmu.test_large_motion import LOCKED, TUM, energy, power, random_state
from vehicle_fmu import motorcycles
from vehicle_fmu.large_motion.applied_forces import INPUTS
from vehicle_fmu.large_motion.equations import ENDS, LargeMotion
from vehicle_fmu.large_motion.in_space import POSITIONS, RATES, in_large_motion, start_of, states_of
from vehicle_fmu.large_motion.steady_turning import SteadyTurning

BIKE = in_large_motion(TUM)
SPEED, STEP = 30.0, 1e-3  # m/s, s
PATH = ("path_x", "path_y", "heading")
NOWHERE = ("along", "lateral", "yaw")  # coordinates on which nothing depends


@pytest.fixture(scope="module")
def turning():
    return SteadyTurning(LargeMotion(TUM), SPEED)


@pytest.fixture(scope="module")
def archive(tmp_path_factory):
    return build(BIKE, tmp_path_factory.mktemp("in_space")).path


@pytest.fixture
def fmu(archive, turning):
    """The FMU in steady turning at a lean angle [deg], with some of its starts replaced."""
    opened = []

    def started(lean, **values):
        start = start_of(turning.motion, turning.at(np.radians(lean))) | values
        opened.append(FmuSubsystem(archive, "bike", start))
        return opened[-1]

    yield started
    for each in opened:
        each.close()


def vectors(values):
    return (np.array([values[name] for name in names]) for names in (BIKE.states, BIKE.inputs))


# The equations ------------------------------------------------------------------------------------


def test_values_are_those_of_the_value_file():
    assert BIKE.values == {n: {**TUM.values, **TUM.supplement}[n] for n in BIKE.values}
    contents = motorcycles.contents("tum_2020")
    units = {n: e["unit"] for section in ("parameters", "supplement") for n, e in contents[section].items()}
    assert {n: row.unit for n, row in BIKE.rows("parameter").items() if n in units} == {
        n: unit for n, unit in units.items() if n in BIKE.values
    }
    with pytest.raises(InputError, match="front_suspension = 0, but the component in large motion has all"):
        in_large_motion(LOCKED)
    with pytest.raises(InputError, match="has no equations for corners"):
        in_large_motion(motorcycles.load("sharp_1971"))


def test_accelerations_are_those_of_the_formulation_with_conditions():
    """Height, pitch and spins as states, in axes of the frame; deflections and slips as states, in fixed axes."""
    motion, generator = LargeMotion(TUM), np.random.default_rng(1)
    for _ in range(100):
        x, _ = random_state(motion, generator)
        x[0] = generator.uniform(3, 60)
        u = generator.normal(size=5) * [100, 10, 10, 10, 50]
        found = motion.at(x, u)
        rates, outputs = BIKE.derivatives(*vectors(states_of(motion, found) | dict(zip(INPUTS, u, strict=True))))
        rates, outputs = dict(zip(BIKE.states, rates, strict=True)), dict(zip(BIKE.outputs, outputs, strict=True))
        wanted = {RATES.get(n, f"{n}_rate"): found.acceleration[k] for n, k in motion.place.items()}
        wanted |= {f"{end}_relaxed_slip": found.rates[k - 2] for k, end in enumerate(ENDS)}
        largest = max(map(abs, wanted.values()))
        # Rounding of a solution with a mass matrix of condition 1e6 and of forces of 1e5 N that cancel.
        assert [rates[n] for n in wanted] == pytest.approx(list(wanted.values()), rel=1e-9, abs=1e-11 * largest)
        shown = motion.outputs(found) | {f"{end}_longitudinal_force": found.longitudinal_force[end] for end in ENDS}
        assert [outputs[n] for n in shown] == pytest.approx([*map(float, shown.values())], rel=1e-9, abs=1e-8)


def kinetic_energy(values):
    entries = BIKE.mass_entries(values, NUMERIC)
    return 0.5 * sum(float(m) * values[row] * values[column] for (row, column), m in entries.items())


def test_the_mass_matrix_is_that_of_the_kinetic_energy():
    motion = LargeMotion(TUM)
    for seed in range(5):
        x, u = random_state(motion, np.random.default_rng(seed))
        found = motion.at(x, u)
        wanted = 0.5 * found.w @ found.mass @ found.w
        values = {**BIKE.start_values(), **states_of(motion, found)}
        assert kinetic_energy(values) == pytest.approx(wanted, rel=1e-12)  # rounding


@pytest.mark.slow
@pytest.mark.parametrize("lean", [0.0, 30.0])
def test_steady_turning_is_an_equilibrium_with_the_modes_of_trim(turning, lean):
    equilibrium = turning.at(np.radians(lean))
    at = start_of(turning.motion, equilibrium)
    rates = dict(zip(BIKE.states, BIKE.derivatives(*vectors(at))[0], strict=True))
    assert max(abs(rates[n]) for n in BIKE.states if n not in PATH) < 1e-7  # as the equilibrium leaves them
    assert rates["heading"] == pytest.approx(at["yaw_rate"])
    moving = [n for n in BIKE.states if n not in PATH]  # the equations do not depend on where it is
    found = np.linalg.eigvals(slopes(at, moving))
    wanted = np.linalg.eigvals(turning.linearised(equilibrium)[0])
    assert len(found) == len(wanted)
    nearest = np.abs(found - wanted[:, None]).min(axis=1)
    # Differences of fourth order with rounding, of matrices with entries of up to 1e6.
    assert (nearest <= 1e-5 * np.maximum(np.abs(wanted), 1.0)).all()


def slopes(at, names):
    """d rates / d states by central differences of fourth order."""
    columns = []
    for name in names:
        h = 1e-4 * max(abs(at[name]), 0.1) if not name.endswith("position") else 1e-5

        def rates(shift, name=name):
            found = BIKE.derivatives(*vectors(at | {name: at[name] + shift}))[0]
            return np.array([found[BIKE.states.index(n)] for n in names])

        columns.append((8 * (rates(h) - rates(-h)) - rates(2 * h) + rates(-2 * h)) / (12 * h))
    return np.array(columns).T


@pytest.mark.study
def test_energy_balance_of_a_simulated_swing(turning):
    """A push on the bar at 30 deg of lean: the energy gained is the integral of the power, both by the other
    formulation.
    """
    from scipy.integrate import solve_ivp  # noqa: PLC0415

    motion, equilibrium = turning.motion, turning.at(np.radians(30.0))
    at = start_of(motion, equilibrium)
    start, inputs = vectors(at | {"steer_rate": 1.0})
    u = equilibrium.u

    def rates(t, x):
        found = motion.at(with_conditions(motion, x[:-1]), u)
        return np.append(BIKE.derivatives(x[:-1], inputs)[0], power(motion, found, u))

    run = solve_ivp(rates, (0.0, 0.3), np.append(start, 0.0), method="DOP853", rtol=1e-9, atol=1e-10)
    ends = [energy(motion, motion.posed(with_conditions(motion, run.y[:-1, k]), u)) for k in (0, -1)]
    assert np.ptp(run.y[BIKE.states.index("steer_angle")]) > 0.02  # rad: it is no rest
    # The integration's tolerance, against the energy of the motion (0.1 MJ).
    assert ends[1] - ends[0] == pytest.approx(run.y[-1, -1], abs=1e-9 * abs(ends[0]))


def with_conditions(motion, state):
    """The states of `LargeMotion` at those of the component."""
    values = dict(zip(BIKE.states, state, strict=True))
    w, q = np.zeros(len(motion.place)), np.zeros(len(motion.place))
    for name, k in motion.place.items():
        w[k] = values[RATES.get(name, f"{name}_rate")]
        if name not in NOWHERE:
            q[k] = values.get(POSITIONS.get(name, f"{name}_position"), 0.0)
    for end, wheel in motion._contacts(motion.tree.motion(q, w), np.zeros(2)).items():
        values[f"{end}_tyre_deflection_position"] = wheel.deflection
        values[f"{end}_tyre_deflection_rate"] = -wheel.rises @ w
        values[f"{end}_longitudinal_slip"] = -(wheel.slides @ w) / wheel.along
    return np.array([values[name] for name in motion.states])


# The FMU ------------------------------------------------------------------------------------------


@pytest.mark.study
@pytest.mark.parametrize("lean", [0.0, 30.0])
def test_the_fmu_has_the_modes_of_trim(fmu, turning, lean):
    """By its exact Jacobian."""
    wanted = np.linalg.eigvals(turning.linearised(turning.at(np.radians(lean)))[0])
    found = np.linalg.eigvals(fmu(lean).linearised().A)
    assert len(found) == len(wanted) + len(PATH)
    nearest = np.abs(found - wanted[:, None]).min(axis=1)
    # Rounding; two slow modes, of speed and of capsize, hang on sums of forces of 1e5 N that cancel.
    assert (nearest <= 1e-7 * np.maximum(np.abs(wanted), 1.0)).all()


@pytest.mark.study
def test_the_fmu_stays_in_steady_turning(fmu):
    run = simulate(fmu(30.0), STEP, 1.0)
    assert run["bike.roll_angle"] == pytest.approx(np.radians(30.0), abs=1e-6)
    assert run["bike.yaw_rate"] == pytest.approx(run["bike.yaw_rate"][0], abs=1e-8)
    # A circle: the direction of the path turns at the yaw rate.
    x, y = (np.diff(run[f"bike.path_{axis}"]) for axis in "xy")
    turned = np.unwrap(np.arctan2(y, x))
    assert np.diff(turned) / STEP == pytest.approx(run["bike.yaw_rate"][0], rel=1e-6)  # of differences of 30 m


@pytest.mark.study
@pytest.mark.parametrize("lean", [0.0, 30.0])
def test_a_small_push_decays_as_the_modes_of_trim(fmu, turning, lean):
    """exp(A t) of the linearised motorcycle, from the same push at the bar: weave and wobble decay in it."""
    from scipy.linalg import expm  # noqa: PLC0415

    equilibrium, push = turning.at(np.radians(lean)), 1e-4  # rad/s: the linear motion, to the square of it
    A = turning.linearised(equilibrium)[0]
    at = start_of(turning.motion, equilibrium)
    # At the same height, pitch and spins the push changes deflection rates and slips, too.
    pushed, still = (with_conditions(turning.motion, next(vectors(at | {"steer_rate": rate}))) for rate in (push, 0.0))
    start = pushed - still
    run = simulate(fmu(lean, steer_rate=push), STEP, 1.0)
    for name in ("steer_angle", "roll_angle"):
        place = turning.motion.states.index(name)
        wanted = np.array([(expm(A * t) @ start)[place] for t in run["time"][::50]])
        found = run[f"bike.{name}"][::50] - equilibrium.x[place]
        assert found == pytest.approx(wanted, abs=1e-3 * np.abs(wanted).max())  # of the push's square, and rounding


@pytest.mark.study
def test_it_is_faster_than_real_time(fmu):
    instance = fmu(30.0, steer_rate=0.5, relative_tolerance=1e-7)
    started = time.process_time()
    simulate(instance, STEP, 2.0)
    ratio = 2.0 / (time.process_time() - started)
    print(f"motorcycle in space: {ratio:.1f} times real time at 1 ms")
    assert ratio > 2.0  # 15 on one quiet core; other machines are slower
