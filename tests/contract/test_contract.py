"""What every component keeps to, with its default values and with all values that ship."""

from collections import defaultdict

import numpy as np
import pytest
import sympy
from hypothesis import given, settings
from hypothesis import strategies as st

from fmus import linearise
from fmus.declaration.units import unit
from fmus.equations.numpy_program import Program, recorded_equations
from fmus.equations.sympy_form import symbolic
from fmus.expressions.expression_graph import common_subexpressions
from fmus.expressions.functions import NUMERIC
from fmus.interfaces.handlebar import MOTION, TORQUES, HandlebarDevice
from motofmi.workflows import components
from rider_fmu import riders
from vehicle_fmu import motorcycles, ridden
from vehicle_fmu.large_motion.in_space import in_large_motion

CLASSES = [pytest.param(kind, id=name) for name, kind in components.COMPONENTS.items()]
SHIPPED = [components.component(spec) for spec in components.every_name()]
# In large motion a motorcycle has the values of its value file, and rests nowhere: its tyres carry it.
IN_SPACE = in_large_motion(motorcycles.load("tum_2020"))
SHIPPED.append(IN_SPACE)
# Every set of values that ships, and the defaults of a class for which none does.
COMPONENTS = SHIPPED + [kind() for kind in components.COMPONENTS.values() if kind not in {type(c) for c in SHIPPED}]
# A system is a component too.
COMPONENTS.append(ridden(motorcycles.load("sharp_1971"), riders.load("mean_2011")))


def case(component, name):
    """A case of a test; the equations of the full rider take 10 s to derive, those in large motion 20 s."""
    marks = pytest.mark.study if any(name in type(component).__name__ for name in ("FullRider", "InSpace")) else ()
    return pytest.param(component, id=name, marks=marks)


INSTANCES = [case(c, c.name) for c in COMPONENTS]
ONE_OF_EACH = [case(c, c.title) for c in {type(c): c for c in COMPONENTS}.values()]
DEVICES = [case(c, c.name) for c in COMPONENTS if isinstance(c, HandlebarDevice)]
seeds = st.integers(0, 2**32 - 1)


def at_start(component):
    values = component.start_values()
    return np.array([values[n] for n in component.states]), np.array([values[n] for n in component.inputs])


def draw(component, generator, *roles):
    """Values of the roles near those of the component: within 1 %, or 0.02 where one is zero, and within the bounds."""
    drawn = {}
    for name, row in component.rows(*roles).items():
        value = component.start_values()[name]
        spread = 0.01 * abs(value) if value else 0.02
        drawn[name] = generator.uniform(max(value - spread, row.min), min(value + spread, row.max))
    return drawn


# The table ----------------------------------------------------------------------------------------


@pytest.mark.parametrize("kind", CLASSES)
def test_every_variable_has_a_unit_a_meaning_and_a_start_within_its_bounds(kind):
    for name, row in kind().table.items():
        assert unit(row.unit).factor == 1.0, name
        assert row.description[:1].isupper() and not row.description.endswith("."), name
        assert row.min <= row.start <= row.max, name
    assert (kind.__doc__ or "").strip().endswith("."), "a sentence in `motofmi list`"


def test_one_name_has_one_unit_in_the_whole_project():
    units = defaultdict(set)
    for kind in components.COMPONENTS.values():
        for name, row in kind().table.items():
            units[name].add(row.unit)
    assert {name: u for name, u in units.items() if len(u) > 1} == {}


@pytest.mark.parametrize("kind", CLASSES)
def test_symbols_differ_within_a_component(kind):
    symbols = [row.latex for row in kind().table.values()]
    assert len(set(symbols)) == len(symbols), sorted(s for s in symbols if symbols.count(s) > 1)


@pytest.mark.parametrize("kind", CLASSES)
def test_the_handlebar_port_is_whole_and_as_declared(kind):
    rows = {n: r for n, r in kind().table.items() if r.port == "handlebar"}
    declared = {**MOTION, **TORQUES}
    assert {n: (r.unit, r.description, r.symbol) for n, r in rows.items()} == {n: declared[n] for n in rows}
    assert all(r.flow == (n in TORQUES) for n, r in rows.items())
    if (
        rows.keys() & TORQUES.keys()
    ):  # without torques it shows a motion that it imposes on nobody: a rider with its rig
        received, returned = (MOTION, TORQUES) if issubclass(kind, HandlebarDevice) else (TORQUES, MOTION)
        assert set(received) <= set(kind().inputs)
        assert set(returned) <= set(kind().outputs)


# The equations ------------------------------------------------------------------------------------


@pytest.mark.slow
@pytest.mark.parametrize("component", ONE_OF_EACH)
@settings(max_examples=3)
@given(seed=seeds)
def test_equations_give_the_same_on_numbers_arrays_and_symbols(component, seed):
    generator = np.random.default_rng(seed)
    points = [
        {"time": generator.uniform(0, 10), **draw(component, generator, "parameter", "input", "state")}
        for _ in range(3)
    ]
    stacked = {n: np.array([p[n] for p in points]) for n in points[0]}
    one_by_one = [{**component.run(p, NUMERIC), **component.mass_entries(p, NUMERIC)} for p in points]
    on_arrays = {**component.run(stacked, NUMERIC), **component.mass_entries(stacked, NUMERIC)}
    for key, value in on_arrays.items():
        # Numpy's functions of arrays may differ from those of numbers in the last digits.
        assert np.broadcast_to(value, 3) == pytest.approx([r[key] for r in one_by_one], rel=1e-12, abs=1e-12), key
    form = symbolic(component)
    keys = [*(f"der({n})" for n in component.states), *component.outputs, *component.rows("calculated")]
    function = sympy.lambdify(
        list(form.symbols.values()), [*form.rates, *form.outputs, *form.calculated], "numpy", cse=common_subexpressions
    )
    for point, results in zip(points, one_by_one, strict=True):
        numbers = function(*(point[n] for n in form.symbols))
        expected = [float(results[k]) for k in keys]
        scale = 1e-12 * max(map(abs, expected), default=1.0)
        # SymPy orders sums differently: rounding, of the largest of the results where they cancel.
        assert numbers == pytest.approx(expected, rel=1e-9, abs=max(scale, 1e-12))


@pytest.mark.slow
@pytest.mark.parametrize("component", INSTANCES)
@settings(max_examples=2)
@given(seed=seeds)
def test_the_jacobian_is_the_slope_of_the_derivatives(component, seed):
    generator = np.random.default_rng(seed)
    point = draw(component, generator, "state", "input")
    space = linearise(component, **point)
    wanted = np.block([[space.A, space.B], [space.C, space.D]])
    found = slopes(component, np.array([point[n] for n in component.states + component.inputs]))
    # Central differences of fourth order with steps of 1e-3, or of 1e-3 of what is nominal where that is less:
    # truncation and rounding are below 1e-8 of the largest slope in a row.
    scale = np.maximum(np.abs(wanted).max(axis=1, keepdims=True, initial=0), 1.0)
    assert (np.abs(found - wanted) <= 1e-6 * scale).all()


def slopes(component, point):
    """d (derivatives, outputs) / d (states, inputs) by central differences of fourth order."""
    nx = len(component.states)

    def at(values):
        return np.concatenate(component.derivatives(values[:nx], values[nx:]))

    columns = []
    for i, (name, value) in enumerate(zip(component.states + component.inputs, point, strict=True)):
        step = np.zeros(len(point))
        step[i] = 1e-3 * max(abs(value), min(component.table[name].nominal, 1.0))
        columns.append(
            (8 * (at(point + step) - at(point - step)) - at(point + 2 * step) + at(point - 2 * step)) / (12 * step[i])
        )
    return np.array(columns).T


@pytest.mark.parametrize("component", [case(c, c.name) for c in COMPONENTS if c is not IN_SPACE])
def test_rest_is_an_equilibrium(component):
    rates, outputs = component.derivatives(*at_start(component))
    assert not rates.any() and not outputs.any()


@pytest.mark.slow
@pytest.mark.parametrize("component", INSTANCES)
def test_it_becomes_a_control_statespace_with_its_names(component):
    system = linearise(component).to_control()
    for labels, wanted in (
        (system.input_labels, component.inputs),
        (system.output_labels, component.outputs),
        (system.state_labels, component.states),
    ):
        assert labels == [name.replace(".", "_") for name in wanted]


@pytest.mark.parametrize("component", [pytest.param(c, id=c.name) for c in SHIPPED])
def test_values_have_a_source(component):
    assert len(component.source) > 20
    assert set(component.assumed) <= set(component.rows("parameter"))


# Passivity ----------------------------------------------------------------------------------------


@pytest.mark.slow
@pytest.mark.parametrize("device", DEVICES)
def test_a_device_gives_no_energy_that_it_was_not_given(device):
    """From rest, in whatever motion of bar and frame: the integral of T_h (s + w) + T_f w is never positive."""
    generator = np.random.default_rng(1)
    lines, motions = 3, 40
    amplitude = generator.uniform(-0.05, 0.05, (2, lines, motions))  # rad, rad/s
    amplitude[0] *= min(
        1.0, 0.05 * device.table["steer_angle"].max
    )  # where the angle is bounded, well within the bounds
    omega = 2 * np.pi * generator.uniform(0.3, 12, (2, lines, motions))

    def motion(time):
        angle = (amplitude[0] * (1 - np.cos(omega[0] * time))).sum(axis=0)
        rate = (amplitude[0] * omega[0] * np.sin(omega[0] * time)).sum(axis=0)
        frame = (amplitude[1] * np.sin(omega[1] * time)).sum(axis=0)
        return {"steer_angle": angle, "steer_rate": rate, "frame_rate": frame, "time": time}

    equations = recorded_equations(device)
    program = Program([*equations.rates, *(equations.outputs[device.outputs.index(n)] for n in TORQUES)])

    def rates(time, state):
        given = motion(time)
        known = {**device.values, **given, **dict(zip(device.states, state, strict=False))}
        *slopes, handlebar_torque, frame_torque = program(known)
        power = handlebar_torque * (given["steer_rate"] + given["frame_rate"]) + frame_torque * given["frame_rate"]
        return np.array([*slopes, power, np.abs(power)])

    step, state = 2e-3, np.zeros((len(device.states) + 2, motions))
    for k in range(250):
        state = runge_kutta_step(rates, k * step, state, step)
        energy, exchanged = state[-2:]
        # Runge-Kutta's own error in the energy is below 1e-6 of what is exchanged with poles up to 80 1/s.
        assert (energy <= 1e-6 * exchanged).all()


def runge_kutta_step(rates, time, state, step):
    first = rates(time, state)
    second = rates(time + step / 2, state + step / 2 * first)
    third = rates(time + step / 2, state + step / 2 * second)
    fourth = rates(time + step, state + step * third)
    return state + step / 6 * (first + 2 * second + 2 * third + fourth)
