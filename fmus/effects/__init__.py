"""Effects: physical phenomena that add terms to named quantities of a component.

`effect` has the base class, `library` finds effects by folder, `placement` puts laws at the force
elements, states, inputs and outputs of any component. The other files hold one kind of law each.
"""

from fmus.effects.effect import Effect, adds_to
from fmus.effects.library import effects_in, load_folder

__all__ = ["Effect", "adds_to", "effects_in", "load_folder"]
