"""Any component under test: driven by what was recorded, and seen by its outputs; or one of its states imposed.

    forward   inputs told, outputs measured
    imposed   a state told (so its rate and acceleration too), the effort that this takes measured
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace

from fmus.component import Component
from fmus.effects import Effect
from fmus.errors import InputError, unknown
from fmus.resisted import with_a_place
from identification.gap.stands.sensor_zero import zero_of, zero_parameter
from identification.gap.stands.test_stand import Free, imposed_on, parameter_of

COMMON = 1e-3  # of a zero's deviation: what runs have in common is in the runs' own
SLIDING = 0.01  # of the largest rate: friction is fully there above it


@dataclass(frozen=True)
class ComponentTest:
    """A component with the columns of its recordings: `inputs` that are told, `outputs` that are measured.

    imposed is the state that is told instead of the input `outputs[0]`; "" where the component runs forward. given
    holds parameters of effects that the test sets, largest the largest deflection seen [rad or m]. zeros are by how much
    recorded inputs may be off, in every run by another constant.
    """

    component: Component
    inputs: tuple[str, ...]
    outputs: tuple[str, ...]
    free: tuple[Free, ...]
    imposed: str = ""
    given: Mapping[str, float] = field(default_factory=dict)
    largest: float = 1.0
    measured_effects: Mapping[str, tuple[float, float]] = field(default_factory=dict)
    zeros: Mapping[str, float] = field(default_factory=dict)

    @property
    def open(self) -> tuple[str, ...]:
        """The parameters that are fitted as they are, beside the free ones."""
        return tuple(zero_parameter(name) for name in self.zeros)

    def with_zeros(self, deviations: Mapping[str, float]) -> "ComponentTest":
        """The test of which recorded inputs may be off, by constants of such deviations, in every run by another."""
        common = {zero_parameter(name): (0.0, COMMON * deviation) for name, deviation in deviations.items()}
        return replace(self, zeros=deviations, measured_effects={**self.measured_effects, **common})

    @property
    def driven(self) -> tuple[str, ...]:
        """The inputs that an actuator gives; where a state is imposed, whatever that takes is given."""
        return () if self.imposed else self.inputs

    def with_effects(self, effects: Sequence[type[Effect]]) -> Component:
        """The component as the test sees it, with effects."""
        effects = [*(zero_of(self.component, name) for name in self.zeros), *effects]
        if self.imposed:
            seen = imposed_on(self.component, self.imposed, self.outputs[0], effects)
        else:
            seen = self.component.with_effects(*(e() for e in effects))
        seen.values |= {n: v for n, v in self.given.items() if n in seen.values}
        return seen

    def parameter(self, effect: type[Effect], name: str) -> str:
        """The name of an effect's parameter in the component."""
        return parameter_of(self.component, effect, name)

    def scaled(self, deflection: float, rate: float) -> "ComponentTest":
        """The test, the largest deflection and rate known: friction comes in at a small share of that rate."""
        return replace(self, largest=deflection, given={**self.given, "coulomb_friction.sliding_rate": max(SLIDING * rate, 1e-6)})


def component_test(component: Component, columns: Sequence[str], imposed: str = "", free: Sequence[str] = ()) -> ComponentTest:
    """The test of a component whose recordings have these columns.

    Raises InputError where they do not drive it, or show nothing of it.
    """
    fitted = tuple(Free(n) for n in _free(component, free))
    if imposed:
        if imposed not in component.states:
            raise InputError(f"--impose: {unknown(f'state of {component.title}', imposed, component.states)}")
        efforts = [n for n in component.inputs if n in columns]
        if imposed not in columns or not efforts:
            raise InputError(f"imposed {imposed} needs the columns {imposed} and one of {', '.join(component.inputs)}; found {', '.join(columns)}; "
                             "name them with --map COLUMN=VARIABLE")  # fmt: skip
        return ComponentTest(with_a_place(component), (imposed, *efforts[1:]), (efforts[0],), fitted, imposed)
    inputs = tuple(n for n in component.inputs if n in columns)
    outputs = tuple(n for n in component.outputs if n in columns)
    if not outputs:
        raise InputError(f"no column is an output of {component.title} (its outputs: {', '.join(component.outputs)}; columns: {', '.join(columns)}); "
                         "name them with --map COLUMN=VARIABLE")  # fmt: skip
    return ComponentTest(with_a_place(component), inputs, outputs, fitted)


def _free(component: Component, wanted: Sequence[str]) -> list[str]:
    parameters = component.rows("parameter")
    for name in wanted:
        if name not in parameters:
            raise InputError(f"--free: {unknown(f'parameter of {component.title}', name, parameters)}")
        if component.values[name] == 0:
            raise InputError(f"--free {name}: it is 0 in {component.title}, and a fit starts from a value that is not 0")
    return list(wanted) or [n for n, row in parameters.items() if row.tunable and (component.values[n] > 0 or (component.values[n] < 0 and row.min < 0))]
