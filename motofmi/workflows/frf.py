"""Frequency response functions from recordings: the inertance of rider and handlebar in the steer test."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np

from fmus.support.errors import InputError
from fmus.support.notebook import html
from motofmi.frequency_response.estimators import band_width, estimate
from motofmi.frequency_response.figures import draw_modulus
from motofmi.frequency_response.frf import FRF, mean_frf
from motofmi.reports.frf_report import amplitude_and_phase, frf_report
from motofmi.reports.shown import Interactive
from motofmi.workflows.measured import Recorded, paths_of, recordings_of


@dataclass(frozen=True, repr=False)
class FrequencyResponse:
    """The inertance H = angular acceleration over torque [(rad/s2)/(N.m)], the mean over the runs.

    frequency (n,) [Hz], inertance (n,) complex, standard_deviation (n,) of its modulus and
    phase_standard_deviation (n,) [rad] over the runs, for a single run the estimate's own standard error;
    coherence (n,). each holds the FRF of every run,
    sources the files that they were read from.

        >>> from motofmi.frequency_response.excitation import sweep
        >>> from motofmi.virtual_rig.simulated_rig import steer_test
        >>> frf = mf.estimate_frf([steer_test(mf.rider("mean_2011"), 0.125, sweep(duration=60), seed=k) for k in (1, 2)])
        >>> frf.runs, frf.warnings
        (['sweep_0.5_to_12_Hz_rider_mean_2011', 'sweep_0.5_to_12_Hz_rider_mean_2011'], [])
        >>> frf.inertance.shape == frf.frequency.shape == frf.standard_deviation.shape == frf.phase_standard_deviation.shape
        True
        >>> bool(frf.coherence.max() <= 1), frf.mean.frequency is frf.frequency
        (True, True)
        >>> frf.to_dataframe().columns[0], frf.to_control().ninputs
        ('frequency [Hz]', 1)
        >>> axes = frf.plot()
        >>> path, page = frf.report("frf.html"), frf.show().save("chart.html")
        >>> frf.to_dict()["reference"]
        'steer_angle_command'
    """

    each: tuple[FRF, ...]
    sources: tuple[Path, ...] = ()

    @cached_property
    def mean(self) -> FRF:
        """The mean of modulus and phase over the runs."""
        return mean_frf(self.each)

    @property
    def runs(self) -> list[str]:
        """The names of the runs."""
        return [frf.name for frf in self.each]

    @property
    def frequency(self) -> np.ndarray:
        """Frequencies (n,) [Hz]."""
        return self.mean.frequency

    @property
    def inertance(self) -> np.ndarray:
        """Angular acceleration over torque (n,), complex [(rad/s2)/(N.m)]."""
        return self.mean.inertance

    @property
    def standard_deviation(self) -> np.ndarray:
        """Of the modulus (n,) [(rad/s2)/(N.m)]."""
        return np.where(self.mean.repeated, self.mean.modulus_deviation, self.mean.confidence(1.0)[0])

    @property
    def phase_standard_deviation(self) -> np.ndarray:
        """Of the phase (n,) [rad]."""
        return np.where(self.mean.repeated, self.mean.phase_deviation, self.mean.confidence(1.0)[1])

    @property
    def coherence(self) -> np.ndarray:
        """Coherence (n,) [1]."""
        return self.mean.coherence

    @property
    def warnings(self) -> list[str]:
        """Warnings about the recordings, with the name of the run."""
        return [f"{frf.name}: {warning}" for frf in self.each for warning in frf.warnings]

    def to_dict(self) -> dict[str, Any]:
        """The keys of `motofmi frf --json`."""
        confidence = self.mean.confidence()
        return {
            "runs": self.runs, "reference": self.mean.reference, "frequency": self.frequency,
            "inertance": self.inertance, "standard_deviation": self.standard_deviation,
            "phase_standard_deviation_deg": np.degrees(self.phase_standard_deviation),
            "standard_deviation_of": ["runs" if repeated else "estimate" for repeated in self.mean.repeated],
            "confidence_95": confidence[0], "phase_confidence_95_deg": np.degrees(confidence[1]),
            "coherence": self.coherence, "receptance": self.mean.receptance, "impedance": self.mean.impedance,
            "warnings": self.warnings,
        }  # fmt: skip

    def to_dataframe(self) -> Any:
        """A pandas.DataFrame with a row for each frequency; units are in the names of the columns."""
        import pandas  # noqa: PLC0415 - imported on use

        return pandas.DataFrame({
            "frequency [Hz]": self.frequency, "modulus [(rad/s2)/(N.m)]": np.abs(self.inertance),
            "modulus_sd [(rad/s2)/(N.m)]": self.standard_deviation, "phase [deg]": np.degrees(np.angle(self.inertance)),
            "phase_sd [deg]": np.degrees(self.phase_standard_deviation), "coherence [1]": self.coherence,
        })  # fmt: skip

    def to_control(self) -> Any:
        """The mean as python-control's FRD, from `steer_torque` to `steer_acceleration`, over rad/s."""
        return self.mean.to_control()

    def plot(self, axes: Any = None) -> Any:
        """Modulus and phase over frequency with their bands; the two axes of matplotlib."""
        return self.mean.plot(axes)

    def show(self) -> Interactive:
        """Modulus and phase with every run, interactive in a notebook."""
        return Interactive(amplitude_and_phase(self.each, self.mean))

    def report(self, path: str | Path) -> Path:
        """Write an HTML report; its path. Raises InputError where it cannot be written."""
        frf_report(self.each, self.mean, self.warnings, self.sources).write(Path(path))
        return Path(path)

    def __repr__(self) -> str:
        of = self.runs[0] if len(self.runs) == 1 else f"mean of {len(self.runs)} runs"
        return (
            f"FrequencyResponse({of}: {len(self.frequency)} frequencies from {self.frequency[0]:g} to "
            f"{self.frequency[-1]:g} Hz)"
        )

    def _repr_html_(self) -> str:
        frame = self.to_dataframe()
        rows = [tuple(f"{value:.4g}" for value in row) for row in frame.to_numpy()]
        return html(
            " ".join([repr(self), *self.warnings]),
            list(frame.columns),
            rows,
            lambda axes: draw_modulus(axes, self.mean),
        )


def estimate_frf(recordings: Recorded | Sequence[Recorded], *, mapping: Mapping[str, str] | None = None,
                 rate: float | None = None, reference: str = "", band: tuple[float, float] = (0.5, 12.0),
                 width: float | None = None) -> FrequencyResponse:  # fmt: skip
    """The inertance of rider and handlebar from recordings of the steer test, one run each (paths
    or Recording objects).

    mapping gives the variables of columns ({"Torque": "steer_torque [N.m]"}), rate [Hz] reduces faster recordings while
    they are read. reference is the signal of the cross-spectra: `steer_angle_command` where logged, else `steer_angle`
    (both unbiased), or `steer_torque` as in the papers. band is in Hz, width [Hz] that of the averages (default 0.25,
    more for recordings under 48 s). Raises InputError for recordings that cannot be used.

        >>> from motofmi.frequency_response.excitation import sweep
        >>> from motofmi.virtual_rig.simulated_rig import steer_test
        >>> runs = [steer_test(mf.rider("mean_2011"), 0.125, sweep(duration=60), seed=k) for k in (1, 2)]
        >>> mf.estimate_frf(runs)
        FrequencyResponse(mean of 2 runs: 47 frequencies from 0.5 to 12 Hz)
    """
    low, high = band
    if not 0 <= low < high:
        raise InputError(f"band ({low:g}, {high:g}) Hz: expected two frequencies, the lower one first")
    if width is not None and not width > 0:
        raise InputError(f"width {width:g} Hz is not positive")
    runs = recordings_of(recordings, mapping, rate)
    bands = width or band_width(runs)
    return FrequencyResponse(tuple(estimate(run, reference, (low, high), bands) for run in runs), paths_of(runs))
