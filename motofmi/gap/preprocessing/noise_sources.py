"""Sources of a run's noise: given values, repeated periods or repeated runs of the same excitation.

    one period after another of the same excitation:   var(n) = sum over periods |y_p - mean|^2 / (P - 1)
    two runs of the same excitation:                   var(n) = |y_1 - y_2|^2 / 2
"""

from collections.abc import Mapping, Sequence
from itertools import combinations

import numpy as np

from motofmi.gap.preprocessing.flexible_noise_model import Density, noise_density
from motofmi.gap.preprocessing.sampled_run import SampledRun
from motofmi.recordings.resampling import varies

REPETITION_ERROR = 0.01  # relative rms difference between two periods or runs with the same excitation
FEWEST_PERIODS = 3  # whole periods after the first one, in which transients decay


def known_noise(runs: Sequence[SampledRun], given: Mapping[str, float]) -> list[SampledRun]:
    """The runs with their noise where it is known, and with the source `flexible_model` where it is not.

    given holds the standard deviation of the noise by output, each in the output's unit.
    """
    found = []
    for run in runs:
        if all(name in given for name in run.experiment.outputs):
            flat = [
                Density(np.array([0.0, run.recording.rate / 2]), np.full(2, given[n] ** 2))
                for n in run.experiment.outputs
            ]
            found.append(run.with_densities(flat, "given"))
            continue
        repeated = _over_periods(run) or _over_runs(run, runs)
        found.append(
            run.with_densities(repeated, "repeats") if repeated else run.with_densities(run.densities, "flexible_model")
        )
    return found


def _excitation(run: SampledRun) -> np.ndarray:
    """The inputs (n, k) of a run that are not constant."""
    names = [n for n in run.experiment.inputs if varies(run.recording[n])]
    return np.column_stack([run.recording[n] for n in names]) if names else np.zeros((len(run.measured), 0))


def _over_periods(run: SampledRun) -> list[Density] | None:
    """The noise densities of the outputs from the differences between periods; None where the inputs have no
    common period."""
    drive = _excitation(run)
    period = _period(drive) if drive.shape[1] else 0
    if not period:
        return None
    settled = run.measured[len(run.measured) % period + period :]
    periods = settled.reshape(-1, period, settled.shape[1])
    count = len(periods)
    left = (periods - periods.mean(axis=0)).reshape(settled.shape) * np.sqrt(count / (count - 1))
    return [noise_density(y, [], run.recording.rate) for y in left.T]


def _period(drive: np.ndarray) -> int:
    """The common period of excitations (n, k), none of them constant, in whole samples; 0 where they have none, or too
    few of them.

    It has the least mean square difference between samples one period apart. Source: de Cheveigne, Kawahara, J. Acoust.
    Soc. Am. 111 (2002) 1917-1930.
    """
    n = len(drive)
    scaled = (drive - drive.mean(axis=0)) / drive.std(axis=0)
    power = np.sum(scaled**2, axis=1)
    spectrum = np.sum(np.abs(np.fft.rfft(scaled, 2 * n, axis=0)) ** 2, axis=1)
    ends = np.cumsum(power)[::-1] + np.cumsum(power[::-1])[::-1]
    differences = (ends - 2 * np.fft.irfft(spectrum)[:n]) / np.arange(n, 0, -1)
    last = n // (FEWEST_PERIODS + 1)
    different = np.flatnonzero(differences[:last] > drive.shape[1])
    if last < 8 or not len(different):
        return 0
    period = int(different[0] + np.argmin(differences[different[0] : last]))
    repeats = np.mean((scaled[period:] - scaled[:-period]) ** 2, axis=0)
    # About zero: a ramp differs from itself by a constant.
    return period if np.all(repeats < REPETITION_ERROR**2) else 0


def _over_runs(run: SampledRun, runs: Sequence[SampledRun]) -> list[Density] | None:
    """The noise densities of the outputs from another run with the same excitation; None where there is none."""
    drive = _excitation(run)
    for first, second in combinations(runs, 2):
        other = second if first is run else first if second is run else None
        if other is None or len(other.measured) != len(run.measured) or not drive.shape[1]:
            continue
        same = _excitation(other)
        if same.shape != drive.shape:
            continue
        if np.all(np.mean((same - drive) ** 2, axis=0) < (REPETITION_ERROR * np.std(drive, axis=0)) ** 2):
            left = (run.measured - other.measured) / np.sqrt(2)
            return [noise_density(y, [], run.recording.rate) for y in left.T]
    return None
