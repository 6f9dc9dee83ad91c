"""Effects: physical phenomena that add to named quantities of a component. The base, and the laws of mechanics."""

from fmus.effects.effect import Effect, adds_to
from fmus.effects.library import effects_in, load_folder

__all__ = ["Effect", "adds_to", "effects_in", "load_folder"]
