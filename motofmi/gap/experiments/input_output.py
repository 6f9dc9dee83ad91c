"""The input-output experiment on any component: recorded inputs drive it, or one of its states is imposed.

    forward   inputs given, outputs measured
    imposed   a state given (with its rate and acceleration), the effort measured
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from math import inf

from fmus.composition.added_force import with_force_element
from fmus.declaration.component import Component
from fmus.effects import Effect
from fmus.support.errors import InputError, unknown
from motofmi.gap.experiments.experiment import FreeParameter, parameter_of, with_imposed_state
from motofmi.gap.experiments.sensor_offset import sensor_offset_effect, sensor_offset_parameter

# Prior of the smaller part of a sensor offset over that of the larger one: of the part that is common to all runs, since
# offsets belong to single runs, or of that of each run, where these take the place of dry friction.
SMALLER_PART = 1e-3
SLIDING_RATE = "coulomb_friction.sliding_rate"
LEAST_SLIDING_RATE = 1e-12  # rad/s or m/s, of a component at rest
# Sliding rate of Coulomb friction over the largest rate. A simulation has to resolve the transition through zero rate;
# an imposed motion is not simulated. The last is the narrowest transition to which a fit is continued.
SLIDING, SLIDING_IMPOSED, SLIDING_LEAST = 0.01, 0.001, 0.0001


@dataclass(frozen=True, repr=False)
class InputOutputExperiment:
    """A component with the columns of its recordings: recorded `inputs` and measured `outputs`.

    imposed is the state that is given instead of the input `outputs[0]`; "" where the component runs forward. given
    holds parameters of effects that the experiment sets, largest is the largest measured deflection [rad or m] and
    largest_rate the largest rate of it, infinite where it is not known yet.
    sensor_offsets holds the standard deviation of each input's sensor offset, which differs from run to run unless
    common_offsets says that all runs have the same; of an imposed motion these may be those of the effort. own_values
    says whether the component's values are a user's: those that ship are starting values and no expectation. from_rest
    says that every stretch of a recording begins at rest, so that its initial states are known.
    """

    component: Component
    inputs: tuple[str, ...]
    outputs: tuple[str, ...]
    free: tuple[FreeParameter, ...]
    imposed: str = ""
    given: Mapping[str, float] = field(default_factory=dict)
    largest: float = 1.0
    largest_rate: float = inf
    measured_effects: Mapping[str, tuple[float, float]] = field(default_factory=dict)
    sensor_offsets: Mapping[str, float] = field(default_factory=dict)
    common_offsets: bool = False
    own_values: bool = True
    from_rest: bool = False

    def __repr__(self) -> str:
        inputs, outputs = (", ".join(names) or "none" for names in (self.inputs, self.outputs))
        return f"InputOutputExperiment({self.component.name!r}, inputs {inputs}, outputs {outputs})"


    @property
    def unrestricted(self) -> tuple[str, ...]:
        """The parameters besides the free ones that are fitted without a fixed sign: the sensor offsets."""
        return tuple(sensor_offset_parameter(name) for name in self.sensor_offsets)

    def with_sensor_offsets(self, deviations: Mapping[str, float], common: bool = False) -> "InputOutputExperiment":
        """The experiment with sensor offsets of these standard deviations on its recorded inputs, one in each run, or
        one that is common to all runs."""
        of_all, of_each = (1.0, SMALLER_PART) if common else (SMALLER_PART, 1.0)
        priors = {sensor_offset_parameter(name): (0.0, of_all * deviation) for name, deviation in deviations.items()}
        return replace(
            self,
            sensor_offsets={name: of_each * deviation for name, deviation in deviations.items()},
            common_offsets=common,
            measured_effects={**self.measured_effects, **priors},
        )

    @property
    def driven(self) -> tuple[str, ...]:
        """The inputs that an actuator drives; none where a state is imposed."""
        return () if self.imposed else self.inputs

    def with_effects(self, effects: Sequence[type[Effect]]) -> Component:
        """The component with effects, with the recorded inputs as inputs and the measured outputs as outputs."""
        effects = [*(sensor_offset_effect(self.component, name) for name in self.sensor_offsets), *effects]
        if self.imposed:
            seen = with_imposed_state(self.component, self.imposed, self.outputs[0], effects)
        else:
            seen = self.component.with_effects(*(e() for e in effects))
        seen.values |= {n: v for n, v in self.given.items() if n in seen.values}
        return seen

    @property
    def sliding_rate(self) -> float:
        """The rate from which on dry friction is nearly fully developed; 0 where no motion is known yet."""
        return self.given.get(SLIDING_RATE, 0.0)

    @property
    def least_sliding_rate(self) -> float:
        """The narrowest transition of dry friction [rad/s or m/s] to which a fit is continued."""
        share = SLIDING_IMPOSED if self.imposed else SLIDING_LEAST
        return max(share * self.largest_rate, LEAST_SLIDING_RATE)

    @property
    def narrowed(self) -> bool:
        """Whether dry friction has a narrower transition than in the search; not where no motion is known yet."""
        return self.largest_rate < inf and self.sliding_rate < self._wide_sliding_rate(self.largest_rate)

    def with_sliding_rate(self, rate: float) -> "InputOutputExperiment":
        """The experiment with another rate from which on Coulomb friction slides."""
        return replace(self, given={**self.given, SLIDING_RATE: rate})

    def parameter(self, effect: type[Effect], name: str) -> str:
        """The name of an effect's parameter in the component."""
        return parameter_of(self.component, effect, name)

    def scaled(self, deflection: float, rate: float) -> "InputOutputExperiment":
        """The experiment with its largest deflection and rate; Coulomb friction slides from a small
        share of that rate on."""
        given = {**self.given, SLIDING_RATE: self._wide_sliding_rate(rate)}
        return replace(self, largest=deflection, largest_rate=rate, given=given)

    def _wide_sliding_rate(self, rate: float) -> float:
        return max((SLIDING_IMPOSED if self.imposed else SLIDING) * rate, LEAST_SLIDING_RATE)


def input_output_experiment(
    component: Component, columns: Sequence[str], imposed: str = "", free: Sequence[str] = ()
) -> InputOutputExperiment:
    """The experiment on a component whose recordings have these columns.

    Raises InputError where no column is an output of the component, or the imposed state or its effort is missing.
    """
    fitted = tuple(FreeParameter(n) for n in _free(component, free))
    if imposed:
        if imposed not in component.states:
            raise InputError(f"--impose: {unknown(f'state of {component.title}', imposed, component.states)}")
        efforts = [n for n in component.inputs if n in columns]
        if imposed not in columns or not efforts:
            raise InputError(f"imposed {imposed} needs the columns {imposed} and one of {', '.join(component.inputs)}; "
                             f"found {', '.join(columns)}; "
                             "name them with --map COLUMN=VARIABLE")  # fmt: skip
        return InputOutputExperiment(
            with_force_element(component), (imposed, *efforts[1:]), (efforts[0],), fitted, imposed
        )
    inputs = tuple(n for n in component.inputs if n in columns)
    outputs = tuple(n for n in component.outputs if n in columns)
    if not outputs:
        raise InputError(f"no column is an output of {component.title} (its outputs: {', '.join(component.outputs)}; "
                         f"columns: {', '.join(columns)}); "
                         "name them with --map COLUMN=VARIABLE")  # fmt: skip
    return InputOutputExperiment(with_force_element(component), inputs, outputs, fitted)


def _free(component: Component, wanted: Sequence[str]) -> list[str]:
    parameters = component.rows("parameter")
    for name in wanted:
        if name not in parameters:
            raise InputError(f"--free: {unknown(f'parameter of {component.title}', name, parameters)}")
        if component.values[name] == 0:
            raise InputError(
                f"--free {name}: it is 0 in {component.title}, and a fit starts from a value that is not 0"
            )
    return list(wanted) or [
        n
        for n, row in parameters.items()
        if row.tunable and (component.values[n] > 0 or (component.values[n] < 0 and row.min < 0))
    ]
