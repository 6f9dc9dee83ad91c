"""An importer as the tests use it: an FMU opened with fmpy, the components that are put through it, exact solutions."""

import fmpy
import numpy as np
from fmpy.fmi2 import FMU2Model, FMU2Slave, defaultCallbacks, fmi2CallbackFunctions, fmi2CallbackLoggerTYPE
from fmpy.fmi3 import FMU3Model, FMU3Slave
from scipy.integrate import solve_ivp
from scipy.linalg import expm

from fmus import Component, System, linearise, output, parameter, state
from fmus import input as port_input
from fmus.equations.sympy_form import symbolic
from rider_fmu import riders
from vehicle_fmu import dampers, motorcycles


class Oscillator(Component):
    """Duffing oscillator with dry friction, driven by a force; nonlinear, non-smooth and with a time of its own."""

    mass_of_body = parameter("kg", "Mass", min=0.1, max=10, start=1.3)
    hardening = parameter("N/m3", "Cubic stiffness", min=0, max=1e6, start=40)
    friction = parameter("N", "Friction", min=0, max=100, start=0.2)
    force = port_input("N", "Force", min=-1e3, max=1e3)
    position = state("m", "Position", start=0.3, exposed=True)
    velocity = state("m/s", "Velocity", exposed=True)
    power = output("W", "Power of the force")

    def mass(self, v, m):
        return {("velocity", "velocity"): v.mass_of_body * (1 + v.position**2)}

    def equations(self, v, m):
        push = v.force + m.where(m.sin(v.time) > 0.5, 1.0, 0.0)
        return {
            "der(position)": v.velocity,
            "der(velocity)": push
            - 9 * v.position
            - v.hardening * v.position**3
            - v.friction * m.tanh(50 * v.velocity)
            - m.absolute(v.velocity) * v.velocity,
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


class Opened:
    """An FMU of the host opened with fmpy: one instance, its variables by name, its messages in `log`."""

    def __init__(self, path, exchange=False, logging=True):
        self.description = fmpy.read_model_description(path)
        kind = self.description.modelExchange if exchange else self.description.coSimulation
        self.reference = {v.name: v.valueReference for v in self.description.modelVariables}
        self.log = []
        self._logger = fmi2CallbackLoggerTYPE(
            lambda env, name, status, category, message: self.log.append((category.decode(), message.decode()))
        )
        self.callbacks = fmi2CallbackFunctions(
            self._logger, defaultCallbacks.allocateMemory, defaultCallbacks.freeMemory
        )
        self.fmu = (FMU2Model if exchange else FMU2Slave)(
            guid=self.description.guid, unzipDirectory=fmpy.extract(path), modelIdentifier=kind.modelIdentifier, instanceName="test")  # fmt: skip
        self.fmu.instantiate(callbacks=self.callbacks, loggingOn=logging)

    def start(self, **values):
        """Initialised, with start values; in model exchange in continuous-time mode."""
        self.fmu.setupExperiment(startTime=0.0)
        self.set(**values)
        self.fmu.enterInitializationMode()
        self.fmu.exitInitializationMode()
        if isinstance(self.fmu, FMU2Model):
            self.fmu.newDiscreteStates()
            self.fmu.enterContinuousTimeMode()
        return self

    def references(self, names):
        return [self.reference[n] for n in names]

    def set(self, **values):
        self.fmu.setReal(self.references(values), list(values.values()))

    def set_slopes(self, order, **values):
        """Derivatives of inputs with respect to time."""
        self.fmu.setRealInputDerivatives(self.references(values), [order] * len(values), list(values.values()))

    def get(self, *names):
        return np.array(self.fmu.getReal(self.references(names)))

    def set_states(self, states):
        array = np.ascontiguousarray(states, float)
        self.fmu.setContinuousStates(array.ctypes.data_as(fmpy.fmi2.POINTER(fmpy.fmi2.c_double)), len(array))

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
        self.fmu.freeInstance()


class Opened3(Opened):
    """The same for FMI 3.0. `moves(time)` gives the inputs in intermediate updates, `returns_at` asks for an early return."""

    def __init__(self, path, exchange=False, moves=None, returns_at=None):
        self.description = fmpy.read_model_description(path)
        kind = self.description.modelExchange if exchange else self.description.coSimulation
        self.reference = {v.name: v.valueReference for v in self.description.modelVariables}
        self.log, self.updates, self.moves, self.returns_at = [], [], moves, returns_at
        self.fmu = (FMU3Model if exchange else FMU3Slave)(
            guid=self.description.guid, unzipDirectory=fmpy.extract(path), modelIdentifier=kind.modelIdentifier, instanceName="test")  # fmt: skip
        options = {
            "loggingOn": True,
            "logMessage": lambda env, status, category, message: self.log.append((category.decode(), message.decode())),
        }
        if moves is not None:
            inputs = [v.valueReference for v in self.description.modelVariables if v.causality == "input"]
            options |= {
                "intermediateUpdate": self._update,
                "requiredIntermediateVariables": inputs,
                "earlyReturnAllowed": returns_at is not None,
            }
        self.fmu.instantiate(**options)

    def _update(self, env, time, set_requested, get_allowed, finished, can_return, early_requested, early_time):
        self.updates.append((time, bool(set_requested), bool(get_allowed), bool(finished), bool(can_return)))
        if set_requested:
            self.set(**self.moves(time))
        if can_return and self.returns_at is not None:
            early_requested[0], early_time[0] = True, max(time, self.returns_at)

    def start(self, **values):
        self.set(**values)
        self.fmu.enterInitializationMode(startTime=0.0)
        self.fmu.exitInitializationMode()
        if isinstance(self.fmu, FMU3Model):
            self.fmu.updateDiscreteStates()
            self.fmu.enterContinuousTimeMode()
        return self

    def set(self, **values):
        self.fmu.setFloat64(self.references(values), list(values.values()))

    def get(self, *names):
        return np.array(self.fmu.getFloat64(self.references(names)))


def drive_of(component):
    """Smooth inputs of different frequency around their starts; a speed changes in steps of a fifth of a second."""
    inputs = component.rows("input")

    def drive(t):
        values = {
            n: row.start + (0.02 if row.unit.startswith("rad") else 2.0) * np.sin((3 + i) * t)
            for i, (n, row) in enumerate(inputs.items())
        }
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
