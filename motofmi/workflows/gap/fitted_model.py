"""A model as fitted: the component with the effects found, and its value file, which every command accepts."""

import tomllib
from collections.abc import Sequence
from dataclasses import dataclass

from fmus.composition.value_files import component_from
from fmus.declaration.component import Component
from fmus.effects import Effect
from motofmi.workflows import components


@dataclass(frozen=True)
class FittedModel:
    """The component as fitted, with the effects found, and the name and the text of its value file."""

    component: Component
    file: str
    text: str


def of_value_file(file: str, text: str, own_effects: Sequence[type[Effect]] = ()) -> FittedModel:
    """The model that the text of a value file describes, with shipped effects and a user's own."""
    contents = {key: value for key, value in tomllib.loads(text).items() if key != "effects_folder"}
    effects = [*components.EFFECTS.get(contents["component"], ()), *own_effects]
    return FittedModel(
        component_from(contents, components.COMPONENTS, file.removesuffix(".toml"), file, effects), file, text
    )
