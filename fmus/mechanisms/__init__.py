"""Generic mechanisms: what a lab puts on a bench before a vehicle. Driven by a force or torque, they answer with motion.

    from fmus.mechanisms import mechanisms
    mechanisms.load("pendulum")
"""

from pathlib import Path

from fmus.library import Library
from fmus.mechanisms.driven_joint import DrivenJoint
from fmus.mechanisms.mass_spring_damper import MassSpringDamper
from fmus.mechanisms.pendulum import Pendulum
from fmus.mechanisms.two_mass import TwoMass

COMPONENTS = {c.__name__: c for c in (MassSpringDamper, DrivenJoint, Pendulum, TwoMass)}
mechanisms = Library("mechanism", Path(__file__).parent / "values", COMPONENTS)

__all__ = ["COMPONENTS", "DrivenJoint", "MassSpringDamper", "Pendulum", "TwoMass", "mechanisms"]
