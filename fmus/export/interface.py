"""The variables of an FMU: a component's table in the order of the value references.

    time | parameters | calculated parameters | inputs | states | other outputs | derivatives of the states

The reference of a variable is its place in this list, for FMI 2 and FMI 3 and for both back ends.
"""

import re
from collections.abc import Iterator
from dataclasses import dataclass

from fmus.declaration.component import Component
from fmus.declaration.variables import Variable, parameter, state
from fmus.equations.sympy_form import Symbolic, symbolic
from fmus.support.errors import InputError

TOLERANCE = parameter("1", "Relative error that an internal step may make where no exact step exists",
                      start=1e-10, min=1e-13, max=1e-2, tunable=False).named("relative_tolerance")  # fmt: skip
TIME = state("s", "Time").named("time")


@dataclass(frozen=True)
class FmuVariable:
    """One variable of the FMU: value reference, role (that of the component, or `time` or `derivative`), row of the
    table, start value."""

    reference: int
    role: str
    row: Variable
    start: float

    @property
    def name(self) -> str:
        return self.row.name

    @property
    def nominal(self) -> float:
        """The nominal; of a state its usual size, on which the tolerance of an importer's solver depends."""
        return self.row.typical if self.role == "state" else self.row.nominal


class Interface:
    """The variables of a component's FMU with their value references."""

    def __init__(self, component: Component):
        self.component = component
        self.form: Symbolic = symbolic(component)
        self.variables = [FmuVariable(i, *entry) for i, entry in enumerate(self._entries())]
        self.references = {v.name: v.reference for v in self.variables}
        if len(self.references) < len(self.variables):
            raise InputError(
                f"{component.name}: {TIME.name!r} and {TOLERANCE.name!r} are variables of every FMU; rename the "
                "component's variable"
            )

    def _entries(self) -> Iterator[tuple[str, Variable, float]]:
        component = self.component
        starts = component.start_values()
        yield "time", TIME, 0.0
        for role in ("parameter", "calculated", "input", "state", "output"):
            for name, row in component.rows(role).items():
                yield role, row.named(name), starts.get(name, 0.0)
            if role == "parameter" and self.has_tolerance:
                yield "parameter", TOLERANCE, TOLERANCE.start
        for name, row in component.rows("state").items():
            yield (
                "derivative",
                state(per_second(row.unit), f"Rate of change of: {row.description}").named(f"der({name})"),
                0.0,
            )

    @property
    def exact(self) -> bool:
        """Whether a step is exact while the inputs in `held` are constant."""
        return self.form.scheduling is not None

    @property
    def held(self) -> tuple[str, ...]:
        return self.form.scheduling or ()

    @property
    def output_order(self) -> int:
        """How many derivatives of the outputs with respect to time follow from the equations and their Jacobian."""
        return 3 if self.exact and self.form.linear_outputs else 1

    @property
    def has_tolerance(self) -> bool:
        """Whether some step has to be taken by the error-controlled method."""
        return bool(self.component.states) and not (self.exact and not self.held)

    @property
    def identifier(self) -> str:
        return identifier(self.component)

    def of(self, *roles: str) -> list[FmuVariable]:
        return [v for v in self.variables if v.role in roles]

    def first(self, role: str) -> int:
        """The first reference of a role; where there is none, the one that it would have."""
        order = ["time", "parameter", "calculated", "input", "state", "output", "derivative"]
        return next(
            (v.reference for v in self.variables if order.index(v.role) >= order.index(role)), len(self.variables)
        )

    def reference(self, name: str) -> int:
        return self.references[name]


def identifier(component: Component) -> str:
    """The component's name as a C identifier."""
    name = re.sub(r"\W", "_", component.name, flags=re.ASCII)
    return name if name[:1].isalpha() else f"model_{name}"


def per_second(name: str) -> str:
    """The unit divided by a second, in the notation of `fmus.declaration.units`: rad -> rad/s, rad/s -> rad/s2."""
    numerator, *denominators = name.split("/")
    match = re.fullmatch(r"(.*?)\bs(\d*)", denominators[-1]) if denominators else None
    if match:
        denominators[-1] = f"{match[1]}s{int(match[2] or 1) + 1}"
    elif numerator == "s":
        return "1"
    elif re.search(r"\.s$", numerator):
        return "/".join([numerator[:-2], *denominators])
    else:
        denominators.append("s")
    return "/".join([numerator, *denominators])
