"""Generic mechanisms of a test bench: force or torque is the input, displacement or angle the output.

    from fmus.mechanisms import mechanisms
    mechanisms.load("pendulum")

COMPONENTS holds every component that a file of this folder defines; `mechanisms` holds the value files.
"""

from pathlib import Path

from fmus.composition.component_folder import components_in
from fmus.composition.value_files import Library
from fmus.mechanisms.driven_joint import DrivenJoint
from fmus.mechanisms.mass_spring_damper import MassSpringDamper
from fmus.mechanisms.pendulum import Pendulum
from fmus.mechanisms.two_mass import TwoMass

COMPONENTS = components_in("fmus.mechanisms")
mechanisms = Library("mechanism", Path(__file__).parent / "values", COMPONENTS)

__all__ = ["COMPONENTS", "DrivenJoint", "MassSpringDamper", "Pendulum", "TwoMass", "mechanisms"]
