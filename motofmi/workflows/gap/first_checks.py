"""Checks of a component and its recordings before anything is fitted; every error message names the option to
correct."""

import hashlib
from collections.abc import Collection, Mapping, Sequence
from difflib import SequenceMatcher

import numpy as np

from fmus.declaration.component import Component
from fmus.declaration.units import unit
from fmus.support.errors import InputError
from motofmi.gap.experiments.experiment import with_imposed_state
from motofmi.gap.preprocessing.one_way import oscillates
from motofmi.recordings.reading import UNUSED
from motofmi.recordings.recording import Recording

ELECTRICAL_UNITS = ("A", "V")  # of an actuator's current or a sensor's voltage, recorded in place of force or motion


def require_distinct(fitted: Sequence[Recording], validation: Sequence[Recording]) -> None:
    """Raises InputError for a validation run with the same values as a fitted run."""
    known = {_hash(run): run for run in fitted}
    for run in validation:
        if same := known.get(_hash(run)):
            raise InputError(
                f"validation run {run.file or run.name} has the values of the fitted run "
                f"{same.file or same.name}: give another run with --holdout FILE, or none"
            )


def require_inputs(
    component: Component, recordings: Sequence[Recording], columns: Sequence[str], imposed: str = ""
) -> list[str]:
    """Notes on columns that are not used, and on inputs without a column.

    Raises InputError if an input has no column and an unused column may hold it: a column with the dimension of the
    input, with an electrical unit, or without a unit.
    """
    used = {*component.inputs, *component.outputs, *([imposed] if imposed else [])} & set(columns)
    used |= set(component.states) & set(columns) if imposed else set()
    first = recordings[0]
    spare = _spare(first, used)
    missing = [n for n in component.inputs if n not in columns]
    for name in missing:
        wanted = component.table[name].unit
        if likely := _likely(spare, wanted):
            best = max(likely, key=lambda n: (_same_dimension(spare[n], wanted),
                                              SequenceMatcher(None, n, name).ratio()))
            same = _same_dimension(spare[best], wanted)
            scaled = "" if same else f" (its numbers are then read in {wanted}: scale them in the file first)"
            stated = "" if same else f" [{wanted}]"
            raise InputError(
                f"{first.file or first.name}: no column is the input {name} [{wanted}] of {component.title}, but these "
                f"columns are not used: {', '.join(repr(n) for n in likely)}; add --map "
                f"\"{best}={name}{stated}\"{scaled}, or --map \"{best}={UNUSED}\" if {name} is zero in these runs"
            )
    notes = [f"{first.file or first.name}: unused columns: {', '.join(spare)}."] if spare else []
    zero = [n for n in missing if not imposed]
    return notes + [f"No column is the input {n}: it is taken as zero." for n in zero]


def require_motion(
    component: Component, recordings: Sequence[Recording], columns: Sequence[str], imposed: str = ""
) -> None:
    """Raises InputError if no output, or the imposed state, has a column, and a column that is not used may hold it."""
    wanted = [imposed] if imposed else list(component.outputs)
    if imposed not in ("", *component.states) or set(wanted) & set(columns):
        return
    first, units = recordings[0], {n: component.table[n].unit for n in wanted}
    spare = _spare(first, set(component.inputs) & set(columns))
    likely = list(dict.fromkeys(n for each in units.values() for n in _likely(spare, each)))
    if likely:
        fitting = {n: [each for each in likely if _same_dimension(spare[each], u)] for n, u in units.items()}
        name = next((n for n in units if fitting[n]), wanted[0])  # a heading states the unit of one of them
        candidates, unit_of_it = fitting[name] or likely, units[name]
        what = f"the imposed {imposed}" if imposed else f"an output of {component.title}"
        which = candidates[0] if len(candidates) == 1 else "COLUMN"
        option = f'--map "{which}={name}"'
        if not fitting[name]:
            option = f'--map "{which}={name} [{unit_of_it}]" with the unit that the file has'
        raise InputError(
            f"{first.file or first.name}: no column is {what} ({', '.join(f'{n} [{u}]' for n, u in units.items())}), "
            f"but these columns are not used: {', '.join(map(repr, likely))}; if one of them is the {name}, add {option}"
        )


def notes_on_degrees(component: Component, recordings: Sequence[Recording]) -> list[str]:
    """A note for every angle, recorded in rad, that swings by more than a revolution to each side: its numbers may be
    degrees.

    A shaft that turns on in one direction swings to no side.
    """
    angles = [n for n in (*component.states, *component.outputs) if component.table[n].unit == "rad"]
    notes = []
    for run in recordings:
        for name in dict.fromkeys(n for n in angles if n in run.columns and n not in run.converted):
            swing = float(np.max(np.abs(run[name] - np.mean(run[name]))))
            if swing > 2 * np.pi and oscillates(run[name]):
                notes.append(
                    f"{run.file or run.name}: {name} swings by {swing:.3g} rad, {swing / (2 * np.pi):.2g} revolutions. "
                    f"If these numbers are degrees, state it: {name} [deg] in the heading, or "
                    f"{run.option(name, 'deg')}."
                )
    return notes


def notes_on_zeros(component: Component, free: Sequence[str]) -> list[str]:
    """A note on the parameters that keep the value 0, as those of an element that the component does not have; none
    where the fitted parameters are given."""
    rows = component.rows("parameter")
    zero = [n for n, row in rows.items() if row.tunable and component.values[n] == 0 and not free]
    return [
        f"{n} is 0 in {component.title} and is not fitted, since a fit starts from values that are not 0. If the "
        "machine has it, give a start value, as in parameter(..., start=1.0), or --component FILE.toml."
        for n in zero
    ]


def require_start(component: Component, imposed: str = "") -> None:
    """Raises InputError unless state derivatives and outputs are finite at rest and a tunable parameter is not 0."""
    seen = with_imposed_state(component, imposed, component.inputs[0], []) if imposed else component
    try:
        with np.errstate(all="ignore"):
            rates, outputs = seen.derivatives(np.zeros(len(seen.states)), np.zeros(len(seen.inputs)))
        fine = bool(np.all(np.isfinite(rates)) and np.all(np.isfinite(outputs)))
    except ZeroDivisionError:
        fine = False
    rows = component.rows("parameter")
    if not fine:
        zeros = ", ".join(n for n in rows if component.values[n] == 0) or "none"
        raise InputError(
            f"the equations of {component.title} give no finite numbers at rest with its own values (parameters that "
            f"are 0: {zeros}); give values above 0, as in parameter(..., start=1.0), or --component FILE.toml"
        )
    if not any(row.tunable and component.values[n] for n, row in rows.items()):
        raise InputError(
            f"every parameter of {component.title} is 0 ({', '.join(rows)}), but a fit starts from values that are not "
            "0: give start values, as in parameter(..., start=1.0), or --component FILE.toml"
        )


def _hash(run: Recording) -> str:
    """Hash of the values of all columns by name, which does not depend on file name and first time stamp."""
    digest = hashlib.sha256(np.round(run.time - run.time[0], 9).tobytes())
    for name in sorted(run.columns):
        digest.update(name.encode() + np.ascontiguousarray(run[name]).tobytes())
    return digest.hexdigest()


def _spare(run: Recording, used: Collection[str]) -> dict[str, str]:
    """The columns that are not used, with their units; "" for one without a unit."""
    return {n: run.units[n] for n in run.columns if n not in used} | dict.fromkeys(run.unread, "")


def _likely(spare: Mapping[str, str], wanted: str) -> list[str]:
    """The spare columns that may hold a quantity of this unit."""
    return [n for n, given in spare.items() if _may_hold(given, wanted)]


def _same_dimension(given: str, wanted: str) -> bool:
    return bool(given) and unit(given).exponents == unit(wanted).exponents


def _may_hold(given: str, wanted: str) -> bool:
    return not given or _same_dimension(given, wanted) or any(_same_dimension(given, each) for each in ELECTRICAL_UNITS)
