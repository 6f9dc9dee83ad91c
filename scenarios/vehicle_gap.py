"""The gap workflow on a vehicle's measured eigenvalues: verdict, augmented vehicle, the next measurement, and the report."""

import argparse
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.figure import Figure

from fmus.component import Component
from fmus.errors import MissingToolError
from identification.gap.data.eigenvalues import Spectrum, is_spectrum, read_eigenvalues
from identification.gap.naming.decide import Verdict
from identification.gap.naming.fitted import Fit
from identification.gap.reporting.eigenvalue_verdict import cells, decide_on_eigenvalues
from identification.gap.reporting.verdict import as_result
from identification.gap.stands.linear_stand import LinearStand
from scenarios import names
from scenarios.augmented_vehicle import FILE, effect_on_modes, vehicle_of, write_vehicle
from scenarios.gap_tables import before_and_after, modes_over_speed, places, verdict_section
from scenarios.report import COLOURS, Report, Section, new_figure
from scenarios.vehicle_runs import run_on_recordings
from scenarios.vehicle_test import NOT_LINEAR, vehicle_effects, vehicle_stand, with_names
from scenarios.verdict_file import write_verdict, writing_so_far

GRID = 60  # speeds at which rivals are compared
WEAK = 40.0  # dBIC of a name that rests on little


def run_on_vehicle(arguments: argparse.Namespace) -> dict[str, Any]:
    """The result of `motofmi gap FILE ... --vehicle NAME`: eigenvalues or recorded runs, by the header of the first file."""
    return run_on_eigenvalues(arguments) if is_spectrum(arguments.files[0]) else run_on_recordings(arguments)


def run_on_eigenvalues(arguments: argparse.Namespace) -> dict[str, Any]:
    """The result of `motofmi gap eigenvalues.csv --vehicle NAME`, with everything that it names written into --out."""
    folder = Path(arguments.out)
    vehicle, device = names.vehicle(arguments.vehicle), names.device(arguments.device)
    stand = vehicle_stand(vehicle, device, arguments.free)
    measured, held = ([with_names(read_eigenvalues(path), stand) for path in files] for files in (arguments.files, arguments.holdout))
    so_far = writing_so_far(folder, lambda verdict: as_result(verdict, "1/s", "given", cells))
    verdict = decide_on_eigenvalues(stand, measured, vehicle_effects(vehicle, arguments.effects, linear=True), held, so_far)
    result = as_result(verdict, "1/s", "given", cells)
    result["limitations"] += _limitations(vehicle, measured, held)
    write_verdict(result, folder)
    result["next_experiment"] = next_measurement(verdict, stand)
    try:
        result["model"], result["fmu"] = write_vehicle(vehicle, verdict.best, folder, f"Fitted to {', '.join(r.name for r in measured)}", arguments.effects)
    except MissingToolError as error:
        result["model"] = FILE
        result["limitations"].append(f"No FMU was built: {error}")
    if result["verdict"] == "named":
        speeds = np.unique(np.concatenate([r.over for r in measured]))
        result["modes"] = effect_on_modes(vehicle_of(vehicle, verdict.base), names.component(str(folder / FILE)), device, speeds)
    result["report"] = write_report(verdict, result, held, folder)
    write_verdict(result, folder)
    return result


def _limitations(vehicle: Component, measured: Sequence[Spectrum], held: Sequence[Spectrum]) -> list[str]:
    sentences = ["The standard errors are those of the file: a verdict is as good as they are, and errors that rows share are not known.",
                 f"What has no eigenvalues cannot be named from them ({', '.join(NOT_LINEAR)}); in measured ones it looks like a damper."]  # fmt: skip
    if not vehicle.standard_error:
        sentences.append(f"{vehicle.name} says no standard errors: its masses and lengths are taken as known to 1 %, inertias, tyres and damper to 5 %.")
    if any(not m for r in measured for m in r.mode):
        sentences.append("Eigenvalues without a mode's name were matched with the nearest computed one.")
    if not held:
        sentences.append("No held-out eigenvalues: the verdict is not checked on data that were not used.")
    return sentences


def next_measurement(verdict: Verdict, stand: LinearStand) -> dict[str, Any] | None:
    """Where along the speed the rivals' eigenvalues part most, with the delta chi-square that measuring there once would bring."""
    rivals: list[Fit] = [c.fit for c in verdict.tied]
    if verdict.verdict == "named" and verdict.effects[0].delta_bic < WEAK:
        rivals = [verdict.best, verdict.base]
    if len(rivals) < 2:
        return None
    run = verdict.base.runs[0]
    top = stand.component.table[stand.over].max
    proposals = []
    for mode in dict.fromkeys(run.mode):
        rows = [i for i, m in enumerate(run.mode) if m == mode]
        first, last = run.over[rows].min(), run.over[rows].max()
        speeds = np.linspace(first, min(1.2 * last, top), GRID)
        error = float(np.median(run.real_error[rows]))
        nearest = [_followed(f, speeds, run.over[rows[0]], run.value[rows[0]]) for f in rivals]
        apart = np.min([np.abs(a - b) ** 2 for i, a in enumerate(nearest) for b in nearest[i + 1 :]], axis=0) / error**2
        best = int(apart.argmax())
        proposals.append({"experiment": "speed", "sentence": f"Measure {mode or 'the mode'} at {speeds[best]:.3g} m/s, to {error:.2g} 1/s as before.",
                          "speed": float(speeds[best]), "mode": mode, "expected_delta_chi2": float(apart[best])})  # fmt: skip
    return max(proposals, key=lambda p: p["expected_delta_chi2"]) | {"alternatives": proposals}


def _followed(found: Fit, speeds: np.ndarray, start: float, value: complex) -> np.ndarray:
    """The eigenvalue of a fit (n,) over speeds that begins nearest to a measured one, by its continuity."""
    spectra = _spectra(found, np.append(start, speeds))
    followed, last = [], value
    for spectrum in spectra:
        upper = spectrum[spectrum.imag >= 0]
        last = upper[np.abs(upper - last).argmin()]
        followed.append(last)
    return np.array(followed[1:])


def _spectra(found: Fit, speeds: np.ndarray) -> np.ndarray:
    """The eigenvalues (n, nx) of a fit at speeds (n,)."""
    model: Any = found.model
    return np.linalg.eigvals(model.linearised(found.shared, speeds)[0].A)


def write_report(verdict: Verdict, result: dict[str, Any], held: Sequence[Spectrum], folder: Path) -> str:
    """Write the HTML report into the folder; its name there."""
    sections = [
        verdict_section(result),
        Section("Eigenvalues over speed", [f"Held out: {', '.join(r.name for r in held) or 'none'}."],
                [(_over_speed(verdict), "Measured eigenvalues with their errors, the base, and the base with what was found.")],
                [before_and_after(result)]),
        Section("Where the base model misses", ["Cells that pass a false-discovery rate of 1 %."], [],
                [places(result, "mode and part")]),
        modes_over_speed(result),
    ]  # fmt: skip
    Report("The gap between vehicle and measured eigenvalues", f"Verdict: {result['verdict']}", sections).write(folder / "report.html")
    return "report.html"


def _over_speed(verdict: Verdict) -> Figure:
    figure, axes = new_figure(columns=2, width=11.0, sharex=True)
    for run in verdict.base.runs:
        seen = run.oscillates
        axes[0].errorbar(run.over, run.value.real, run.real_error, fmt=".", color=COLOURS["reference"])
        axes[1].errorbar(run.over[seen], run.value[seen].imag / (2 * np.pi), run.imag_error[seen] / (2 * np.pi), fmt=".", color=COLOURS["reference"])
        speeds = np.linspace(run.over.min(), run.over.max(), 200)
        for fit, colour in ((verdict.base, COLOURS["damper"]), (verdict.best, COLOURS["rider"])):
            spectra = _spectra(fit, speeds)
            kept = (spectra.imag >= 0) & (spectra.real > 1.3 * run.value.real.min() - 1)
            over = np.broadcast_to(speeds[:, None], spectra.shape)
            axes[0].plot(over[kept], spectra[kept].real, ",", color=colour)
            kept &= spectra.imag > 0
            axes[1].plot(over[kept], spectra[kept].imag / (2 * np.pi), ",", color=colour)
    top = max(run.value.imag.max() for run in verdict.base.runs) / (2 * np.pi)
    axes[0].set(xlabel="speed [m/s]", ylabel="real part [1/s]")
    axes[1].set(xlabel="speed [m/s]", ylabel="frequency [Hz]", ylim=(0, 1.2 * top + 0.1))
    for colour, label in ((COLOURS["reference"], "measured"), (COLOURS["damper"], "base"), (COLOURS["rider"], "with what was found")):
        axes[0].plot([], [], "o", markersize=3, color=colour, label=label)
    axes[0].legend()
    return figure
