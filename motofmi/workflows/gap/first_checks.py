"""Checks of what a component's gap is searched in, before anything is fitted: each refusal names the option that fixes it."""

import hashlib
from collections.abc import Sequence
from difflib import SequenceMatcher

import numpy as np

from fmus.declaration.component import Component
from fmus.declaration.units import unit
from fmus.support.errors import InputError
from motofmi.gap.experiments.experiment import with_imposed_state
from motofmi.recordings.reading import UNUSED
from motofmi.recordings.recording import Recording

ELECTRICAL = ("A", "V")  # what an actuator's current or a sensor's voltage is recorded in


def require_distinct(fitted: Sequence[Recording], validation: Sequence[Recording]) -> None:
    """Raises InputError for a validation run with the same values as a fitted run."""
    known = {_hash(run): run for run in fitted}
    for run in validation:
        if same := known.get(_hash(run)):
            raise InputError(
                f"validation run {run.file or run.name} has the values of the fitted run {same.file or same.name}: it "
                "confirms nothing; give another run with --holdout FILE, or none"
            )


def require_inputs(
    component: Component, recordings: Sequence[Recording], columns: Sequence[str], imposed: str = ""
) -> list[str]:
    """Notes on columns that nothing uses.

    Raises InputError where one of them may be an input of the component that no column is: it has the input's
    dimension, an electrical unit or none.
    """
    used = {*component.inputs, *component.outputs, *([imposed] if imposed else [])} & set(columns)
    used |= set(component.states) & set(columns) if imposed else set()
    first = recordings[0]
    spare = {n: first.units[n] for n in first.columns if n not in used} | dict.fromkeys(first.unread, "")
    missing = [n for n in component.inputs if n not in columns]
    for name in missing:
        wanted = component.table[name].unit
        likely = [n for n, given in spare.items() if _may_be(given, wanted)]
        if likely:
            best = max(likely, key=lambda n: (_same(spare[n], wanted), SequenceMatcher(None, n, name).ratio()))
            same = _same(spare[best], wanted)
            scaled = "" if same else f" (its numbers are then read in {wanted}: scale them in the file first)"
            stated = "" if same else f" [{wanted}]"
            raise InputError(
                f"{first.file or first.name}: no column is the input {name} [{wanted}] of {component.title}, and "
                f"nothing uses {', '.join(repr(n) for n in likely)}: add --map \"{best}={name}{stated}\"{scaled}, or --map "
                f"\"{best}={UNUSED}\" if {name} is zero in these runs"
            )
    notes = [f"{first.file or first.name}: nothing uses the column{'s' * (len(spare) > 1)} {', '.join(spare)}."] if spare else []
    zero = [n for n in missing if not imposed]
    return notes + [f"No column is the input {n}: it is taken as zero." for n in zero]


def require_start(component: Component, imposed: str = "") -> None:
    """Raises InputError where the equations give no finite numbers at the component's own values."""
    seen = with_imposed_state(component, imposed, component.inputs[0], []) if imposed else component
    try:
        with np.errstate(all="ignore"):
            rates, outputs = seen.derivatives(np.zeros(len(seen.states)), np.zeros(len(seen.inputs)))
        fine = bool(np.all(np.isfinite(rates)) and np.all(np.isfinite(outputs)))
    except ZeroDivisionError:
        fine = False
    zeros = [n for n in component.rows("parameter") if component.values[n] == 0]
    if not fine:
        names = ", ".join(zeros) or "none is 0"
        raise InputError(
            f"{component.title} has no finite motion at rest with its own values (parameters that are 0: {names}); give "
            "them values above 0, as in parameter(..., start=1.0), or --component FILE.toml"
        )
    rows = component.rows("parameter")
    if not any(row.tunable and component.values[n] for n, row in rows.items()):
        raise InputError(
            f"every parameter of {component.title} is 0 ({', '.join(rows)}), and a fit starts from values that are not "
            "0: give them, as in parameter(..., start=1.0), or --component FILE.toml"
        )


def _hash(run: Recording) -> str:
    """Of the values of all columns by name, whatever the file and its first time stamp."""
    made = hashlib.sha256(np.round(run.time - run.time[0], 9).tobytes())
    for name in sorted(run.columns):
        made.update(name.encode() + np.ascontiguousarray(run[name]).tobytes())
    return made.hexdigest()


def _same(given: str, wanted: str) -> bool:
    return bool(given) and unit(given).exponents == unit(wanted).exponents


def _may_be(given: str, wanted: str) -> bool:
    return not given or _same(given, wanted) or any(_same(given, each) for each in ELECTRICAL)
