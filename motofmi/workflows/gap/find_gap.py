"""The gap workflow: where a model deviates from recordings, and which physical effect it lacks."""

from collections.abc import Mapping, Sequence
from contextlib import nullcontext
from dataclasses import replace
from math import inf
from pathlib import Path
from typing import Any

from fmus.effects import Effect
from fmus.support.deadline import deadline
from fmus.support.errors import InputError
from fmus.support.files import writable
from fmus.support.progress import stage
from motofmi.gap.criteria import Criteria
from motofmi.gap.preprocessing.eigenvalues import MeasuredEigenvalues
from motofmi.gap.preprocessing.steer_test_run import NotSweptError
from motofmi.gap.selection.result import Verdict
from motofmi.gap.selection.within_time import within_time
from motofmi.recordings.recording import Recording
from motofmi.workflows.components import ComponentLike
from motofmi.workflows.gap.given import Given, Measured
from motofmi.workflows.gap.imposed_motion import SteerTest
from motofmi.workflows.gap.imposed_motion_over_time import SteerTestOverTime
from motofmi.workflows.gap.input_output import InputOutput
from motofmi.workflows.gap.kind import Kind
from motofmi.workflows.gap.result import Gap
from motofmi.workflows.gap.vehicle_eigenvalues import VehicleEigenvalues
from motofmi.workflows.gap.vehicle_equations import VehicleEquations
from motofmi.workflows.gap.vehicle_predictions import VehiclePredictions
from motofmi.workflows.gap.verdict_file import FILE, writing_progress

# Kinds of experiment in the order in which they are tried: the first that fits the arguments is taken. A steer test
# whose motion is no sweep raises NotSweptError and is compared over time instead.
KINDS: tuple[type[Kind], ...] = (
    VehicleEigenvalues,
    VehicleEquations,
    VehiclePredictions,
    InputOutput,
    SteerTest,
    SteerTestOverTime,
)


def find_gap(recordings: Measured | Sequence[Measured], *, validation: Measured | Sequence[Measured] = (),
             bare: Measured | Sequence[Measured] = (), component: ComponentLike | None = None,
             vehicle: ComponentLike | None = None, device: ComponentLike | None = None, rider: str = "mean_2011",
             rig: str | Path | Mapping[str, Any] | None = None, impose: str | None = None, free: Sequence[str] = (),
             mapping: Mapping[str, str] | None = None, effects: str | Path | Sequence[type[Effect]] = (),
             rate: float | None = None, criteria: Criteria = Criteria(), tolerance: float | None = None,
             time: float | None = None, out: str | Path | None = None) -> Gap:  # fmt: skip
    r"""Find where a model deviates from recordings, name the missing effect, add it, and compare before and after.

    The model is fitted to the recordings; the validation runs are not fitted, the result is compared with them. A
    recording is a path or a Recording (columns in SI units) of one run, or for a vehicle a table of eigenvalues over
    speed. The experiment is
      the steer test        by default; bare are sweeps of the bare handlebar, rider names the published rider whose
                            values start the fit, rig is a rig.json or its contents (default: the rig.json beside the
                            first recording)
      any component         with component (a Component, a name, a .toml or PATH.py:CLASS); impose names a state that
                            was imposed, free the parameters without prior knowledge
      a vehicle over speed  with vehicle, and device at its handlebar
    mapping gives the variables of columns ({"Torque": "steer_torque [N.m]"}); effects is a folder of own effects, or
    their classes; rate [Hz] is the sampling rate to which faster recordings are reduced while they are read; criteria
    are the thresholds of all decisions. tolerance replaces criteria.tolerance, the misfit (rms, as a share of the
    measured rms) up to which the model is called sufficient if the noise is not known.
    time is the budget of the search [s]: at its end the verdict is that of what is known by then, and the first
    limitation says what was not done. The comparison with validation runs may take a quarter of it more; then follow
    model, FMU and report.
    With out, verdict.json, the fitted model as value file and FMU, and report.html are written into that folder. An
    interrupted run leaves verdict.json and report.html with the verdict `unknown` and the results so far.

    Raises InputError for arguments or recordings that cannot be used, before anything is fitted.

        >>> from pathlib import Path
        >>> def measured(speed, seed, error=0.01):
        ...     '''Eigenvalues of a motorcycle with a stronger damper than the model has, with errors [1/s].'''
        ...     found = mf.modes(mf.vehicle("sharp_1971", steering_damping=12.0), speed=speed)
        ...     rng = np.random.default_rng(seed)
        ...     rows = [(v, mode, x.real + error * rng.normal(), x.imag + error * rng.normal(), error, error)
        ...             for mode in ("weave", "wobble") for v, x in zip(speed, found[mode].eigenvalue)]
        ...     heading = "speed [m/s],mode,real [1/s],imag [rad/s],real_se,imag_se"
        ...     return "\n".join([heading, *(",".join(map(str, row)) for row in rows)])
        >>> for k, speed in enumerate((np.arange(10.0, 41.0, 5.0), np.arange(12.0, 42.0, 6.0))):
        ...     count = Path(f"measured_{k}.csv").write_text(measured(speed, k))
        >>> found = mf.find_gap("measured_0.csv", validation="measured_1.csv", vehicle="sharp_1971")
        >>> found.verdict, found.tied, found.effects[0]["name"], found.model.title
        ('named', [], 'steer_damping', 'Motorcycle')
        >>> found.gap["holdout_after"] < found.gap["holdout_before"]
        True
        >>> [place["unit"] for place in found.where if place["p_value"] > 0.05]
        []
        >>> found.to_dataframe().name[0], len(found.candidates) > 1, len(found.limitations) > 0
        ('steer_damping', True, True)
        >>> found.next_experiment is None or "expected_delta_chi2" in found.next_experiment
        True
        >>> axes, page, chart = found.plot(), found.report("gap.html"), found.show().save("chart.html")
        >>> [path.name for path in found.save("gap")][:2], sorted(found.to_dict()["gap"])[:2]
        (['verdict.json', 'report.html'], ['after', 'before'])
    """
    if time is not None and not 0 < time < inf:
        raise InputError(f"time is {time:g}: expected a number of seconds above 0, as in 60")
    if tolerance is not None:
        if not 0 <= tolerance < 1:
            raise InputError(f"tolerance is {tolerance:g}: expected a share from 0 to below 1, as in 0.01 for 1 %")
        criteria = replace(criteria, tolerance=tolerance)
    given = Given(_listed(recordings), _listed(validation), _listed(bare), component, vehicle, device, rider, rig,
                  impose or "", tuple(free), mapping or {}, effects, rate, criteria)  # fmt: skip
    if not given.recordings:
        raise InputError("no recordings: give at least one, as in find_gap(['sweep.csv']) or motofmi gap FILE.csv")
    if component is not None and vehicle is not None:
        raise InputError("both component and vehicle are given: expected one of them")
    folder = None if out is None else Path(out)
    if folder is not None:
        writable(folder / FILE)
    with nullcontext() if time is None else deadline(time), stage("gap"):
        experiment = _experiment(given)
        on_progress = _ignored if folder is None else writing_progress(folder, experiment.contents)
        found = Gap(experiment, within_time(experiment.verdict, on_progress))
        if found.selection.interrupted:
            if folder is not None:
                found.save_known(folder)
            raise KeyboardInterrupt
        if folder is None:
            found.complete()
        else:
            found.save(folder)
    return found


def _experiment(given: Given) -> Kind:
    *others, last = [kind for kind in KINDS if kind.suits(given)]
    for kind in others:
        try:
            return kind(given)
        except NotSweptError:
            continue
    return last(given)


def _listed(given: Measured | Sequence[Measured]) -> list[Measured]:
    return [given] if isinstance(given, str | Path | Recording | MeasuredEigenvalues) else list(given)


def _ignored(verdict: Verdict) -> None:
    """The callback of a run without an output folder."""
