"""An effect: a physical phenomenon that adds terms to named quantities of a component, with variables of its own.

    class HardeningStiffness(Effect):
        cubic_stiffness = parameter("N.m/rad3", "Stiffness that grows with the square of the deflection", min=0)

        @adds_to("arm_torque")
        def cubic(self, v, m):
            return v.cubic_stiffness * v.arm_deflection**3

A target is a local variable, an input or a parameter as the equations read it, an output (of an exposed state: its
sensor reading), `der(state)` (before division by the mass matrix) or `mass(row, column)`. An addition may read every
value that the equations have set so far.

An effect of a library has a `family` (the law) and a `form` (its variant). Its variables are `family.name` in the
table of the component, so that different effects may use equal names. `element` is the force element at which it acts
(see `fmus.declaration.elements`); there it may use `force`, `deflection`, `rate`, `stiffness` and `damping`. Inputs,
outputs and states are elements as well, with themselves as force and deflection; the deflection of an input is its
recorded value, without what effects add. `a_to_b` is an element between two states of one unit, with the deflection a
and the force b. At a translational element N.m and rad become N and m; where the force is per unit of inertia, so are
the parameters.

The first parameter is the magnitude: at zero the effect is absent. `starts` gives starting values for a fit. The
bounds of the parameters express the physical sign.
"""

from collections.abc import Callable, Collection, Iterator, Mapping
from dataclasses import fields, replace
from itertools import permutations
from typing import Any, ClassVar

from fmus.declaration.component import RECORDED, SHOWN, Component, Scope
from fmus.declaration.elements import Element
from fmus.declaration.variables import Variable, input, output
from fmus.effects.delay import delay_states
from fmus.effects.prior import LogNormalPrior
from fmus.expressions.functions import NUMERIC
from fmus.support.errors import NotApplicableError, unknown


def adds_to(*targets: str) -> Callable[[Callable], Callable]:
    """Mark a method `(self, v, m)` of an effect as the term, in the target's SI unit, that is added to each of the
    targets.

    targets are names of the component, or `force` of the effect's element. Where the effect is applied to a component
    that has no such name, it Raises InputError with the valid ones.

        >>> class Preload(mf.Effect):
        ...     '''A constant torque of the arms.'''
        ...
        ...     preload = mf.parameter("N.m", "Torque", start=2.0)
        ...
        ...     @mf.adds_to("arm_torque")
        ...     def constant(self, v, m):
        ...         return v.preload
        >>> mf.rider("mean_2011").with_effects(Preload()).values["preload"]
        2.0
    """

    def mark(method: Callable) -> Callable:
        method.targets = targets  # type: ignore[attr-defined]
        return method

    return mark


class Effect:
    """Base class of effects. Its variables are added to the table of the component that it is applied to, in SI units.

    `delayed` declares delayed values: {"late_angle": ("deflection", "delay")}. They are states of a Pade approximation
    or, with exact_delays=True, inputs to be supplied by the caller, which has the past motion. `join` adds the effect
    to a component, whose `with_effects` calls it; it raises InputError where the component lacks the element or a
    target. `structure` is what the equations depend on besides values.

        >>> class CubicSpring(mf.Effect):
        ...     '''The spring stiffens with the square of its deflection.'''
        ...
        ...     family, form, element = "hardening_stiffness", "cubic", "spring"
        ...     cubic_stiffness = mf.parameter("N.m/rad3", "Stiffness per squared deflection", min=0, start=1e4)
        ...
        ...     @mf.adds_to("force")
        ...     def cubic(self, v, m):
        ...         return v.cubic_stiffness * v.deflection**3
        >>> mf.mechanism("driven_joint").with_effects(CubicSpring()).values["hardening_stiffness.cubic_stiffness"]
        10000.0
    """

    declared: ClassVar[dict[str, Variable]] = {}
    family: ClassVar[str] = ""
    form: ClassVar[str] = ""
    element: ClassVar[str] = ""
    part: ClassVar[str] = "device"
    # at elements of generic components: True for those with a stiffness only, False for those without, None for all
    of_stiffness: ClassVar[bool | None] = None
    flexible: ClassVar[bool] = False
    at_one: ClassVar[tuple[type["Effect"], ...]] = ()  # of a law at several elements: the law at each of them alone
    both_ways: ClassVar[bool] = False  # its force is that of another law where the rate of its element has one sign
    starts: ClassVar[Mapping[str, tuple[float, ...]]] = {}
    relative: ClassVar[tuple[str, ...]] = ()  # parameters whose starting values are shares of the largest deflection
    # standard deviations of the initial values, about zero, of states that the equations of the effect bound
    initial_deviations: ClassVar[Mapping[str, float]] = {}
    at_least: ClassVar[Mapping[str, float]] = {}  # lower bounds of parameters, as shares of the largest deflection
    at_most: ClassVar[Mapping[str, float]] = {}  # upper bounds, likewise
    # lower bounds as shares of the largest value of the input or output at which it acts
    at_least_of_level: ClassVar[Mapping[str, float]] = {}
    at_most_of_rate: ClassVar[Mapping[str, float]] = {}  # upper bounds, as shares of the largest rate
    # lower bounds of rates over the sliding rate of dry friction that the experiment sets
    at_least_sliding: ClassVar[Mapping[str, float]] = {}
    # Parameters whose starting values are in proportion, at elements of generic components to the largest rate, at an
    # input or output to its largest value, and to the period or the frequency of the motion.
    relative_to_rate: ClassVar[tuple[str, ...]] = ()
    relative_to_level: ClassVar[tuple[str, ...]] = ()
    relative_to_period: ClassVar[tuple[str, ...]] = ()
    relative_to_frequency: ClassVar[tuple[str, ...]] = ()
    times: ClassVar[tuple[str, ...]] = ()  # time constants, whose bounds the period of the motion widens
    within_range: ClassVar[tuple[str, ...]] = ()  # starting values as shares of the range of the state at which it acts
    in_its_unit: ClassVar[tuple[str, ...]] = ()  # variables in the unit of the input, output or state at which it acts
    given: ClassVar[tuple[str, ...]] = ()  # parameters that the experiment sets, such as its duration
    named_by: ClassVar[
        tuple[str, ...]
    ] = ()  # of an unspecified law: the families of a library that describe the same behaviour
    lags: ClassVar[tuple[str, ...]] = ()  # parameters that are delays
    lag_grows: ClassVar[bool] = (
        False  # the delay is the parameter times the time, or times the share of the duration that has passed
    )
    delayed: ClassVar[Mapping[str, tuple[str, str]]] = {}
    prior: ClassVar[LogNormalPrior | None] = None  # of all free parameters, which then are positive and have no zero

    def __init_subclass__(cls, **options) -> None:
        super().__init_subclass__(**options)
        rows = dict(cls.declared)
        rows.update({n: row.named(n) for n, row in vars(cls).items() if isinstance(row, Variable)})
        cls.declared = rows

    def __init__(self, exact_delays: bool = False):
        self.exact_delays = exact_delays

    def __repr__(self) -> str:
        name = f"{self.family}.{self.form}" if self.family else "no family"
        return f"{type(self).__name__}({name}{f' at {self.element}' if self.element else ''})"

    @property
    def structure(self) -> Any:
        """What the terms depend on besides values (see `Component.structure`)."""
        return (type(self), self.exact_delays)

    @classmethod
    def sentence(cls) -> str:
        """The effect in one sentence: the first line of its docstring."""
        return (cls.__doc__ or "").strip().splitlines()[0]

    @classmethod
    def parameters(cls) -> dict[str, Variable]:
        """Its parameters by name, the magnitude first, those that the experiment sets last."""
        names = sorted((n for n, row in cls.declared.items() if row.role == "parameter"), key=lambda n: n in cls.given)
        return {n: cls.declared[n] for n in names}

    @classmethod
    def free_parameters(cls) -> tuple[str, ...]:
        """The parameters to be fitted, the magnitude first."""
        return tuple(n for n in cls.parameters() if n not in cls.given)

    @classmethod
    def nonlinear_parameters(cls) -> tuple[str, ...]:
        """The parameters in which the added term is nonlinear: widths, frequencies, delays; all that have a prior."""
        if cls.prior is not None:
            return cls.free_parameters()
        first = cls.free_parameters()[0]
        return tuple(n for n in (*cls.starts, *cls.lags) if n != first)

    @classmethod
    def has_states(cls) -> bool:
        """Whether it has states of its own."""
        return any(row.role == "state" for row in cls.declared.values())

    @classmethod
    def magnitudes(cls) -> tuple[str, ...]:
        """The parameters in which the added term is linear."""
        return tuple(n for n in cls.free_parameters() if n not in cls.nonlinear_parameters())

    @classmethod
    def magnitudes_by_element(cls) -> list[tuple[str, ...]]:
        """The magnitudes at each of its elements: where those of one are zero, it is absent there."""
        return [cls.magnitudes()]

    def join(self, component: Component) -> None:
        """Add the variables and terms to the component. Raises InputError for a missing element and for equal names."""
        prefix = f"{self.family}." if self.family else ""
        words = self._words(component)
        # The forces of several elements have one unit.
        force = next((component.table[name].unit for word, name in words.items() if word.startswith("force")), "")
        rows = {prefix + n: _placed(row, prefix + n, force) for n, row in self.declared.items()}
        clash = component.table.keys() & rows.keys()
        if clash:
            raise NotApplicableError(
                f"effect {type(self).__name__} and {component.title} both declare {', '.join(sorted(clash))}"
            )
        component.table.update(rows)
        view = _Names(prefix, words)
        own = {n for n, row in self.declared.items() if row.role != "parameter"}
        for target, method in self.additions():
            self._add(component, view.target(target, own), method, view)
        for name, (source, delay) in self.delayed.items():
            self._join_delayed(component, name, view.name(source), prefix + delay, view)

    def additions(self) -> Iterator[tuple[str, Callable]]:
        """Every target with the method that computes its term."""
        for name in dir(type(self)):
            for target in getattr(getattr(type(self), name), "targets", ()):
                yield target, getattr(self, name)

    @classmethod
    def reads(cls) -> set[str]:
        """The names that its terms read: own variables, and `deflection`, `rate` and so on of its element.

        >>> from fmus.effects.damping import ProgressiveDamping
        >>> sorted(ProgressiveDamping.reads())
        ['coefficient', 'rate']
        """
        reader = _Reader()
        for _, method in cls().additions():
            method(reader, NUMERIC)
        return reader.read | {source for source, _ in cls.delayed.values()}

    @staticmethod
    def words_at(component: Component, place: str) -> dict[str, str]:
        """The component's names of the variables that an element has, by `force`, `deflection`, `rate` and so on.

        Raises InputError for a missing element.
        """
        elements = {**_signals(component), **component.elements}
        if place not in elements:
            raise unknown(f"element of {component.title}", place, elements, NotApplicableError)
        return {f.name: name for f in fields(Element) if (name := getattr(elements[place], f.name))}

    def _words(self, component: Component) -> dict[str, str]:
        """The component's names for the words of its element; none where it acts at no element."""
        return self.words_at(component, self.element) if self.element else {}

    @staticmethod
    def _add(component: Component, target: str, method: Callable, view: "_Names") -> None:
        row = component.table.get(target)
        if row is not None and row.role == "state" and row.exposed:
            component.table[target + SHOWN] = output(row.unit, f"{row.description}, as its sensor measures it").named(
                target + SHOWN
            )
        component.additions.setdefault(target, []).append(lambda scope, m: method(view.of(scope), m))

    def _join_delayed(self, component: Component, name: str, source: str, delay: str, view: "_Names") -> None:
        key = view.prefix + name
        if source not in component.table:
            raise unknown(f"quantity of {component.title}", source, component.table, NotApplicableError)
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


class _Names:
    """The mapping of the names that an effect uses to the names in the table of the component."""

    def __init__(self, prefix: str, words: Mapping[str, str]):
        self.prefix, self.words = prefix, words
        self.computed: dict[str, Callable[[Scope], Any]] = {}

    def name(self, word: str) -> str:
        """The component's name for `force`, `deflection` and so on of the element; any other word is a name already."""
        return self.words.get(word, word)

    def target(self, target: str, own: Collection[str]) -> str:
        if target.startswith(("der(", "mass(")):
            what, _, inside = target[:-1].partition("(")
            return f"{what}({', '.join(self.prefix + n if n in own else self.name(n) for n in inside.split(', '))})"
        return self.prefix + target if target in own and target != "force" else self.name(target)

    def of(self, scope: Scope) -> "_View":
        return _View(self, scope)


class _View:
    """The argument `v` of an effect's methods: its own variables and those of its element under their short names."""

    def __init__(self, names: _Names, scope: Scope):
        self._names, self._scope = names, scope

    def __getattr__(self, word: str) -> Any:
        names, scope = self._names, self._scope
        if word in names.computed:
            return names.computed[word](scope)
        key = names.prefix + word
        return scope[key] if key in scope.__dict__ else getattr(scope, names.name(word))


class _Reader:
    """An argument `v` of an effect's methods that collects the names which are read; every value is 1."""

    def __init__(self) -> None:
        self.read: set[str] = set()

    def __getattr__(self, word: str) -> float:
        self.read.add(word)
        return 1.0


def _signals(component: Component) -> dict[str, Element]:
    """The inputs, outputs and states of a component, and pairs of states of one unit, as elements."""
    table, states = component.table, [n for n in component.states if n in component.declared]
    transfers = [(a, b) for a, b in permutations(states, 2) if table[a].unit == table[b].unit]
    return {
        **{f"{a}_to_{b}": Element(b, a, "") for a, b in transfers},
        **{n: Element(n, n, "") for n in (*component.states, *component.outputs)},
        **{n: Element(n, n + RECORDED, "") for n in component.inputs},
    }


PER_INERTIA = {"m/s2": "N/kg", "rad/s2": "N.m/kg.m2"}  # forces per unit of inertia that are written as accelerations


def _placed(row: Variable, name: str, force: str) -> Variable:
    """The row at an element whose force has the unit `force`: N.m or N, or N.m/kg.m2 or N/kg per unit of inertia."""
    force = PER_INERTIA.get(force, force)
    translational = force in ("N", "N/kg")
    unit = row.unit.replace("N.m", "N").replace("kg.m2", "kg").replace("rad", "m") if translational else row.unit
    inertia = {"N/kg": "kg", "N.m/kg.m2": "kg.m2"}.get(force, "")
    if inertia and ("N" in unit or "kg" in unit):
        unit += f".{inertia}" if "/" in unit else f"/{inertia}"
    return replace(row, name=name, unit=unit)
