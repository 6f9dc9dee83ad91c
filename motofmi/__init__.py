"""Motorcycles, riders and steering dampers as FMUs: co-simulated, linearised, compared by their modes, and
completed from recordings.

    import motofmi as mf

    bike, rider = mf.vehicle("sharp_1971"), mf.rider("mean_2011")
    modes = mf.modes(bike, rider)
    modes.unstable["weave"]

A name is imported when it is first used, so that `import motofmi` is fast and has no side effects.
"""

from typing import TYPE_CHECKING

from fmus.support.public_names import on_use

# The public names by the module that defines them.
NAMES = {
    "fmus": (
        "Component", "Effect", "Element", "InputError", "StateSpace", "System", "adds_to", "calculated", "input", "linearise",
        "local", "output", "parameter", "state",
    ),
    "fmus.interfaces.handlebar": ("HandlebarDevice",),
    "motofmi.schemas": ("schema",),
    "motofmi.version": ("__version__",),
    "motofmi.workflows.batch.batch": ("batch",),
    "motofmi.workflows.build": ("build",),
    "motofmi.workflows.check": ("check",),
    "motofmi.workflows.components": ("component", "damper", "mechanism", "rider", "vehicle"),
    "motofmi.workflows.cosimulation": ("cosimulate", "simulate"),
    "motofmi.workflows.device": ("transfer_functions",),
    "motofmi.workflows.explore": ("explore",),
    "motofmi.workflows.frf": ("estimate_frf",),
    "motofmi.workflows.gap.find_gap": ("find_gap",),
    "motofmi.workflows.gap.plan_experiment": ("plan_experiment",),
    "motofmi.workflows.identify": ("identify",),
    "motofmi.workflows.listing": ("catalogue",),
    "motofmi.workflows.modes": ("compare_modes", "modes"),
    "motofmi.workflows.roll_frf": ("estimate_roll_frf",),
    "motofmi.workflows.scenarios": ("host",),
    "motofmi.workflows.simulated_recording": ("simulate_steer_test",),
    "motofmi.workflows.sweep.result": ("open_study",),
    "motofmi.workflows.sweep.sweep": ("sweep",),
    "motofmi.workflows.tour": ("tour",),
    "motofmi.workflows.trim": ("trim",),
}  # fmt: skip
__all__, _get, _dir = on_use(__name__, NAMES)

if TYPE_CHECKING:  # the same names for editors and type checkers
    from fmus import Component as Component
    from fmus import Effect as Effect
    from fmus import Element as Element
    from fmus import InputError as InputError
    from fmus import StateSpace as StateSpace
    from fmus import System as System
    from fmus import adds_to as adds_to
    from fmus import calculated as calculated
    from fmus import input as input
    from fmus import linearise as linearise
    from fmus import local as local
    from fmus import output as output
    from fmus import parameter as parameter
    from fmus import state as state
    from fmus.interfaces.handlebar import HandlebarDevice as HandlebarDevice
    from motofmi.schemas import schema as schema
    from motofmi.version import __version__ as __version__
    from motofmi.workflows.batch.batch import batch as batch
    from motofmi.workflows.build import build as build
    from motofmi.workflows.check import check as check
    from motofmi.workflows.components import component as component
    from motofmi.workflows.components import damper as damper
    from motofmi.workflows.components import mechanism as mechanism
    from motofmi.workflows.components import rider as rider
    from motofmi.workflows.components import vehicle as vehicle
    from motofmi.workflows.cosimulation import cosimulate as cosimulate
    from motofmi.workflows.cosimulation import simulate as simulate
    from motofmi.workflows.device import transfer_functions as transfer_functions
    from motofmi.workflows.explore import explore as explore
    from motofmi.workflows.frf import estimate_frf as estimate_frf
    from motofmi.workflows.gap.find_gap import find_gap as find_gap
    from motofmi.workflows.gap.plan_experiment import plan_experiment as plan_experiment
    from motofmi.workflows.identify import identify as identify
    from motofmi.workflows.listing import catalogue as catalogue
    from motofmi.workflows.modes import compare_modes as compare_modes
    from motofmi.workflows.modes import modes as modes
    from motofmi.workflows.roll_frf import estimate_roll_frf as estimate_roll_frf
    from motofmi.workflows.scenarios import host as host
    from motofmi.workflows.simulated_recording import simulate_steer_test as simulate_steer_test
    from motofmi.workflows.sweep.result import open_study as open_study
    from motofmi.workflows.sweep.sweep import sweep as sweep
    from motofmi.workflows.tour import tour as tour
    from motofmi.workflows.trim import trim as trim
else:
    __getattr__, __dir__ = _get, _dir
