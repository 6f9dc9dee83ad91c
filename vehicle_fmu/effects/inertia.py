"""Inertia that the base lacks: of the vehicle about the roll axis, of the front assembly about the steer axis.

They add to the diagonal of the mass matrix and apply to every vehicle with roll rate and steer rate as states.
"""

from fmus import Effect, adds_to, parameter


class RollInertia(Effect):
    """The roll inertia of the vehicle differs from that of the base."""

    family, form = "roll_inertia", "inertia"
    inertia = parameter("kg.m2", "Roll inertia beyond the base's", symbol=r"\Delta I_x", min=-100, max=1000, start=1.0)

    @adds_to("mass(roll_rate, roll_rate)")
    def rolls(self, v, m):
        return v.inertia


class AddedInertia(Effect):
    """The front assembly has more inertia about the steer axis."""

    family, form = "added_inertia", "inertia"
    inertia = parameter(
        "kg.m2", "Inertia about the steer axis beyond the base's", symbol=r"\Delta I_s", min=0, max=5, start=0.01
    )

    @adds_to("mass(steer_rate, steer_rate)")
    def turns(self, v, m):
        return v.inertia
