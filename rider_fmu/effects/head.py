"""What acts between handlebar and frame besides the passive rider: friction, springs, reflexes."""

from typing import ClassVar

from fmus import Effect, adds_to, parameter, state
from fmus.effects import damping, memory, stiffness


class SteeringFriction(damping.CoulombFriction):
    """Dry friction in the steering head."""

    element = "head"


class SoftSteeringFriction(damping.SoftFriction):
    """Dry friction in the steering head that comes in over a wider range of rates."""

    element = "head"


class SteeringStribeck(damping.StribeckFriction):
    """Dry friction in the steering head that is larger near standstill."""

    element = "head"


class SteeringBristles(memory.DahlHysteresis):
    """Dry friction in the steering head that gives way like bristles before it slides."""

    family, form, element = "coulomb_friction", "bristles", "head"


class SteerStiffness(stiffness.AddedSpring):
    """A spring between handlebar and frame, as of cables."""

    family, element = "steer_stiffness", "head"


class SteerDamping(damping.AddedDamper):
    """A viscous damper between handlebar and frame, as of bearings."""

    family, element = "steer_damping", "head"


class Reflex(Effect):
    """The rider answers the steer angle with a delayed torque."""

    family, form, element = "reflex", "delayed_angle", "head"
    gain = parameter("N.m/rad", "Torque per delayed steer angle, against it", symbol="k_r", min=0, start=10.0)
    delay = parameter("s", "Delay of nerves and muscles", symbol=r"\tau", min=0.01, max=0.5, start=0.1)
    lags = ("delay",)
    delayed: ClassVar = {"late_angle": ("deflection", "delay")}
    starts: ClassVar = {"delay": (0.03, 0.06, 0.1, 0.15, 0.22)}

    @adds_to("force")
    def answer(self, v, m):
        return v.gain * v.late_angle


class MuscleReflex(Reflex):
    """The rider answers the steer angle with a delayed torque that his muscles build up gradually."""

    form = "muscle"
    muscle_time = parameter("s", "Time constant of the muscles", symbol="t_m", min=1e-3, max=0.5, start=0.04)
    activation = state("rad", "Delayed angle as the muscles follow it", symbol="a")
    starts: ClassVar = {"delay": (0.03, 0.06, 0.1, 0.15), "muscle_time": (0.03, 0.1)}

    @adds_to("der(activation)")
    def follow(self, v, m):
        return (v.late_angle - v.activation) / v.muscle_time

    @adds_to("force")
    def answer(self, v, m):
        return v.gain * v.activation
