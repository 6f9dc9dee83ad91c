"""The gap workflow on recorded runs of a whole vehicle: its equations where all states are measured, predictions where they are not."""

import argparse
from collections.abc import Callable, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.figure import Figure

from fmus.component import Component
from fmus.effects import Effect
from fmus.errors import MissingToolError
from fmus.progress import track
from identification.gap.data.weak_form import BAND, BLOCK, WeakRun, prepare_weak
from identification.gap.models.weak_model import WeakModel, accelerated
from identification.gap.naming.decide import Verdict, decide
from identification.gap.naming.fitted import Fit, parameters_of
from identification.gap.naming.fitting import fit
from identification.gap.reporting import predicted_verdict
from identification.gap.reporting.verdict import as_result
from identification.gap.reporting.weak_verdict import cells
from identification.gap.stands.linear_stand import LinearStand
from identification.recordings import Recording, read_recording
from scenarios import names, vehicle_predictions
from scenarios.augmented_vehicle import FILE, fitted_of, write_vehicle
from scenarios.gap_tables import before_and_after, places, verdict_section
from scenarios.recordings_on_the_command_line import mapping_of
from scenarios.report import COLOURS, Report, Section, Table, new_figure
from scenarios.vehicle_test import NOT_LINEAR, uncertain, vehicle_effects
from scenarios.verdict_file import write_verdict, writing_so_far
from vehicle_fmu import GivenMatrices
from vehicle_fmu.given_matrices import COORDINATES, STATES

FEIGNED = 0.2  # of the disturbance's power, gained by a linear effect
KNOWN_TO = 0.1  # of what the entries of given matrices are made of: moments and inertias, which compound many masses and lengths
ALL = "all"  # --free all: nothing is known of the base


def run_on_recordings(arguments: argparse.Namespace) -> dict[str, Any]:
    """The result of `motofmi gap runs.csv --vehicle NAME`, with everything that it names written into --out.

    Where all states are recorded the equations of motion are compared, else predictions from sample to sample.
    """
    folder, vehicle, device = Path(arguments.out), names.vehicle(arguments.vehicle), names.device(arguments.device)
    recordings, held = (_recordings(files, vehicle, arguments.map) for files in (arguments.files, arguments.holdout))
    whole = device is None and all({"speed", *vehicle.states} <= r.columns.keys() for r in [*recordings, *held])
    way = _by_equations if whole else _by_prediction
    verdict, result, figures = way(arguments, vehicle, device, recordings, held)
    if result["gap"]["holdout_after"] is None:
        result["limitations"].append("No held-out run, or none that could be predicted: the verdict is not checked on data that were not used.")
    write_verdict(result, folder)
    try:
        result["model"], result["fmu"] = write_vehicle(vehicle, verdict.best, folder, f"Fitted to {', '.join(r.name for r in recordings)}", arguments.effects)
    except MissingToolError as error:
        result["model"] = FILE
        result["limitations"].append(f"No FMU was built: {error}")
    result["report"] = write_report(verdict, result, figures, folder)
    write_verdict(result, folder)
    return result


Found = tuple[Verdict, dict[str, Any], list[tuple[Figure, str]]]


def _by_equations(arguments: argparse.Namespace, vehicle: Component, device: Component | None, recordings: Sequence[Recording],
                  held: Sequence[Recording]) -> Found:  # fmt: skip
    """Verdict, contents of the file and figures, from the equations of motion of a vehicle that is ridden without a device."""
    del device
    stand = runs_stand(vehicle, arguments.free)
    runs, checked = (weak_runs(each, stand) for each in (recordings, held))
    so_far = writing_so_far(Path(arguments.out), lambda verdict: as_result(verdict, "rad/s2", "flexible_model", cells))
    verdict = verdict_on_runs(stand, runs, checked, runs_effects(vehicle, arguments.effects), so_far)
    result = as_result(verdict, "rad/s2", "flexible_model", cells)
    _with_open(result, verdict, stand)
    result["limitations"] += _limitations([*runs, *checked])
    said = "What the equations of motion leave over frequency: as given, base, with what was found, and the disturbance."
    return verdict, result, [(spectra(verdict), said)]


def _by_prediction(arguments: argparse.Namespace, vehicle: Component, device: Component | None, recordings: Sequence[Recording],
                   held: Sequence[Recording]) -> Found:  # fmt: skip
    """Verdict, contents of the file and figures, from predictions."""
    stand = runs_stand(vehicle, arguments.free, predicted=True) if device is None else vehicle_predictions.ridden_stand(vehicle, device, arguments.free)
    every = vehicle_predictions.predicted_runs([*recordings, *held], stand)
    runs, checked = every[: len(recordings)], every[len(recordings) :]
    library = vehicle_predictions.predictable_effects(vehicle, stand, runs, arguments.effects)
    so_far = writing_so_far(Path(arguments.out), lambda verdict: as_result(verdict, "1", "flexible_model", predicted_verdict.cells))
    verdict = vehicle_predictions.verdict_on_predictions(stand, runs, checked, library, so_far)
    result = as_result(verdict, "1", "flexible_model", predicted_verdict.cells)
    _with_open(result, verdict, stand)
    result["base"] = {n: entry for n, entry in result["base"].items() if n in fitted_of(verdict.best)}
    result["limitations"] += [*_notes(every), *vehicle_predictions.limitations(stand, every)]
    said = "What was measured, and what the predictions err by, over frequency: base, with what was found, and the best prediction that the recording allows."
    return verdict, result, [(vehicle_predictions.spectra(verdict), said)]


def _with_open(result: dict[str, Any], verdict: Verdict, stand: LinearStand) -> None:
    fitted = parameters_of(verdict.best)
    result["base"] |= {n: dict(zip(("value", "standard_error", "unit"), fitted[n], strict=True)) for n in stand.open}


def runs_stand(vehicle: Component, free: Sequence[str] = (), predicted: bool = False) -> LinearStand:
    """The vehicle with what is free in it: entries of given matrices may be any number, known to 10 % of their terms unless they are in `free`.

    What a roll torque does stays as given, as nobody applies one, unless the vehicle is `predicted`: there disturbances do.
    """
    if not isinstance(vehicle, GivenMatrices):
        return LinearStand(vehicle, "", "speed", uncertain(vehicle, free, prefix=""), exact_delays=True)
    open_ = tuple(n for n, value in vehicle.values.items() if (value != 0 and (predicted or not n.endswith("roll_torque"))) or n in free)
    known = {n: (vehicle.values[n], error) for n, error in _entry_errors(vehicle).items() if n in open_ and n not in free and ALL not in free}
    return LinearStand(vehicle, "", "speed", open=open_, measured_effects=known, exact_delays=True)


def _entry_errors(vehicle: GivenMatrices) -> dict[str, float]:
    """To how much the entries of given matrices are known: to KNOWN_TO of the terms of which each is the sum.

        A_ij = sum_k B_ik (M A)_kj,     B_ij = sum_kl B_ik M_kl B_lj,     M = B^-1

    An entry may be a small difference of large terms, each with the error of a moment or an inertia.
    """
    of = vehicle.values
    B = np.array([[of[f"{i}_by_{j}_torque"] for j in COORDINATES] for i in COORDINATES])
    M = np.linalg.inv(B)
    errors = {f"{i}_by_{j}_torque": np.linalg.norm(B[a][:, None] * M * B[:, b]) for a, i in enumerate(COORDINATES) for b, j in enumerate(COORDINATES)}
    for column in (f"{j}_{power}" for j in STATES for power in range(3)):
        A = np.array([of[f"{i}_by_{column}"] for i in COORDINATES])
        errors |= {f"{i}_by_{column}": np.linalg.norm(B[a] * (M @ A)) for a, i in enumerate(COORDINATES)}
    return {n: KNOWN_TO * float(x) for n, x in errors.items()}


def _recordings(files: Sequence[str], vehicle: Component, mapping: Sequence[str] = ()) -> list[Recording]:
    """The recordings, their columns in the units of the vehicle's variables."""
    mapped = mapping_of(mapping)
    quantities = {"time": "s"} | {n: row.unit for n, row in vehicle.rows("input", "state", "output").items()}
    return [read_recording(path, mapped or None, quantities=quantities) for path in track(files, "reading")]


def weak_runs(recordings: Sequence[Recording], stand: LinearStand) -> list[WeakRun]:
    """Recordings with all states of the vehicle in weak form. Raises InputError where too little of one can be used."""
    return [prepare_weak(r, stand.over, accelerated(stand), (*stand.component.states, *(n for n in stand.component.inputs if n in r.columns))) for r in recordings]


def read_runs(files: Sequence[str], stand: LinearStand, mapping: Sequence[str] = ()) -> list[WeakRun]:
    """The recordings of files in weak form."""
    return weak_runs(_recordings(files, stand.component, mapping), stand)


def runs_effects(vehicle: Component, folder: str | None = None) -> list[type[Effect]]:
    """The effects that need no states besides those that are measured."""
    return [e for e in vehicle_effects(vehicle, folder) if vehicle.with_effects(e(exact_delays=True)).states == vehicle.states]


def verdict_on_runs(stand: LinearStand, runs: Sequence[WeakRun], held: Sequence[WeakRun], library: Sequence[type[Effect]],
                    so_far: Callable[[Verdict], None] = lambda verdict: None) -> Verdict:  # fmt: skip
    """The verdict on runs, with the disturbances that are in each.

    Feedback makes the motion depend on the disturbance, which the equations in a band of frequencies feel as a small linear
    effect: one that makes up for less than FEIGNED of the disturbance is not named. Whether inputs are held between samples, or are what they are at each, is decided by what leaves less disturbance.
    """
    model = WeakModel(stand)
    ways = [[[model.with_noise_beside(replace(r, held=way), model.start()) for r in each] for each in (runs, held)] for way in (False, True)]
    ready, checked = min(ways, key=lambda way: sum(np.log(d(r.frequency)).sum() for r in way[0] for d in r.densities))
    verdict = decide(model, ready, library, checked, so_far)
    while doubtful := {c.family for c in (*verdict.effects, *verdict.tied) if c.family not in NOT_LINEAR and c.delta_chi2 < FEIGNED * verdict.base.count}:
        library = [e for e in library if e.family not in doubtful]
        verdict = decide(model, ready, library, checked, so_far)
    return verdict


def as_given(stand: LinearStand, runs: Sequence[WeakRun]) -> Fit:
    """The vehicle as it was given, nothing fitted."""
    model = WeakModel(stand)
    return fit(model, runs, model.start(), frozen=range(len(model.names)))


def _notes(runs: Sequence[Any]) -> list[str]:
    return [note for r in runs for note in (*r.notes, *r.recording.warnings)]


def _limitations(runs: Sequence[WeakRun]) -> list[str]:
    return [*_notes(runs), f"Equations are compared from {BAND[0]:g} to {BAND[1]:g} Hz in blocks of {BLOCK:g} s, without offset and drift.",
            "The noise is what a rich linear and nonlinear regression of the same runs leaves: 1 means as good as that, not as good as the sensors.",
            "Errors of the measured states bias what is fitted, and so does feedback, the more of the motion the disturbances cause instead of a "
            f"recorded excitation: linear effects that gain less than {FEIGNED:g} of the disturbance are therefore not named, and fitted entries are no physical "
            "constants where nothing shakes the vehicle."]  # fmt: skip


def write_report(verdict: Verdict, result: dict[str, Any], figures: Sequence[tuple[Figure, str]], folder: Path) -> str:
    """Write the HTML report into the folder; its name there."""
    found = [(n, f"{v:.5g}", f"{e:.2g}", u) for n, (v, e, u) in fitted_of(verdict.best).items()]
    sections = [
        verdict_section(result, Table(("parameter", "value", "standard error", "unit"), found)),
        Section("Before and after", [], figures, [before_and_after(result)]),
        Section("Where the base model misses", ["Cells that pass a false-discovery rate of 1 %."], [],
                [places(result, "equation or output")]),
    ]  # fmt: skip
    Report("The gap between vehicle and recorded runs", f"Verdict: {result['verdict']}", sections).write(folder / "report.html")
    return "report.html"


def spectra(verdict: Verdict) -> Figure:
    """Measured accelerations over frequency, and what each fit leaves of them, one panel per equation; first run."""
    run: WeakRun = verdict.best.runs[0]
    given = as_given(verdict.base.model.stand, [run])
    figure, axes = new_figure(columns=len(run.rates), width=11.0, sharex=True)
    fits = [(given, COLOURS["changed"], "as given"), (verdict.base, COLOURS["damper"], "base, refitted"), (verdict.best, COLOURS["rider"], "with what was found")]
    for i, (name, ax) in enumerate(zip(run.rates, axes, strict=True)):
        ax.semilogy(run.frequency, np.sqrt(np.mean(run.measured[i] ** 2, axis=0)), color=COLOURS["reference"], label="measured")
        for each, colour, label in fits:
            model: Any = each.model
            left = run.measured[i] - run.tested(model.accelerations(run, each.shared))[i]
            left = left - (left @ run.nuisance) @ np.linalg.pinv(run.nuisance.T @ run.nuisance) @ run.nuisance.T
            ax.semilogy(run.frequency, np.sqrt(np.mean(left**2, axis=0)), color=colour, label=label)
        ax.semilogy(run.frequency, np.sqrt(run.densities[i](run.frequency)), "k--", linewidth=0.8, label="disturbance")
        ax.set(xlabel="frequency [Hz]", ylabel=f"{name.replace('_', ' ')}: derivative [rad/s2]")
    axes[0].legend()
    return figure
