"""The gap workflow on any component: recordings of its inputs and outputs, whatever drove it."""

import argparse
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from fmus.component import Component
from fmus.effects import load_folder
from fmus.errors import InputError, MissingToolError
from fmus.progress import track
from identification.gap.data.sampled import Sampled, excited, prepare_sampled
from identification.gap.naming.any_component import MOST_MISSED, Investigation, investigate
from identification.gap.naming.common_factor import forceful
from identification.gap.naming.decide import Verdict
from identification.gap.naming.fitted import parameters_of, zeros_of
from identification.gap.proposing.next_test import next_experiment
from identification.gap.proposing.scaled_runs import scaled_runs
from identification.gap.reporting.sampled_places import cells
from identification.gap.reporting.verdict import as_result
from identification.gap.stands.component_test import ComponentTest, component_test
from identification.gap.stands.sensor_zero import zero_parameter
from identification.recordings import Recording, read_recording, read_rig
from scenarios import names
from scenarios.augmented_component import FILE, component_of, own_modes, write_component
from scenarios.component_report import modes_at_rest, write_report
from scenarios.recordings_on_the_command_line import mapping_of
from scenarios.verdict_file import write_verdict, writing_so_far

FLEXIBLE = ("The noise is not known (no repeats, no noise in rig.json): it is what a flexible model leaves of the residuals, "
            "so a reduced chi-square of 1 means as good as that model.")  # fmt: skip
NONE_IS_WEAK = "none means that nothing of the library improves the model; what even a flexible model cannot explain counts as noise."
OTHER_UNIT = ("All that has force or mass in its unit came out {:.3g} times as large as it started: is a column's unit wrong (deg for rad, kN for N, "
              "mm for m)? Nothing is named. If all units are right, start from values nearer to the component: --component FILE.toml.")  # fmt: skip
FAR = 1e3  # factor by which a fitted value may differ from where it started
CERTAIN = 4.0  # errors by which a sensor's zero is called off
CLOSED = 0.5  # share of the held-out gap that must close


def run_on_component(arguments: argparse.Namespace) -> dict[str, Any]:
    """The result of `motofmi gap FILE.csv --component NAME`, with everything that it names written into --out."""
    folder = Path(arguments.out)
    component = component_named(arguments.component)
    more = load_folder(arguments.effects) if arguments.effects else []
    recordings, held = (read(files, component, arguments.map) for files in (arguments.files, arguments.holdout))
    test = component_test(component, _common_columns([*recordings, *held]), arguments.impose or "", arguments.free)
    _usable([*recordings, *held], test)
    runs = [prepare_sampled(r, test) for r in recordings]
    notes = [note for r in recordings for note in r.warnings] + [note for r in runs for note in r.notes]
    if not excited(runs):
        test, anchor = anchored(test)
        runs = [replace(run, test=test) for run in runs]
        notes += [f"No input is recorded or it is zero: only ratios of the parameters show, with {anchor} as given."] if anchor else []
    given = read_rig(arguments.rig or Path(arguments.files[0]).parent).get("noise", {})
    found = investigate(test, runs, more, given, writing_so_far(folder, lambda verdict: result_of(verdict, [])), held)
    result = result_of(found.verdict, notes)
    result["limitations"] += limitations_of(found, result, component, bool(held))
    write_verdict(result, folder)
    result["next_experiment"] = next_experiment(found.verdict, scaled_runs)
    _add(found, result, arguments, folder)
    result["report"] = write_report(found.verdict, result, folder, modes_at_rest(result))
    write_verdict(result, folder)
    return result


def anchored(test: ComponentTest) -> tuple[ComponentTest, str]:
    """The test of which one parameter with force or mass in its unit keeps its value, so that ratios say the others; and its name."""
    free = [f.name for f in test.free]
    scaled = forceful(test.component)
    kept = [n for n in scaled if n not in free]
    if kept or not scaled:
        return test, " and ".join(kept)
    return replace(test, free=tuple(f for f in test.free if f.name != scaled[0])), scaled[0]


def component_named(spec: str) -> Component:
    """The component that a NAME, a .toml or PATH.py:CLASS names."""
    return names.component_class(spec)() if ".py:" in spec else names.component(spec)


def read(files: Sequence[str], component: Component, mapping: Sequence[str]) -> list[Recording]:
    """The recordings, their columns in the units of the component's variables."""
    mapped = mapping_of(mapping)
    quantities = {"time": "s"} | {n: row.unit for n, row in component.table.items() if row.role in ("input", "output") or row.role == "state"}
    return [read_recording(path, mapped or None, quantities=quantities) for path in track(files, "reading")]


def _common_columns(recordings: Sequence[Recording]) -> list[str]:
    return [n for n in recordings[0].columns if all(n in r.columns for r in recordings)]


def _usable(recordings: Sequence[Recording], test: ComponentTest) -> None:
    """Raises InputError where a measured channel was clipped: that looks like a physical effect."""
    for recording in recordings:
        for warning in recording.warnings:
            if "clipped" in warning and warning.split()[0] in (*test.outputs, test.imposed):
                raise InputError(f"{recording.name}: {warning}; a clipped channel looks like a physical effect, so nothing can be named")


def result_of(verdict: Verdict, notes: Sequence[str]) -> dict[str, Any]:
    """What `verdict.json` says of a verdict on sampled runs."""
    run: Sampled = verdict.best.runs[0]
    unit = run.recording.units[run.test.outputs[0]]
    result = as_result(verdict, unit, run.noise_source or "flexible_model", cells)
    result["limitations"] = [*dict.fromkeys(notes), *result["limitations"]]
    return result


def limitations_of(found: Investigation, result: dict[str, Any], component: Component, held: bool) -> list[str]:
    """What an investigation of a component does not know, in sentences."""
    sentences = []
    if result["noise_source"] == "flexible_model":
        sentences.append(FLEXIBLE)
        if result["verdict"] == "none":
            sentences.append(NONE_IS_WEAK)
    if found.factor != 1.0:
        sentences.append(OTHER_UNIT.format(found.factor))
    sentences += [f"{n} keeps its value: at the frequencies of these runs it answers as a stiffness does." for n in found.kept]
    if found.missed > MOST_MISSED:
        sentences.append(f"{100 * found.missed:.0f} % of the measured motion is missed by the best model: too much to be called noise.")
    best = found.verdict.best
    rows = best.model.component.table
    for name, (value, _, _) in parameters_of(best).items():
        row, start = rows[name], abs(component.values.get(name, 0.0))
        if name in best.model.own and name in [best.model.own[i] for i in best.model.sizes] and np.isfinite(row.max) and value >= row.max:
            sentences.append(f"{name} ran to its bound {row.max:g} {row.unit}: the effect does not fit well, or a column's unit is wrong.")
        if name in best.model.base and start and not 1 / FAR < abs(value) / start < FAR:
            sentences.append(f"{name} came out at {value:.3g} {row.unit}, far from its start {start:.3g}: is a column's unit wrong?")
    for run, zeros in zip(best.runs, zeros_of(best), strict=True):
        for name in found.test.zeros:
            value, error = zeros[zero_parameter(name)]
            if abs(value) > CERTAIN * error:
                sentences.append(f"{value:.2g} {run.recording.units[name]} more than the {name} recorded in {run.name} acts (error {error:.1g}): "
                                 "its sensor's zero is off, or something pushes besides.")  # fmt: skip
    gap = result["gap"]
    if held and result["verdict"] == "named" and gap["holdout_after"] - 1 > CLOSED * (gap["holdout_before"] - 1):
        sentences.append("On the held-out run the effect closes less than half of the gap: what was named may belong to the fitted runs alone.")
    if not held:
        sentences.append("No held-out run: the verdict is not checked on data that was not used.")
    return sentences


def _add(found: Investigation, result: dict[str, Any], arguments: argparse.Namespace, folder: Path) -> None:
    """The component with what was found, its FMU, and its modes before and after."""
    verdict = found.verdict
    errors = {n: error for n, (_, error, _) in parameters_of(verdict.best).items()}
    source = f"Fitted to {', '.join(r.name for r in verdict.best.runs)}"
    try:
        result["model"], result["fmu"] = write_component(found.test, verdict.best, folder, source, arguments.component, errors)
    except MissingToolError as error:
        result["model"] = FILE
        result["limitations"].append(f"No FMU was built: {error}")
    result["modes"] = {label: own_modes(component_of(found.test, f)) for label, f in (("before", verdict.base), ("after", verdict.best))}
