"""An effect: a physical phenomenon that adds to named quantities of a component, with its own variables.

    class HardeningStiffness(Effect):
        cubic_stiffness = parameter("N.m/rad3", "Stiffness that grows with the square of the deflection", min=0)

        @adds_to("arm_torque")
        def cubic(self, v, m):
            return v.cubic_stiffness * v.arm_deflection**3

A target is a local variable, an input or a parameter as the component sees it, an output (an exposed state: what is shown
of it), `der(state)` (before the mass matrix) or `mass(row, column)`. What is added may read everything that the equations have set by then.

An effect of a library has a `family` and a `form`; its variables then are `family.name` in the component's table,
so that several effects may use the same word. At an `element` (see `fmus.elements`) it may say `force`,
`deflection`, `rate`, `stiffness` and `damping`; the name of an input or an output is an element too, whose force and
deflection it is. Where the element is translational, N.m and rad become N and m.

Its first parameter is its size: at zero the effect is absent. `starts` gives further values from which to search.
The bounds of its parameters hold the physical sign.
"""

from collections.abc import Callable, Iterator, Mapping
from dataclasses import replace
from typing import Any, ClassVar

from fmus.component import SHOWN, Component, Scope
from fmus.effects.delay import delay_states
from fmus.elements import Element
from fmus.errors import InputError, unknown
from fmus.variables import Variable, input, output


def adds_to(*targets: str) -> Callable[[Callable], Callable]:
    """Marks a method of an effect as the addition to a target, or to several the same."""

    def mark(method: Callable) -> Callable:
        method.targets = targets  # type: ignore[attr-defined]
        return method

    return mark


class Effect:
    """Base of the effects. Its variables join the table of the component that it is added to.

    `delayed` names values that lag: {"late_angle": ("deflection", "delay")}. They become states of a Pade form, or,
    with exact_delays, inputs that whoever knows the motion supplies.
    """

    declared: ClassVar[dict[str, Variable]] = {}
    family: ClassVar[str] = ""
    form: ClassVar[str] = ""
    element: ClassVar[str] = ""
    part: ClassVar[str] = "device"
    flexible: ClassVar[bool] = False
    starts: ClassVar[Mapping[str, tuple[float, ...]]] = {}
    relative: ClassVar[tuple[str, ...]] = ()  # parameters whose starts are shares of the largest motion
    at_least: ClassVar[Mapping[str, float]] = {}  # least values of parameters, as shares of the largest motion
    at_most: ClassVar[Mapping[str, float]] = {}  # the same of their largest values
    relative_to_rate: ClassVar[tuple[str, ...]] = ()  # the same of the largest rate, on a component that is no rig of ours
    relative_to_level: ClassVar[tuple[str, ...]] = ()  # the same of the largest value of the input or output that it acts at
    given: ClassVar[tuple[str, ...]] = ()  # parameters that the experiment sets (its duration)
    named_by: ClassVar[tuple[str, ...]] = ()  # of an unlisted law: families that, where a library has them, are names for what it does
    lags: ClassVar[tuple[str, ...]] = ()  # parameters that are delays
    lag_grows: ClassVar[bool] = False  # the delay is such a parameter times the time, as a share of the duration where the experiment sets that
    delayed: ClassVar[Mapping[str, tuple[str, str]]] = {}

    def __init_subclass__(cls, **options) -> None:
        super().__init_subclass__(**options)
        rows = dict(cls.declared)
        rows.update({n: row.named(n) for n, row in vars(cls).items() if isinstance(row, Variable)})
        cls.declared = rows

    def __init__(self, exact_delays: bool = False):
        self.exact_delays = exact_delays

    @property
    def structure(self) -> Any:
        return (type(self), self.exact_delays)

    @classmethod
    def sentence(cls) -> str:
        """What the effect is, in one sentence."""
        return (cls.__doc__ or "").strip().splitlines()[0]

    @classmethod
    def parameters(cls) -> dict[str, Variable]:
        """The rows of its parameters, its size first, those that the experiment sets last."""
        names = sorted((n for n, row in cls.declared.items() if row.role == "parameter"), key=lambda n: n in cls.given)
        return {n: cls.declared[n] for n in names}

    @classmethod
    def sought(cls) -> tuple[str, ...]:
        """The parameters that a fit has to find, its size first."""
        return tuple(n for n in cls.parameters() if n not in cls.given)

    @classmethod
    def shapes(cls) -> tuple[str, ...]:
        """The parameters in which what the effect adds is not linear: widths, frequencies, delays."""
        first = cls.sought()[0]
        return tuple(n for n in (*cls.starts, *cls.lags) if n != first)

    def join(self, component: Component) -> None:
        """Put this effect's variables and additions into the component. Raises InputError on a clash."""
        prefix = f"{self.family}." if self.family else ""
        element = self._element_of(component)
        translational = element is not None and component.table[element.force].unit == "N"
        rows = {prefix + n: _placed(row, prefix + n, translational) for n, row in self.declared.items()}
        clash = component.table.keys() & rows.keys()
        if clash:
            raise InputError(f"effect {type(self).__name__} and {component.title} both declare {', '.join(sorted(clash))}")
        component.table.update(rows)
        view = _Words(prefix, element)
        for target, method in self.additions():
            self._add(component, view.target(target, self.declared), method, view)
        for name, (source, delay) in self.delayed.items():
            self._join_delayed(component, name, view.name(source), prefix + delay, view)

    def additions(self) -> Iterator[tuple[str, Callable]]:
        """Every target with what is added to it: the methods that are marked."""
        for name in dir(type(self)):
            for target in getattr(getattr(type(self), name), "targets", ()):
                yield target, getattr(self, name)

    def _element_of(self, component: Component) -> Element | None:
        ports = {n: Element(n, n, "") for n in (*component.inputs, *component.outputs)} if self.element else {}
        elements = {**ports, **component.elements}
        if self.element and self.element not in elements:
            raise unknown(f"element of {component.title}", self.element, elements)
        return elements.get(self.element)

    @staticmethod
    def _add(component: Component, target: str, method: Callable, view: "_Words") -> None:
        row = component.table.get(target)
        if row is not None and row.role == "state" and row.exposed:
            component.table[target + SHOWN] = output(row.unit, f"{row.description}, as its sensor shows it").named(target + SHOWN)
        component.additions.setdefault(target, []).append(lambda scope, m: method(view.of(scope), m))

    def _join_delayed(self, component: Component, name: str, source: str, delay: str, view: "_Words") -> None:
        key = view.prefix + name
        if source not in component.table:
            raise unknown(f"quantity of {component.title}", source, component.table)
        row = component.table[source]
        if self.exact_delays:
            component.table[key] = input(row.unit, f"{row.description}, delayed").named(key)
            component.delays[key] = (source, delay)
            return
        states, rates, value = delay_states(key, row, source, delay)
        component.table.update(states)
        for target, rate in rates.items():
            component.additions.setdefault(target, []).append(rate)
        view.computed[name] = value


class _Words:
    """How an effect's words map to the names in the component's table."""

    def __init__(self, prefix: str, element: Element | None):
        self.prefix, self.element = prefix, element
        self.computed: dict[str, Callable[[Scope], Any]] = {}

    def name(self, word: str) -> str:
        """The component's name for a word of the element; any other word is a name already."""
        return (getattr(self.element, word, "") if self.element else "") or word

    def target(self, target: str, own: Mapping[str, Variable]) -> str:
        if target.startswith(("der(", "mass(")):
            what, _, inside = target[:-1].partition("(")
            return f"{what}({', '.join(self.prefix + n if n in own else n for n in inside.split(', '))})"
        return self.prefix + target if target in own and target != "force" else self.name(target)

    def of(self, scope: Scope) -> "_View":
        return _View(self, scope)


class _View:
    """The component's scope as an effect sees it: its own variables and the element's words by their short names."""

    def __init__(self, words: _Words, scope: Scope):
        self._words, self._scope = words, scope

    def __getattr__(self, word: str) -> Any:
        words, scope = self._words, self._scope
        if word in words.computed:
            return words.computed[word](scope)
        key = words.prefix + word
        return scope[key] if key in scope.__dict__ else getattr(scope, words.name(word))


def _placed(row: Variable, name: str, translational: bool) -> Variable:
    unit = row.unit.replace("N.m", "N").replace("kg.m2", "kg").replace("rad", "m") if translational else row.unit
    return replace(row, name=name, unit=unit)
