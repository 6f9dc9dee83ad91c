"""Torques in the steering head beside the vehicle's own damper: friction, a spring, a damper."""

from fmus.effects import damping, stiffness


class SteeringFriction(damping.CoulombFriction):
    """Dry friction in the steering head."""

    element = "steering_head"


class SoftSteeringFriction(damping.SoftFriction):
    """Dry friction in the steering head whose transition through zero rate is wide."""

    element = "steering_head"


class SteeringStribeck(damping.StribeckFriction):
    """Dry friction in the steering head that is larger near standstill."""

    element = "steering_head"


class SteerStiffness(stiffness.AddedSpring):
    """A spring between front and rear frame, such as cables."""

    family, element = "steer_stiffness", "steering_head"


class SteerDamping(damping.AddedDamper):
    """A viscous damper between front and rear frame, such as bearings."""

    family, element = "steer_damping", "steering_head"
