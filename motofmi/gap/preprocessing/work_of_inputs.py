"""The work of recorded forces and torques on a component, whose sign shows the sign convention of their sensors.

    W = integral of u dx

A passive component that oscillates dissipates energy, so that each part of a recording in which its stored energy
changes little has W >= 0. The sensor of a test rig often measures the reaction instead, and W < 0. If the sign of W
were accidental, all of n parts would be negative with the probability 2^-n (sign test). The parts have equal lengths of
the path: none is at standstill, where W = 0. Nothing is said of a motion that returns by less than half of its range,
such as that of a weight that is lowered: its stored energy changes.

Source: Willems, Arch. Rational Mech. Anal. 45 (1972) 321-351, for passivity.
"""

import numpy as np
from scipy.integrate import cumulative_trapezoid

from fmus.declaration.component import Component
from motofmi.gap.experiments.state_rates import rates_of_states
from motofmi.gap.preprocessing.one_way import oscillates
from motofmi.recordings.recording import Recording

PARTS = 8  # of a recording: all are negative by chance in 0.4 % of recordings
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
                f"{run.file or run.name}: the work of {effort} is negative in each of {PARTS} parts of the run "
                f"({parts.sum():.3g} J in total), which a passive component does not allow. If the sensor measures the "
                f"reaction, reverse its sign: {run.option(effort)}."
            )
    return notes


def work(run: Recording, effort: str, deflection: str, rate: str) -> np.ndarray:
    """The work (PARTS,) [J] of a recorded effort in parts of a run with equal paths, by the recorded deflection or else
    the rate; zeros where the motion does not return, as its stored energy changes."""
    recorded = deflection in run.columns
    travel = run[deflection] if recorded else cumulative_trapezoid(run[rate], run.time, initial=0.0)
    if not oscillates(travel):
        return np.zeros(PARTS)
    path = np.concatenate([[0.0], np.cumsum(np.abs(np.diff(travel)))])
    edges = np.searchsorted(path, np.linspace(0, path[-1], PARTS + 1))
    return np.diff(cumulative_trapezoid(run[effort], travel, initial=0.0)[edges])


def driven_motion(component: Component) -> dict[str, tuple[str, str]]:
    """Deflection and rate by the input that accelerates them; the deflection is "" where none is a state.

    Inputs that accelerate several states of the unit that belongs to them are left out.
    """
    rest = np.zeros(len(component.states)), np.zeros(len(component.inputs))
    rows, integrals, found = component.table, rates_of_states(component), {}
    with np.errstate(all="ignore"):
        at_rest = component.derivatives(*rest)[0]
        for place, effort in enumerate(component.inputs):
            unit = OF_RATE.get(rows[effort].unit)
            pushed = component.derivatives(rest[0], np.eye(len(rest[1]))[place])[0] - at_rest
            of_unit = [rows[n].unit == unit for n in component.states]
            accelerated = [n for n, x, alike in zip(component.states, pushed, of_unit, strict=True) if x and alike]
            if len(accelerated) == 1:
                rate = accelerated[0]
                found[effort] = (next((n for n, rates in integrals.items() if rate in rates), ""), rate)
    return found
