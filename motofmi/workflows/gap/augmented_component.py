"""A component as fitted, with the effects found: its value file, which every command accepts, and its FMU."""

from typing import Any

import numpy as np

from fmus.composition.value_files import value_file
from fmus.declaration.component import Component
from fmus.linear_analysis.linearisation import linearise
from motofmi.gap.estimation.fit_result import Fit, parameters_of
from motofmi.gap.experiments.input_output import InputOutputExperiment
from motofmi.workflows.gap.fitted_model import FittedModel

FILE = "augmented_component.toml"


def component_of(experiment: InputOutputExperiment, found: Fit) -> Component:
    """The component with the fitted values and the effects found, without effects of the measuring channel.

    An imposed state is a state again, so that the component has its own inputs.
    """
    with_effects = experiment.component.with_effects(*(e() for e in found.model.effects if e.part == "device"))
    model: Any = found.model
    values = model.values(found.shared) | {n: found.runs[0].duration
                                           for n in with_effects.values if n.endswith(".duration")}
    rows = with_effects.table  # a value at its bound may differ from it by rounding
    return with_effects.with_values(
        **{n: float(np.clip(values.get(n, v), rows[n].min, rows[n].max)) for n, v in with_effects.values.items()}
    )


def fitted_component(
    experiment: InputOutputExperiment, found: Fit, source: str, own_class: tuple[str, str] | None = None
) -> FittedModel:
    """The component as fitted, with the effects found; own_class is the file and the name of a user's own class."""
    fitted = component_of(experiment, found)
    errors = {n: error for n, (_, error, _) in parameters_of(found).items()}
    parameters = {n: (value, errors.get(n), fitted.table[n].unit) for n, value in fitted.values.items()}
    class_file, title = own_class or (None, fitted.title)
    text = value_file(title, parameters, "Component as fitted to recordings, with the effects of the best model",
                      source, [type(e) for e in fitted.effects], component_file=class_file)  # fmt: skip
    fitted.name = FILE.removesuffix(".toml")
    return FittedModel(fitted, FILE, text)


def own_modes(component: Component) -> list[dict[str, Any]]:
    """Eigenvalue [1/s], frequency [Hz] and damping ratio of each mode of the component at rest.

    A real eigenvalue has frequency 0 and no damping ratio.
    """
    roots = np.linalg.eigvals(linearise(component).A) if component.states else np.zeros(0)
    return [{"eigenvalue": [complex(x)], "frequency": [float(x.imag / (2 * np.pi))],
             "damping_ratio": [float(-x.real / abs(x)) if x.imag else None]}
            for x in sorted(roots[roots.imag >= 0], key=lambda x: (abs(x), x.real))]  # fmt: skip
