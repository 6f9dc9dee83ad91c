"""A rider's parameters from recordings of the steer test, and the rider component with these parameters."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np

from fmus.support.errors import InputError, unknown
from fmus.support.files import write_text
from fmus.support.notebook import html, new_axes
from motofmi.frequency_response.frf import mean_frf
from motofmi.identification.bootstrap import bootstrap as repeated
from motofmi.identification.parameter_fit import METHODS, Identification
from motofmi.identification.parameter_fit import identify as fit
from motofmi.reports import frf_figures
from motofmi.reports.identify_report import comparison, identify_report
from motofmi.reports.shown import Interactive
from motofmi.workflows.frf import FrequencyResponse, estimate_frf
from motofmi.workflows.measured import Recorded, Rig, recordings_of, rig_of
from motofmi.workflows.measured_rider import (
    PARAMETERS,
    derived_with_errors,
    qualified,
    rider_from,
    rider_toml,
    rig_response,
    table_spread,
    write_population,
)
from rider_fmu import PassiveRider
from rider_fmu.rigs.handlebar import HANDLEBAR_INERTIA

# Reduced chi-square above which the model does not explain the data. Simulated linear riders leave 0.9 to 1.2 weighted,
# and up to 2.3 by the papers' sums, which do not weigh by the noise.
UNEXPLAINED = {"weighted": 2.0, "nyquist": 5.0, "amplitude": 5.0}
DRAWN = "Drawn from the spread of the ten riders of Cossalter, Doria, Lot, Massaro, Meccanica 46 (2011), Table 2"


@dataclass(frozen=True, repr=False)
class RiderIdentification:
    """The rider that fits recordings best, with errors.

    fit holds values, covariance and singular values; runs the names of the recordings; handlebar_inertia [kg.m2] that
    of the bare bar; draws (n, 6) the parameters of a bootstrap, if there was one; sources the files of the recordings.

        >>> from motofmi.frequency_response.excitation import sweep
        >>> from motofmi.virtual_rig.simulated_rig import steer_test
        >>> runs = [steer_test(mf.rider("mean_2011"), 0.125, sweep(duration=60), seed=k) for k in (1, 2)]
        >>> fit = mf.identify(runs)
        >>> fit.rider.title, fit.parameters["torso_inertia"]["unit"], fit.derived["nu1"]["unit"]
        ('PassiveRider', 'kg.m2', 'Hz')
        >>> sorted(fit.residual), fit.warnings
        (['phase_deg', 'radius'], [])
        >>> fit.source
        'Identified from sweep_0.5_to_12_Hz_rider_mean_2011, sweep_0.5_to_12_Hz_rider_mean_2011 (weighted)'
        >>> fit.save("mine.toml").name, len(fit.save_population("riders", count=3))
        ('mine.toml', 3)
        >>> fit.to_dict()["method"], fit.to_dataframe().columns[0]
        ('weighted', 'name')
        >>> axes = fit.plot()
        >>> files = fit.report("fit.html"), fit.save_plot("fit.png"), fit.show().save("chart.html")
    """

    fit: Identification
    runs: tuple[str, ...]
    handlebar_inertia: float
    draws: np.ndarray | None = field(default=None)
    sources: tuple[Path, ...] = ()

    @cached_property
    def rider(self) -> PassiveRider:
        """The identified rider as a component."""
        return rider_from(self.fit.values, self.handlebar_inertia, source=self.source)

    @property
    def source(self) -> str:
        """The recordings and the method by which the rider was identified."""
        return f"Identified from {', '.join(self.runs)} ({self.fit.method})"

    @property
    def parameters(self) -> dict[str, dict[str, Any]]:
        """name -> value, standard_error, unit."""
        rows = zip(PARAMETERS, self.fit.values, self.fit.standard_error, self.fit.units, strict=True)
        return {name: {"value": float(v), "standard_error": float(e), "unit": unit} for name, v, e, unit in rows}

    @cached_property
    def derived(self) -> dict[str, dict[str, Any]]:
        """Frequencies and damping ratios that follow: name -> value (None where overdamped), standard_error, unit."""
        return derived_with_errors(self.fit, self.handlebar_inertia)

    @property
    def residual(self) -> dict[str, float]:
        """Mean distance of measured and fitted FRF: radius [(rad/s2)/(N.m)], phase_deg."""
        return self.fit.residual

    @property
    def warnings(self) -> list[str]:
        """Warnings about recordings and fit."""
        found = [w.replace("bar.", "").replace("rider.", "") for w in self.fit.warnings]
        if self.fit.reduced_chi_square > UNEXPLAINED[self.fit.method]:
            found.append(f"reduced chi-square {self.fit.reduced_chi_square:.3g} instead of 1: the model does not "
                         "explain the data, and the standard errors "
                         "assume that it does; motofmi gap looks for the missing effect")  # fmt: skip
        return found

    def to_dict(self) -> dict[str, Any]:
        """The keys of `motofmi identify --json`."""
        found = self.fit
        result = {
            "method": found.method, "parameters": self.parameters, "derived": self.derived, "residual": self.residual,
            "handlebar_inertia": self.handlebar_inertia, "reduced_chi_square": found.reduced_chi_square,
            "run_to_run": found.run_to_run, "correlation": found.correlation, "singular_values": found.singular_values,
            "agreeing_starts": found.agreeing_starts, "warnings": self.warnings, "runs": list(self.runs),
        }  # fmt: skip
        if self.draws is not None:
            low, high = np.percentile(self.draws, [2.5, 97.5], axis=0)
            columns = zip(PARAMETERS, found.units, self.draws.std(axis=0, ddof=1), low, high, strict=True)
            result["bootstrap"] = {
                name: {"standard_error": float(s), "interval_95": [float(a), float(b)], "unit": unit}
                for name, unit, s, a, b in columns
            }
        return result

    def to_dataframe(self) -> Any:
        """Parameters and derived quantities as a pandas.DataFrame: name, value, standard_error, unit."""
        import pandas  # noqa: PLC0415 - imported on use

        return pandas.DataFrame(
            [{"name": name, **entry} for name, entry in {**self.parameters, **self.derived}.items()]
        )

    def save(self, path: str | Path) -> Path:
        """Write the rider's value file (.toml) with errors and correlations, which every command accepts; its path."""
        path = toml_path(path)
        write_text(path, rider_toml(self.fit, self.handlebar_inertia, "Measured rider, steer test", self.source))
        return path

    def save_population(self, folder: str | Path, count: int, seed: int = 0) -> list[Path]:
        """Write the value files of `count` riders drawn from the fitted covariance; their paths."""
        return write_population(
            self.fit.draws(count, seed),
            self.handlebar_inertia,
            Path(folder),
            f"{self.source}; drawn from the fitted covariance",
        )

    def plot(self, axes: Any = None) -> Any:
        """Amplitude and phase, and the Nyquist plane, measured and fitted: the three axes of matplotlib."""
        axes = _three_axes(new_axes) if axes is None else axes
        frf_figures.draw_identification(axes, self.fit, mean_frf(self.fit.frfs), self._curve)
        return axes

    def save_plot(self, path: str | Path) -> Path:
        """Write the figure of `plot` as .png, .svg or .pdf; its path."""
        return frf_figures.save(frf_figures.identification(self.fit, mean_frf(self.fit.frfs), self._curve), path)

    def show(self) -> Interactive:
        """Measured and fitted inertance with the fit's confidence band, interactive in a notebook."""
        return Interactive(comparison(self.fit, rig_response()))

    def report(self, path: str | Path) -> Path:
        """Write an HTML report; its path. Raises InputError where it cannot be written."""
        identify_report(self.fit, rig_response(), self.to_dict(), self.sources).write(Path(path))
        return Path(path)

    def __repr__(self) -> str:
        values = ", ".join(
            f"{name} = {p['value']:.4g} +- {p['standard_error']:.2g} {p['unit']}" for name, p in self.parameters.items()
        )
        return f"RiderIdentification({self.fit.method}, reduced chi-square {self.fit.reduced_chi_square:.3g}: {values})"

    def _repr_html_(self) -> str:
        return html(" ".join([f"{self.source}: {residuals(self.to_dict())}.", *self.warnings]),
                    ("parameter", "value", "standard error", "unit"), rows(self.to_dict()),
                    lambda axes: frf_figures.draw_nyquist(axes, self.fit, self._curve))  # fmt: skip

    @cached_property
    def _curve(self) -> frf_figures.Curve:
        return frf_figures.fitted_curve(self.fit, rig_response())


def identify(recordings: Recorded | Sequence[Recorded] | FrequencyResponse, *, method: str = "weighted",
             mapping: Mapping[str, str] | None = None, rate: float | None = None, rig: Rig | None = None,
             reference: str = "", band: tuple[float, float] = (0.5, 12.0), width: float | None = None,
             mean: bool = False, bounds: Mapping[str, tuple[float, float]] | None = None, starts: int = 4,
             handlebar_inertia: float | None = None, run_to_run: float | None = None, bootstrap: int = 0,
             seed: int = 0) -> RiderIdentification:  # fmt: skip
    """The six parameters of the passive rider from recordings of the steer test (paths or Recording
    objects), or from their FRF.

    method is `weighted` (each band by the estimate's own variance), `nyquist` (2011) or `amplitude` (2008). mapping,
    rate, reference, band and width as in `estimate_frf`. mean fits the mean FRF of different riders instead of runs of
    one rider; bounds limit parameters by name; starts are the starting values; handlebar_inertia [kg.m2] is that of the
    bare bar (default: rig, rig.json beside the first recording, or that of the 2011 paper); run_to_run is the relative
    change of the rider from run to run (default: estimated from the runs); bootstrap repeats the fit so many times on
    data resampled with `seed`. Raises InputError for arguments or recordings that cannot be used.

        >>> from motofmi.frequency_response.excitation import sweep
        >>> from motofmi.virtual_rig.simulated_rig import steer_test
        >>> runs = [steer_test(mf.rider("mean_2011"), 0.125, sweep(duration=60), seed=k) for k in (1, 2)]
        >>> found = mf.identify(runs).parameters["arm_stiffness"]
        >>> abs(found["value"] - mf.rider("mean_2011").values["arm_stiffness"]) < 4 * found["standard_error"]
        True
    """
    if method not in METHODS:
        raise unknown("method", method, METHODS)
    if starts < 1 or bootstrap < 0:
        raise InputError(
            f"{'starts' if starts < 1 else 'bootstrap'} {starts if starts < 1 else bootstrap} is too small"
        )
    for name in bounds or {}:
        if name not in PARAMETERS:
            raise unknown("parameter to bound", name, PARAMETERS)
    limited = {qualified(name): limits for name, limits in (bounds or {}).items()}
    runs = [] if isinstance(recordings, FrequencyResponse) else recordings_of(recordings, mapping, rate)
    frf = (
        recordings
        if isinstance(recordings, FrequencyResponse)
        else estimate_frf(runs, reference=reference, band=band, width=width)
    )
    model = rig_response()
    found = fit([frf.mean] if mean else frf.each, model, method, limited, starts, seed, run_to_run)
    bar = handlebar_inertia or rig_of(rig, runs).get("handlebar_inertia", {}).get("value", HANDLEBAR_INERTIA)
    return RiderIdentification(
        found,
        tuple(frf.runs),
        bar,
        repeated(found, model, bootstrap, seed, limited) if bootstrap else None,
        frf.sources,
    )


def save_drawn_riders(folder: str | Path, count: int, seed: int = 0) -> list[Path]:
    """Write the value files of `count` riders drawn from the distribution of the ten riders of 2011; their paths."""
    return write_population(table_spread(count, seed), HANDLEBAR_INERTIA, Path(folder), DRAWN)


def toml_path(path: str | Path) -> Path:
    """The path of a rider's file. Raises InputError where it does not end in .toml."""
    if Path(path).suffix != ".toml":
        raise InputError(f"{path}: a rider's file ends in .toml")
    return Path(path)


def _three_axes(make: Any) -> Any:
    return make(1, 3, figsize=(13, 4.2))


def rows(found: Mapping[str, Any]) -> list[tuple[str, str, str, str]]:
    """Parameters and derived quantities of a `RiderIdentification.to_dict()` as text: name, value,
    standard error, unit."""
    return [(name, "overdamped" if e["value"] is None else f"{e['value']:.5g}",
             "" if e["standard_error"] is None else f"{e['standard_error']:.2g}", e["unit"])
            for name, e in {**found["parameters"], **found["derived"]}.items()]  # fmt: skip


def residuals(found: Mapping[str, Any]) -> str:
    """The residuals of a `RiderIdentification.to_dict()` in a sentence."""
    return (f"mean distance of the radii {found['residual']['radius']:.4f} (rad/s2)/(N.m), of the phases "
            f"{found['residual']['phase_deg']:.2f} deg; "
            f"reduced chi-square {found['reduced_chi_square']:.3g}")  # fmt: skip
