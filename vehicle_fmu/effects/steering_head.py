"""What acts in the steering head besides the vehicle's own damper: friction, a spring, a damper."""

from fmus.effects import damping, stiffness


class SteeringFriction(damping.CoulombFriction):
    """Dry friction in the steering head."""

    family, element = "steering_friction", "head"


class SoftSteeringFriction(damping.SoftFriction):
    """Dry friction in the steering head that comes in over a wider range of rates."""

    family, element = "steering_friction", "head"


class SteeringStribeck(damping.StribeckFriction):
    """Dry friction in the steering head that is larger near standstill."""

    family, element = "steering_friction", "head"


class SteerStiffness(stiffness.AddedSpring):
    """A spring between front and rear frame, as of cables."""

    family, element = "steer_stiffness", "head"


class SteerDamping(damping.AddedDamper):
    """A viscous damper between front and rear frame, as of bearings."""

    family, element = "steer_damping", "head"
