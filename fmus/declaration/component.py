"""A component: a table of variables and one pure function of it. Everything else is rendered from these two.

    mass(v, m) der(x) = equations(v, m)["der(x)"],   y = equations(v, m)["y"]

`v` holds the values by name, `m` the words of mathematics; both may be numbers, arrays or SymPy symbols.
An effect (see `fmus.effects`) adds to named quantities of a component without touching its file.
"""

from collections.abc import Iterable, Mapping
from dataclasses import replace
from typing import Any, ClassVar

import numpy as np

from fmus.elements import Element
from fmus.errors import InputError, unknown
from fmus.mathematics import NUMERIC
from fmus.variables import Variable

SHOWN = "_shown"  # of an exposed state whose sensor has an effect: the state's own name shows what is true


class Scope:
    """The values that equations read, and the named points that they set.

    Setting a local variable, and returning a rate or an output, is where effects add their part.
    """

    def __init__(self, values: Mapping[str, Any], component: "Component", m: Any):
        self.__dict__.update(values, _component=component, _m=m)
        for name, variable in component.table.items():
            if variable.role in ("input", "parameter") and name in component.additions:
                self.__dict__[name] = self._with_additions(name, values[name])

    def __getattr__(self, name: str) -> Any:
        raise AttributeError(str(unknown(f"variable of {self._component.title}", name, self._component.table)))

    def __getitem__(self, name: str) -> Any:
        return self.__dict__[name]

    def __setattr__(self, name: str, value: Any) -> None:
        variable = self._component.table.get(name)
        if variable is None or variable.role != "local":
            raise AttributeError(f"{self._component.title} sets {name!r}, which its table does not declare as local(...)")
        self.__dict__[name] = self._with_additions(name, value)

    def _with_additions(self, target: str, value: Any) -> Any:
        for addition in self._component.additions.get(target, ()):
            self.__dict__[target] = value  # what an effect adds may depend on what is there so far
            value = value + addition(self, self._m)
        return value


class Component:
    """Base of everything that becomes an FMU: riders, motorcycles, dampers, rigs, systems.

    A subclass declares variables as class attributes and defines `equations`, and `mass` where der(x) is
    not given explicitly. An instance holds parameter values, a name and the source of the values.
    """

    declared: ClassVar[dict[str, Variable]] = {}
    elements: ClassVar[dict[str, Element]] = {}

    def __init_subclass__(cls, **options) -> None:
        super().__init_subclass__(**options)
        rows = {name: row for base in cls.__bases__ for name, row in getattr(base, "declared", {}).items()}
        for name, row in list(vars(cls).items()):
            if isinstance(row, Variable):
                rows[name] = row.named(name)
                delattr(cls, name)
        cls.declared = rows

    def __init__(self, name: str = "", source: str = "", effects: Iterable[Any] = (), **values: float):
        self.name = name or type(self).__name__
        self.source = source
        self.assumed: dict[str, str] = {}
        self.standard_error: dict[str, float] = {}
        self.correlation: dict[str, dict[str, float]] = {}
        self.effects = tuple(effects)
        self.table: dict[str, Variable] = dict(self.declared)
        self.additions: dict[str, list] = {}
        self.delays: dict[str, tuple[str, str]] = {}  # input: (what it is, the parameter by which it lags)
        for effect in self.effects:
            effect.join(self)
        self._set_values(values)

    def _set_values(self, values: Mapping[str, float]) -> None:
        parameters = self.rows("parameter")
        for key in values:
            if key not in parameters:
                raise unknown(f"parameter of {self.title}", key, parameters)
        self.values = {key: in_bounds(values.get(key, row.start), row, self.name) for key, row in parameters.items()}

    # What a subclass defines -------------------------------------------------------------------------

    def equations(self, v: Scope, m: Any) -> dict[str, Any]:
        """Outputs, calculated parameters and `der(state)` (times the mass matrix, if any) by name."""
        raise NotImplementedError(f"{type(self).__name__} defines no equations")

    def mass(self, v: Scope, m: Any) -> dict[tuple[str, str], Any]:
        """Entries of the mass matrix by (row, column) state; a state without an entry has 1 on its diagonal."""
        return {}

    # The table ---------------------------------------------------------------------------------------

    @property
    def title(self) -> str:
        return type(self).__name__

    def rows(self, *roles: str) -> dict[str, Variable]:
        """The rows of the table with one of the roles, in the order of declaration."""
        return {name: row for name, row in self.table.items() if row.role in roles}

    @property
    def states(self) -> tuple[str, ...]:
        return tuple(self.rows("state"))

    @property
    def inputs(self) -> tuple[str, ...]:
        return tuple(self.rows("input"))

    @property
    def outputs(self) -> tuple[str, ...]:
        """The outputs, the exposed states among them, in the order of the table."""
        return tuple(n for n, row in self.table.items() if row.role == "output" or row.exposed)

    def shown(self, name: str) -> str:
        """The output that shows what the sensor of an output does: itself, unless an effect acts at the sensor of a state."""
        return name + SHOWN if name + SHOWN in self.table else name

    @property
    def structure(self) -> tuple:
        """What the equations depend on besides values: two components with the same structure share code."""
        return (type(self), *(effect.structure for effect in self.effects))

    def with_values(self, **values: float) -> "Component":
        """The same component with some parameters changed."""
        return self._remade(self.effects, {**self.values, **values})

    def with_effects(self, *effects: Any) -> "Component":
        """The same component with effects added; their parameters join its table."""
        return self._remade(self.effects + effects, self.values)

    def _remade(self, effects: tuple, values: Mapping[str, float]) -> "Component":
        twin = type(self)(self.name, self.source, effects, **values)
        twin.assumed = dict(self.assumed)
        twin.standard_error, twin.correlation = dict(self.standard_error), dict(self.correlation)
        return twin

    # Evaluation --------------------------------------------------------------------------------------

    def start_values(self) -> dict[str, float]:
        """Parameters at their values, states and inputs at their starts, time zero."""
        return {"time": 0.0, **self.values, **{n: row.start for n, row in self.rows("state", "input").items()}}

    def run(self, values: Mapping[str, Any], m: Any) -> dict[str, Any]:
        """Every local, output, calculated parameter and `der(state)` (before the mass matrix) for given values."""
        scope = Scope(values, self, m)
        results = dict(self.equations(scope, m))
        for target in self._own_rates_of_effects():  # after the outputs, which they may read
            results.setdefault(target, 0.0)
        for target, value in results.items():
            results[target] = scope._with_additions(target, value)
        results.update({n: scope[n] for n in self.rows("local") if n in scope.__dict__})
        exposed = [n for n, row in self.table.items() if row.exposed]
        results.update({n: scope[n] for n in exposed})
        results.update({n + SHOWN: scope._with_additions(n, scope[n]) for n in exposed if n in self.additions})
        return results

    def complete(self, results: dict[str, Any]) -> dict[str, Any]:
        """The results of `run`. Raises InputError where they miss a rate or an output, or hold what the table lacks."""
        expected = {f"der({n})" for n in self.states} | set(self.rows("output", "calculated"))
        returned = set(results) - set(self.rows("local")) - set(self.states)
        if returned != expected:
            missing, extra = sorted(expected - returned), sorted(returned - expected)
            raise InputError(f"equations of {self.title}: missing {missing or 'nothing'}, not in its table {extra or 'nothing'}")
        for target in self.additions:
            if target not in results and target not in self.rows("input", "parameter") and not target.startswith("mass("):
                raise InputError(f"an effect adds to {target!r}, which {self.title} does not have")
        return results

    def mass_entries(self, values: Mapping[str, Any], m: Any) -> dict[tuple[str, str], Any]:
        """The entries of the mass matrix with what effects add to them."""
        scope = Scope(values, self, m)
        entries = dict(self.mass(scope, m))
        for target, additions in self.additions.items():
            if target.startswith("mass("):
                row, column = (name.strip() for name in target[5:-1].split(","))
                base = entries.get((row, column), 1.0 if row == column else 0.0)
                entries[row, column] = base + sum(addition(scope, m) for addition in additions)
        return entries

    def _own_rates_of_effects(self) -> list[str]:
        return [f"der({name})" for name in self.states if name not in self.declared]

    def derivatives(self, state: np.ndarray, inputs: np.ndarray, time: float = 0.0) -> tuple[np.ndarray, np.ndarray]:
        """State derivatives (nx,) and outputs (ny,) for states (nx,) and inputs (nu,) in the table's order, SI."""
        values = {**self.values, "time": time}
        values.update(zip(self.states, state, strict=True))
        values.update(zip(self.inputs, inputs, strict=True))
        results = self.run(values, NUMERIC)
        rates = np.array([results[f"der({n})"] for n in self.states], float)
        entries = self.mass_entries(values, NUMERIC)
        if entries:
            matrix = np.eye(len(self.states))
            for (row, column), entry in entries.items():
                matrix[self.states.index(row), self.states.index(column)] = entry
            rates = np.linalg.solve(matrix, rates)
        return rates, np.array([results[n] for n in self.outputs], float)


def in_bounds(value: Any, row: Variable, owner: str) -> float:
    """The value as a float. Raises InputError when it is no finite number within the row's bounds."""
    try:
        number = float(value)
    except (TypeError, ValueError):
        raise InputError(f"{owner}: {row.name} = {value!r} is not a number [{row.unit}]") from None
    if not (np.isfinite(number) and row.min <= number <= row.max):
        raise InputError(f"{owner}: {row.name} = {number:g} {row.unit} is outside its bounds [{row.min:g}, {row.max:g}]")
    return number


def prefixed(rows: Mapping[str, Variable], prefix: str) -> dict[str, Variable]:
    """The rows under `prefix.name`, as a system shows the variables of its parts."""
    return {f"{prefix}.{name}": replace(row, name=f"{prefix}.{name}") for name, row in rows.items()}
