"""Torques between handlebar and frame beside the passive rider: friction, springs, dampers, reflexes."""

from typing import ClassVar

from fmus import Effect, adds_to, parameter, state
from fmus.effects import damping, hysteresis, stiffness


class SteeringFriction(damping.CoulombFriction):
    """Dry friction in the steering head."""

    element = "steering_head"


class SoftSteeringFriction(damping.SoftFriction):
    """Dry friction in the steering head whose transition through zero rate is wide."""

    element = "steering_head"


class SteeringStribeck(damping.StribeckFriction):
    """Dry friction in the steering head that is larger near standstill."""

    element = "steering_head"


class SteeringBristles(hysteresis.DahlHysteresis):
    """Dry friction in the steering head with elastic presliding (bristles)."""

    family, form, element = "coulomb_friction", "bristles", "steering_head"


class SteerStiffness(stiffness.AddedSpring):
    """A spring between handlebar and frame, such as cables."""

    family, element = "steer_stiffness", "steering_head"


class SteerDamping(damping.AddedDamper):
    """A viscous damper between handlebar and frame, such as bearings."""

    family, element = "steer_damping", "steering_head"


class Reflex(Effect):
    """The rider reacts to the steer angle with a delayed torque."""

    family, form, element = "reflex", "delayed_angle", "steering_head"
    gain = parameter("N.m/rad", "Torque per delayed steer angle, against it", symbol="k_r", min=0, start=10.0)
    delay = parameter("s", "Delay of nerves and muscles", symbol=r"\tau", min=0.01, max=0.5, start=0.1)
    lags = ("delay",)
    delayed: ClassVar = {"late_angle": ("deflection", "delay")}
    starts: ClassVar = {"delay": (0.03, 0.06, 0.1, 0.15, 0.22)}

    @adds_to("force")
    def reaction(self, v, m):
        return v.gain * v.late_angle


class MuscleReflex(Reflex):
    """The rider reacts to the steer angle with a delayed torque that the muscles build up with a time constant."""

    form = "muscle"
    muscle_time = parameter("s", "Time constant of the muscles", symbol="t_m", min=1e-3, max=0.5, start=0.04)
    activation = state("rad", "Delayed angle as the muscles follow it", symbol="a")
    starts: ClassVar = {"delay": (0.03, 0.06, 0.1, 0.15), "muscle_time": (0.03, 0.1)}

    @adds_to("der(activation)")
    def follow(self, v, m):
        return (v.late_angle - v.activation) / v.muscle_time

    @adds_to("force")
    def reaction(self, v, m):
        return v.gain * v.activation
