"""FMUs through fmpy, as an importer uses them: against exact solutions, and both back ends against each other."""

from dataclasses import replace

import fmpy
import numpy as np
import pytest
from fmpy.fmi2 import FMU2Model, FMU2Slave
from fmpy.validation import validate_fmu
from scipy.integrate import solve_ivp
from scipy.linalg import expm

from fmus import Component, System, linearise, output, parameter, state
from fmus import input as told
from fmus.build import build
from fmus.compilers import host_compiler
from fmus.errors import InputError, MissingToolError
from fmus.symbolic import symbolic
from rider_fmu import riders
from vehicle_fmu import dampers, motorcycles


class Oscillator(Component):
    """Duffing oscillator with dry friction, driven by a force; nonlinear, non-smooth and with a time of its own."""

    mass_of_body = parameter("kg", "Mass", min=0.1, max=10, start=1.3)
    hardening = parameter("N/m3", "Cubic stiffness", min=0, max=1e6, start=40)
    friction = parameter("N", "Friction", min=0, max=100, start=0.2)
    force = told("N", "Force", min=-1e3, max=1e3)
    position = state("m", "Position", start=0.3, exposed=True)
    velocity = state("m/s", "Velocity", exposed=True)
    power = output("W", "Power of the force")

    def mass(self, v, m):
        return {("velocity", "velocity"): v.mass_of_body * (1 + v.position**2)}

    def equations(self, v, m):
        push = v.force + m.where(m.sin(v.time) > 0.5, 1.0, 0.0)
        return {
            "der(position)": v.velocity,
            "der(velocity)": push - 9 * v.position - v.hardening * v.position**3 - v.friction * m.tanh(50 * v.velocity) - m.absolute(v.velocity) * v.velocity,
            "power": v.force * v.velocity,
        }


def together():
    parts = {"vehicle": motorcycles.load("reference_2011"), "device": riders.load("mean_2011")}
    return System("motorcycle_with_rider", parts, bindings={"vehicle.added_steer_inertia": "device.port_inertia"})


COMPONENTS = {
    "rider": lambda: riders.load("mean_2011", cross_inertia=0.05),
    "motorcycle": lambda: motorcycles.load("sharp_1971"),
    "bicycle": lambda: motorcycles.load("benchmark_bicycle"),
    "damper": lambda: dampers.load("high_2011"),
    "progressive": lambda: dampers.load("progressive"),
    "inerter": lambda: dampers.load("inerter"),
    "system": together,
    "oscillator": lambda: Oscillator("oscillator"),
}


@pytest.fixture(scope="session")
def cache(tmp_path_factory):
    return tmp_path_factory.mktemp("cache")


@pytest.fixture(autouse=True)
def private_cache(cache, monkeypatch):
    monkeypatch.setenv("MOTOFMI_CACHE", str(cache))


class Opened:
    """An FMU of the host opened with fmpy: one instance, its variables by name."""

    def __init__(self, path, exchange=False):
        self.description = fmpy.read_model_description(path)
        kind = self.description.modelExchange if exchange else self.description.coSimulation
        self.reference = {v.name: v.valueReference for v in self.description.modelVariables}
        self.fmu = (FMU2Model if exchange else FMU2Slave)(
            guid=self.description.guid, unzipDirectory=fmpy.extract(path), modelIdentifier=kind.modelIdentifier, instanceName="test")  # fmt: skip
        self.fmu.instantiate(loggingOn=True)

    def start(self, **values):
        self.fmu.setupExperiment(startTime=0.0)
        self.set(**values)
        self.fmu.enterInitializationMode()
        self.fmu.exitInitializationMode()
        return self

    def set(self, **values):
        self.fmu.setReal([self.reference[n] for n in values], list(values.values()))

    def get(self, *names):
        return np.array(self.fmu.getReal([self.reference[n] for n in names]))

    def run(self, times, drive, names):
        """Rows of `names` at the times, each read after the inputs of that time have been set."""
        rows = []
        for now, following in zip(times, [*times[1:], None], strict=True):
            self.set(**drive(now))
            rows.append(self.get(*names))
            if following is not None:
                self.fmu.doStep(now, following - now)
        return np.array(rows)

    def close(self):
        self.fmu.terminate()
        self.fmu.freeInstance()


@pytest.fixture
def opened(tmp_path):
    made = []

    def open_fmu(component, exchange=False, **options):
        made.append(Opened(build(component, tmp_path, **options).path, exchange))
        return made[-1]

    yield open_fmu
    for each in made:
        each.close()


def drive_of(component):
    """Smooth inputs of different frequency around their starts; a speed changes in steps of a fifth of a second."""
    inputs = component.rows("input")

    def drive(t):
        values = {n: row.start + (0.02 if row.unit.startswith("rad") else 2.0) * np.sin((3 + i) * t) for i, (n, row) in enumerate(inputs.items())}
        return {n: (20.0 + 5 * np.floor(5 * t) if n.endswith("speed") else x) for n, x in values.items()}

    return drive


def held_solution(component, times, drive, start):
    """States at the times with inputs held in each step: the matrix exponential, or scipy's tightest integration."""
    x, rows = np.array([start.get(n, component.table[n].start) for n in component.states]), []
    for now, following in zip(times, [*times[1:], None], strict=True):
        rows.append(x)
        if following is None:
            return np.array(rows)
        u = drive(now)
        h, nx = following - now, len(x)
        if symbolic(component).scheduling is None:
            solved = solve_ivp(lambda t, y, u=u: component.derivatives(y, np.array(list(u.values())), t)[0], (now, following), x,
                               method="Radau", rtol=1e-12, atol=1e-14)  # fmt: skip
            x = solved.y[:, -1]
        else:
            model = linearise(component, **{n: u[n] for n in symbolic(component).scheduling})
            free = np.array([0.0 if n in symbolic(component).scheduling else u[n] for n in component.inputs])
            wide = np.zeros((nx + 1, nx + 1))
            wide[:nx, :nx], wide[:nx, nx] = model.A, model.B @ free
            x = (expm(h * wide) @ np.array([*x, 1.0]))[:nx]


@pytest.mark.parametrize("name", COMPONENTS)
@pytest.mark.parametrize("backend", ["compiled", "python"])
def test_steps_are_the_exact_solution_with_held_inputs(name, backend, opened):
    component = COMPONENTS[name]()
    start = {n: 0.1 * row.nominal for n, row in component.rows("state").items()}
    fmu = opened(component, backend=backend).start(**start)
    times = np.cumsum([0.0] + [0.01, 0.003, 0.02, 0.04] * 12)
    drive = drive_of(component)
    names = component.states + component.outputs
    found = fmu.run(times, drive, names)
    states = held_solution(component, times, drive, start)
    exact = np.array([[*x, *component.derivatives(x, np.array(list(drive(t).values())), t)[1]] for t, x in zip(times, states, strict=True)])
    scale = np.abs(exact).max(axis=0) + 1e-12
    # Exact steps differ by roundings, which a fast mode amplifies; the nonlinear ones by their tolerance 1e-10 per step.
    assert np.abs(found - exact).max(axis=0) / scale == pytest.approx(0, abs=1e-9)


@pytest.mark.parametrize("name", COMPONENTS)
def test_both_back_ends_give_the_same_trajectory(name, opened):
    component = COMPONENTS[name]()
    names = component.states + component.outputs
    times, drive = np.linspace(0, 1, 201), drive_of(component)
    one, other = (opened(component, backend=b).start().run(times, drive, names) for b in ("compiled", "python"))
    assert one == pytest.approx(other, rel=1e-9, abs=1e-9 * np.abs(one).max())
    assert np.abs(one).max() > 0


@pytest.mark.parametrize("name", COMPONENTS)
def test_model_exchange_gives_the_derivatives_of_the_equations(name, opened):
    component = COMPONENTS[name]()
    fmu = opened(component, exchange=True).start()
    fmu.fmu.newDiscreteStates()
    fmu.fmu.enterContinuousTimeMode()
    random = np.random.default_rng(1)
    for _ in range(10):
        x, u = random.normal(size=len(component.states)), random.uniform(1, 30, len(component.inputs))
        time = random.uniform(0, 9)
        fmu.fmu.setTime(time)
        fmu.set(**dict(zip(component.inputs, u, strict=True)))
        rates, outputs = component.derivatives(x, u, time)
        if len(x):
            array = np.ascontiguousarray(x)
            fmu.fmu.fmi2SetContinuousStates(fmu.fmu.component, array.ctypes.data_as(fmpy.fmi2.POINTER(fmpy.fmi2.c_double)), len(x))
        found = fmu.get(*(f"der({n})" for n in component.states), *component.outputs)
        # Sums in another order: a few roundings, weighed by the largest term.
        expected = np.concatenate([rates, outputs])
        assert found == pytest.approx(expected, rel=1e-9, abs=1e-11 * max(1, np.abs(expected).max()))


def test_model_exchange_and_cosimulation_agree_in_fmpy(tmp_path):
    path = build(motorcycles.load("sharp_1971"), tmp_path).path
    start = {"roll_angle": 0.05, "speed": 25.0}
    ends = [fmpy.simulate_fmu(path, fmi_type=kind, start_values=start, stop_time=0.5, relative_tolerance=1e-10, output=["roll_angle"])["roll_angle"][-1]
            for kind in ("ModelExchange", "CoSimulation")]  # fmt: skip
    assert ends[0] == pytest.approx(ends[1], rel=1e-6)  # the importer's integrator is held to 1e-10 per step


@pytest.mark.parametrize("backend", ["compiled", "python"])
def test_builds_are_valid_and_identical_to_the_byte(backend, tmp_path, monkeypatch):
    component = riders.load("mean_2011")
    first = build(component, tmp_path / "one", backend=backend)
    monkeypatch.setenv("MOTOFMI_CACHE", str(tmp_path / "empty"))
    second = build(component, tmp_path / "two", backend=backend)
    assert validate_fmu(first.path) == []
    assert first.path.read_bytes() == second.path.read_bytes()
    assert second == replace(first, path=second.path)
    assert first.path.name == {"compiled": "rider_mean_2011.fmu", "python": "rider_mean_2011_python.fmu"}[backend]


def test_another_value_gives_another_identifier(tmp_path):
    one, other = (build(riders.load("mean_2011", arm_damping=d), tmp_path) for d in (19.0, 20.0))
    assert one.sha256 != other.sha256


def test_wrong_choices_are_named(tmp_path):
    rider = riders.load("mean_2011")
    for options, message in (({"fmi": 4}, "FMI version"), ({"backend": "java"}, "back end"), ({"platforms": "amiga"}, "platform"),
                             ({"fmi": 3, "backend": "python"}, "FMI 2 only")):  # fmt: skip
        with pytest.raises(InputError, match=message):
            build(rider, tmp_path, **options)


def test_a_folder_that_cannot_be_written_is_named(tmp_path):
    (tmp_path / "file").write_text("")
    with pytest.raises(InputError, match="cannot write to folder"):
        build(riders.load("mean_2011"), tmp_path / "file")


def test_without_a_compiler_the_error_says_how_to_get_one(tmp_path, monkeypatch):
    monkeypatch.delenv("CC", raising=False)
    monkeypatch.setenv("PATH", str(tmp_path))
    monkeypatch.setattr("fmus.compilers.find_spec", lambda name: None)
    assert host_compiler() is None
    with pytest.raises(MissingToolError, match=r"pip install motofmi\[platforms\]"):
        build(riders.load("mean_2011"), tmp_path / "out")
    assert list((tmp_path / "out").iterdir()) == []


def test_a_wrong_CC_is_named(tmp_path, monkeypatch):
    monkeypatch.setenv("CC", "no_such_compiler")
    with pytest.raises(InputError, match="no_such_compiler"):
        build(riders.load("mean_2011"), tmp_path)
