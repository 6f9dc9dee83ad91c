"""Any component as fitted, with the effects that were found: a value file that every command takes, and its FMU."""

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from fmus.build import build
from fmus.component import Component
from fmus.library import value_file
from fmus.linear import linearise
from identification.gap.naming.fitted import Fit
from identification.gap.stands.component_test import ComponentTest
from scenarios.command_line import write_text

FILE = "augmented_component.toml"


def component_of(test: ComponentTest, found: Fit) -> Component:
    """The component of a fit, driven by its own input again, its effects in it; what lies in the channel stays there."""
    joined = test.component.with_effects(*(e() for e in found.model.effects if e.part == "device"))
    model: Any = found.model
    values = model.values(found.shared) | {n: found.runs[0].duration for n in joined.values if n.endswith(".duration")}
    return joined.with_values(**{n: values.get(n, v) for n, v in joined.values.items()})


def write_component(test: ComponentTest, found: Fit, folder: Path, source: str, specification: str, errors: Mapping[str, float]) -> tuple[str, str]:
    """Write the fitted component and its FMU into the folder; their names there. specification is what --component named."""
    made = component_of(test, found)
    file, _, title = specification.rpartition(":")
    own = file.endswith(".py")
    parameters = {n: (value, errors.get(n), made.table[n].unit) for n, value in made.values.items()}
    text = value_file(title if own else made.title, parameters, "Component as fitted to recordings, with what it lacked", source,
                      [type(e) for e in made.effects], component_file=file if own else None)  # fmt: skip
    write_text(folder / FILE, text)
    made.name = FILE.removesuffix(".toml")
    return FILE, Path(build(made, folder).path).name


def own_modes(component: Component) -> list[dict[str, Any]]:
    """Frequency [Hz] and damping ratio of each mode of the component at rest; real roots have frequency 0."""
    roots = np.linalg.eigvals(linearise(component).A) if component.states else np.zeros(0)
    return [{"eigenvalue": [complex(x)], "frequency": [float(x.imag / (2 * np.pi))], "damping_ratio": [float(-x.real / abs(x)) if x.imag else None]}
            for x in sorted(roots[roots.imag >= 0], key=lambda x: (abs(x), x.real))]  # fmt: skip
