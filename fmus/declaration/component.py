"""A component: a table of variables and one pure function of it. Everything else is derived from these two.

    mass(v, m) der(x) = equations(v, m)["der(x)"],   y = equations(v, m)["y"]

`v` holds the values by name and `m` the mathematical functions (`m.sin`, `m.where`, see `fmus.expressions.functions`).
The same function runs on numbers, arrays, SymPy symbols and recorded operations. An effect (see `fmus.effects`) adds
terms to named quantities of a component from a file of its own.
"""

from collections.abc import Iterable, Mapping
from dataclasses import replace
from textwrap import shorten
from typing import Any, ClassVar

import numpy as np

from fmus.declaration.elements import Element
from fmus.declaration.variables import Variable
from fmus.expressions.functions import NUMERIC
from fmus.support.errors import InputError, NotApplicableError, unknown
from fmus.support.notebook import html

SHOWN = "_shown"  # suffix of the sensor reading of an exposed state; the name without it is the true value
RECORDED = "_recorded"  # suffix of an input's value before effects add to it; the name without it is what acts


class Scope:
    """The argument `v` of equations: values to read by name, and local variables to set.

    Effects add their terms when an input or a parameter is read, when a local variable is set, and to the rates and
    outputs that the equations return. An unknown name is an AttributeError with the valid names.
    """

    def __init__(self, values: Mapping[str, Any], component: "Component", m: Any):
        self.__dict__.update(values, _component=component, _m=m)
        for name, variable in component.table.items():
            if variable.role in ("input", "parameter") and name in component.additions:
                self.__dict__[name + RECORDED] = values[name]
                self.__dict__[name] = self._with_additions(name, values[name])

    def __getattr__(self, name: str) -> Any:
        raise AttributeError(str(unknown(f"variable of {self._component.title}", name, self._component.table)))

    def __getitem__(self, name: str) -> Any:
        return self.__dict__[name]

    def __setattr__(self, name: str, value: Any) -> None:
        variable = self._component.table.get(name)
        if variable is None or variable.role != "local":
            returned = "; the equations return the values of outputs" if variable and variable.role == "output" else ""
            raise AttributeError(
                f"{self._component.title} sets {name!r}, which its table does not declare as local(...){returned}"
            )
        self.__dict__[name] = self._with_additions(name, value)

    def _with_additions(self, target: str, value: Any) -> Any:
        for addition in self._component.additions.get(target, ()):
            self.__dict__[target] = value  # an effect may read the value of its target so far
            value = value + addition(self, self._m)
        return value


class Component:
    """Base class of all models that are exported as FMUs: riders, motorcycles, dampers, rigs, systems.

    A subclass declares its variables as class attributes and defines `equations`, and `mass` where the equations are
    implicit in der(x). An instance holds a name, the source of its values, the parameter values by name (SI), effects,
    and, of identified parameters, `standard_error` and `correlation`; `assumed` holds the reason for each parameter
    that the source does not give, `supplement` numbers of its value file for analyses beyond its equations. Raises
    InputError for an unknown parameter and for a value outside its bounds.

        >>> class Spring(mf.Component):
        ...     '''Torsion spring.'''
        ...
        ...     stiffness = mf.parameter("N.m/rad", "Stiffness", min=0, start=10.0)
        ...     angle = mf.input("rad", "Deflection")
        ...     torque = mf.output("N.m", "Torque against the deflection")
        ...
        ...     def equations(self, v, m):
        ...         return {"torque": -v.stiffness * v.angle}
        >>> spring = Spring(stiffness=20.0)
        >>> spring.title, spring.inputs, spring.outputs, spring.states
        ('Spring', ('angle',), ('torque',), ())
        >>> spring.with_values(stiffness=30.0).values, spring.rows("parameter")["stiffness"].unit
        ({'stiffness': 30.0}, 'N.m/rad')
        >>> spring.with_values(stiffness=-1.0)
        Traceback (most recent call last):
        fmus.support.errors.InputError: stiffness = -1 of Spring ...
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
        self.supplement: dict[str, float] = {}
        self.standard_error: dict[str, float] = {}
        self.correlation: dict[str, dict[str, float]] = {}
        self.effects = tuple(effects)
        self.table: dict[str, Variable] = dict(self.declared)
        self.additions: dict[str, list] = {}
        self.delays: dict[
            str, tuple[str, str]
        ] = {}  # delayed input: (the variable that is delayed, the parameter that is the delay)
        for effect in self.effects:
            effect.join(self)
        self._set_values(values)

    def _set_values(self, values: Mapping[str, float]) -> None:
        parameters = self.rows("parameter")
        for key in values:
            if key not in parameters:
                raise unknown(f"parameter of {self.title}", key, parameters)
        self.values = {key: in_bounds(values.get(key, row.start), row, self.name) for key, row in parameters.items()}

    def __repr__(self) -> str:
        with_effects = f", effects: {', '.join(type(e).__name__ for e in self.effects)}" if self.effects else ""
        source = f", source={shorten(self.source, 60, placeholder='...')!r}" if self.source else ""
        count = f"{len(self.values)} parameter{'' if len(self.values) == 1 else 's'}"
        return f"{self.title}({self.name!r}, {count}{with_effects}{source})"

    def _repr_html_(self) -> str:
        rows = [
            (n, row.symbol, f"{self.values[n]:.6g}", row.unit, row.description, self.assumed.get(n, ""))
            for n, row in self.rows("parameter").items()
        ]
        return html(
            f"{self.title} {self.name}. {self.source}",
            ("parameter", "symbol", "value", "unit", "meaning", "assumed"),
            rows,
        )

    # What a subclass defines -------------------------------------------------------------------------

    def equations(self, v: Scope, m: Any) -> dict[str, Any]:
        """Outputs, calculated parameters and `der(state)` by name; with `mass`, the rows of mass der(x) in place of
        der(x).
        """
        raise NotImplementedError(f"{type(self).__name__} defines no equations")

    def mass(self, v: Scope, m: Any) -> dict[tuple[str, str], Any]:
        """Entries of the mass matrix by (row, column), both names of states; a diagonal without an entry is 1."""
        return {}

    # The table ---------------------------------------------------------------------------------------

    @property
    def title(self) -> str:
        """The name of the class, for messages."""
        return type(self).__name__

    def rows(self, *roles: str) -> dict[str, Variable]:
        """The variables with one of the roles by name, in the order of declaration. Roles: see `Variable`."""
        return {name: row for name, row in self.table.items() if row.role in roles}

    @property
    def states(self) -> tuple[str, ...]:
        """The names of the states, in the order of the table."""
        return tuple(self.rows("state"))

    @property
    def inputs(self) -> tuple[str, ...]:
        """The names of the inputs, in the order of the table."""
        return tuple(self.rows("input"))

    @property
    def outputs(self) -> tuple[str, ...]:
        """The names of the outputs and exposed states, in the order of the table."""
        return tuple(n for n, row in self.table.items() if row.role == "output" or row.exposed)

    def sensor_output(self, name: str) -> str:
        """The name of an output's sensor reading: the output itself, unless an effect acts at the sensor of an
        exposed state.
        """
        return name + SHOWN if name + SHOWN in self.table else name

    @property
    def structure(self) -> tuple:
        """What the equations depend on besides values: components of equal structure share derived code."""
        return (type(self), *(effect.structure for effect in self.effects))

    def with_values(self, **values: float) -> "Component":
        """A copy with some parameters changed.

        Raises InputError for an unknown parameter or a value outside its bounds.
        """
        return self._remade(self.effects, {**self.values, **values})

    def with_effects(self, *effects: Any) -> "Component":
        """A copy with effects added; their variables are added to its table.

        Raises InputError where an effect does not apply.
        """
        return self._remade(self.effects + effects, self.values)

    def _remade(self, effects: tuple, values: Mapping[str, float]) -> "Component":
        twin = type(self)(self.name, self.source, effects, **values)
        twin.assumed, twin.supplement = dict(self.assumed), dict(self.supplement)
        twin.standard_error, twin.correlation = dict(self.standard_error), dict(self.correlation)
        return twin

    # Evaluation --------------------------------------------------------------------------------------

    def start_values(self) -> dict[str, float]:
        """All values by name: parameters, states and inputs at their start values, and time 0."""
        return {"time": 0.0, **self.values, **{n: row.start for n, row in self.rows("state", "input").items()}}

    def run(self, values: Mapping[str, Any], m: Any) -> dict[str, Any]:
        """All locals, outputs, calculated parameters and `der(state)` (before division by the mass matrix) at given
        values.
        """
        scope = Scope(values, self, m)
        results = dict(self.equations(scope, m))
        for target in self._own_rates_of_effects():  # last, because effects may read the outputs
            results.setdefault(target, 0.0)
        for target, value in results.items():
            results[target] = scope._with_additions(target, value)
        results.update({n: scope[n] for n in self.rows("local") if n in scope.__dict__})
        exposed = [n for n, row in self.table.items() if row.exposed]
        results.update({n: scope[n] for n in exposed})
        results.update({n + SHOWN: scope._with_additions(n, scope[n]) for n in exposed if n in self.additions})
        return results

    def complete(self, results: dict[str, Any]) -> dict[str, Any]:
        """The results of `run`, checked.

        Raises InputError where a rate or an output is missing or is not in the table, NotApplicableError where an
        effect adds to what the component does not have.
        """
        expected = {f"der({n})" for n in self.states} | set(self.rows("output", "calculated"))
        returned = set(results) - set(self.rows("local")) - set(self.states)
        if returned != expected:
            missing, extra = sorted(expected - returned), sorted(returned - expected)
            raise InputError(
                f"equations of {self.title}: missing: {missing or 'nothing'}, not in its table: {extra or 'nothing'}"
            )
        targets = {*results, *self.rows("input", "parameter")}
        targets |= {f"mass({row},{column})" for row in self.states for column in self.states}
        for target in self.additions:
            if target.replace(" ", "") not in targets:
                raise NotApplicableError(f"an effect adds to {target!r}, which {self.title} does not have")
        return results

    def mass_entries(self, values: Mapping[str, Any], m: Any) -> dict[tuple[str, str], Any]:
        """The entries of the mass matrix, the terms of effects included."""
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
        """State derivatives (nx,) and outputs (ny,) at states (nx,), inputs (nu,) and time [s]; order of the table,
        SI.
        """
        place = {name: k for k, name in enumerate(self.states)}
        values = {**self.values, "time": time}
        values.update(zip(place, state, strict=True))
        values.update(zip(self.inputs, inputs, strict=True))
        results = self.run(values, NUMERIC)
        rates = np.array([results[f"der({n})"] for n in place], float)
        entries = self.mass_entries(values, NUMERIC)
        if entries:
            matrix = np.eye(len(place))
            for (row, column), entry in entries.items():
                matrix[place[row], place[column]] = entry
            rates = np.linalg.solve(matrix, rates)
        return rates, np.array([results[n] for n in self.outputs], float)


def in_bounds(value: Any, row: Variable, owner: str) -> float:
    """The value as a float. Raises InputError when it is not a finite number within the variable's bounds."""
    try:
        number = float(value)
    except (TypeError, ValueError):
        raise InputError(f"{owner}: {row.name} = {value!r} is not a number [{row.unit}]") from None
    if not (np.isfinite(number) and row.min <= number <= row.max):
        raise InputError(
            f"{owner}: {row.name} = {number:g} {row.unit} is outside its bounds [{row.min:g}, {row.max:g}]"
        )
    return number


def prefixed(rows: Mapping[str, Variable], prefix: str) -> dict[str, Variable]:
    """The variables renamed to `prefix.name`, as in the table of a system."""
    return {f"{prefix}.{name}": replace(row, name=f"{prefix}.{name}") for name, row in rows.items()}
