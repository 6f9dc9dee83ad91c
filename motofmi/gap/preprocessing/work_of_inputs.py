"""The work of recorded forces and torques on a component, whose sign shows the sign convention of their sensors.

    W = integral of u dx

A passive component that moves to and fro dissipates energy, so that each part of a recording in which its stored energy
changes little has W >= 0. The sensor of a test rig often measures the reaction instead, and W < 0. If the sign of W
were accidental, all of n parts would be negative with the probability 2^-n (sign test).

Source: Willems, Arch. Rational Mech. Anal. 45 (1972) 321-351, for passivity.
"""

from itertools import pairwise

import numpy as np

from fmus.declaration.component import Component
from fmus.declaration.units import is_force
from motofmi.gap.preprocessing.one_way import keeps_direction
from motofmi.recordings.recording import Recording

PARTS = 8  # of a recording: all are negative by chance in 0.4 % of recordings
ROUNDING = 1e-9  # of a derivative that is the rate itself
OF_RATE = {"N": "m/s", "N.m": "rad/s"}  # the unit of the rate at which a force or a torque does work


def note_on_signs(component: Component, run: Recording) -> list[str]:
    """A sentence for each recorded force or torque of a component that does negative work in all parts of a run."""
    notes = []
    for effort, (deflection, rate) in driven_motion(component).items():
        if effort not in run.columns or not {deflection, rate} & set(run.columns):
            continue
        parts = work(run, effort, deflection, rate)
        if np.all(parts < 0):
            notes.append(
                f"{run.file or run.name}: {effort} does negative work in each of {PARTS} parts of the run (together "
                f"{parts.sum():.3g} J), as on no passive component. If its sensor measures the reaction, reverse its "
                f'sign: --map "COLUMN=-{effort}".'
            )
    return notes


def work(run: Recording, effort: str, deflection: str, rate: str) -> np.ndarray:
    """The work (PARTS,) [J] of a recorded effort in equal parts of a run, by the recorded deflection or else the rate;
    zeros where the motion keeps its direction."""
    step = np.diff(run.time)
    motion = np.diff(run[deflection]) if deflection in run.columns else _mean(run[rate]) * step
    if keeps_direction(np.concatenate([[0.0], np.cumsum(motion)])):
        return np.zeros(PARTS)
    increments = _mean(run[effort]) * motion
    edges = np.linspace(0, len(increments), PARTS + 1).astype(int)
    return np.array([np.sum(increments[first:last]) for first, last in pairwise(edges)])


def driven_motion(component: Component) -> dict[str, tuple[str, str]]:
    """Deflection and rate by the input that accelerates them; the deflection is "" where none is a state.

    Inputs that accelerate several states of the unit that belongs to them are left out.
    """
    rest = np.zeros(len(component.states)), np.zeros(len(component.inputs))
    rows = component.table
    found = {}
    with np.errstate(all="ignore"):
        at_rest = component.derivatives(*rest)[0]
        for place, effort in enumerate(component.inputs):
            unit = rows[effort].unit
            if not is_force(unit) or unit not in OF_RATE:
                continue
            pushed = component.derivatives(rest[0], np.eye(len(rest[1]))[place])[0] - at_rest
            of_unit = [rows[n].unit == OF_RATE[unit] for n in component.states]
            accelerated = [n for n, x, alike in zip(component.states, pushed, of_unit, strict=True) if x and alike]
            if len(accelerated) == 1:
                found[effort] = (_integral(component, accelerated[0], at_rest), accelerated[0])
    return found


def _integral(component: Component, rate: str, at_rest: np.ndarray) -> str:
    """The state whose derivative is a rate; "" where there is none."""
    moving = np.array([float(name == rate) for name in component.states])
    change = component.derivatives(moving, np.zeros(len(component.inputs)))[0] - at_rest
    return next((n for n, x in zip(component.states, change, strict=True) if abs(x - 1.0) < ROUNDING), "")


def _mean(values: np.ndarray) -> np.ndarray:
    """The mean of neighbours (n - 1,)."""
    return (values[1:] + values[:-1]) / 2
