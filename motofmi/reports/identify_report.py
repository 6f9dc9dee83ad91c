"""The report of an identified rider: fit with its confidence band, residuals, parameters, their correlations, bands."""

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from motofmi.frequency_response.frf import mean_frf
from motofmi.frequency_response.response import Response
from motofmi.identification.parameter_fit import Identification
from motofmi.reports.charts import Axis, Chart, Curve, Panel, Shade
from motofmi.reports.frf_report import (
    FREQUENCY,
    INERTANCE,
    amplitude_and_phase,
    bands,
    coherence,
    colour_of_run,
    nyquist,
    phase,
    runs_table,
)
from motofmi.reports.report import Report, Section, Table

DRAWS = 200  # from the fitted covariance, for the confidence band of the fit


def identify_report(fit: Identification, model: Response, found: Mapping[str, Any], inputs: Sequence[Path]) -> Report:
    """The report of a fit; found is `RiderIdentification.to_dict()`."""
    mean = mean_frf(fit.frfs)
    curve = fitted(fit, model)
    explained = not any("does not explain" in warning for warning in found["warnings"])
    sections = [
        Section("Parameters", [PARAMETERS_SAY], [], [parameters(found)]),
        Section(
            "Residuals",
            [RESIDUALS_SAY.format(fit.reduced_chi_square, found["residual"]["radius"], found["residual"]["phase_deg"])],
            [(residuals(fit), "Residuals of each run, of real and imaginary part, over their standard error.")],
        ),
        Section(
            "Nyquist plane",
            [
                "Measured bands and the fitted rider; a residual is the distance of a point to the curve at its "
                "frequency."
            ],
            [
                (
                    nyquist(
                        fit.frfs,
                        mean,
                        [
                            Curve(
                                "fitted", curve[1].real, curve[1].imag, "found", text=[f"{f:.3g} Hz" for f in curve[0]]
                            )
                        ],
                    ),
                    "Inertance, measured and fitted.",
                )
            ],
        ),
        Section("Correlations", [CORRELATIONS_SAY], [], [correlations(fit), directions(fit)]),
        Section("Coherence", [], [(coherence(fit.frfs, mean), "Coherence of each run.")]),
        Section("Bands of frequency", [], [], [bands(mean)], folded=True),
        Section("Runs", [], [], [runs_table(fit.frfs)], folded=True),
    ]
    return Report(
        "Identified rider",
        answer(fit, explained),
        sections,
        warnings=found["warnings"],
        inputs=inputs,
        asked=f"Which passive rider fits the steer test best: {', '.join(found['runs'])} (method {fit.method})?",
        figures=[
            (
                comparison(fit, model),
                "Measured, with its band, and the fitted rider, with the 95 % confidence band that "
                "follows from the covariance of the parameters.",
            )
        ],
    )


PARAMETERS_SAY = (
    "The 95 % interval follows from the standard error of the logarithm, so that no parameter is negative. The lower "
    "rows are "
    "derived: nu are undamped frequencies, zeta damping ratios of rider and handlebar, index t those of the rider with "
    "the bar held."
)
RESIDUALS_SAY = (
    "Where the model explains the data, residuals lie around zero without a trend, 95 % of them between the lines; a "
    "trend over frequency is an effect that the model lacks. Reduced chi-square {:.3g}; mean distance of the radii "
    f"{{:.4f}} {INERTANCE}, of the phases {{:.2f}} deg."
)
CORRELATIONS_SAY = (
    "Parameters whose errors are correlated near 1 or -1 are identifiable only in combination. The second table has "
    "the "
    "combinations of logarithms that the data determine, the best first: the standard error of each, and its "
    "largest shares."
)


def answer(fit: Identification, explained: bool) -> str:
    """How well the parameters are known and whether the model explains the data, in one sentence."""
    share = fit.standard_error / fit.values
    order = np.argsort(share)
    best, worst = (f"{_words(fit.names[k])} to {_percent(share[k])}" for k in (order[0], order[-1]))
    said = (
        f"The six parameters are known to between {_percent(share.min())} and {_percent(share.max())} ({best}, {worst})"
    )
    if explained:
        return f"{said}; with a reduced chi-square of {fit.reduced_chi_square:.3g} the passive rider explains the data."
    return (
        f"The passive rider does not explain the data: reduced chi-square {fit.reduced_chi_square:.3g} instead of 1. "
        "The errors "
        "below assume a model that the data reject; run motofmi gap on the same recordings to find the missing effect."
    )


def _words(name: str) -> str:
    return name.rpartition(".")[2].replace("_", " ")


def fitted(fit: Identification, model: Response) -> tuple[np.ndarray, np.ndarray]:
    """The identified model (n,) on a fine grid [Hz] over the measured frequencies."""
    frequency = np.linspace(min(f.frequency[0] for f in fit.frfs), max(f.frequency[-1] for f in fit.frfs), 300)
    return frequency, model(2 * np.pi * frequency, fit.values)


def comparison(fit: Identification, model: Response) -> Chart:
    """Modulus and phase: measured, and fitted with its confidence band."""
    frequency, value = fitted(fit, model)
    drawn = np.stack([model(2 * np.pi * frequency, p) for p in fit.draws(DRAWS)])
    turn = np.degrees(np.angle(drawn / value))
    low, high = np.percentile(np.abs(drawn), [2.5, 97.5], axis=0)
    angle = phase(value)
    below, above = np.percentile(turn, [2.5, 97.5], axis=0) + angle
    return amplitude_and_phase(fit.frfs, mean_frf(fit.frfs), (
        [Curve("fitted", frequency, np.abs(value), "found", band=(low, high))],
        [Curve("fitted", frequency, angle, "found", band=(below, above))]))  # fmt: skip


def residuals(fit: Identification) -> Chart:
    """Residuals over frequency in units of the standard error, a panel for each part, a colour for each run."""
    panels = []
    for part, name in (
        (np.real, "real part, over its standard error"),
        (np.imag, "imaginary part, over its standard error"),
    ):
        curves = [
            Curve(
                frf.name,
                frf.frequency,
                part(value - frf.inertance) / frf.standard_error,
                colour_of_run(k),
                "both",
                width=0.8,
            )
            for k, (frf, value) in enumerate(zip(fit.frfs, fit.fitted, strict=True))
        ]
        panels.append(
            Panel(
                FREQUENCY,
                Axis(name, "1"),
                curves,
                height=230,
                shades=[Shade(-1.96, 1.96, "95 % of noise alone", across="y", colour="measured")],
            )
        )
    return Chart(panels, linked=True)


def parameters(found: Mapping[str, Any]) -> Table:
    """Parameters and derived quantities with standard error and interval."""
    rows = []
    for name, entry in {**found["parameters"], **found["derived"]}.items():
        value, error = entry["value"], entry["standard_error"]
        if value is None or error is None:
            rows.append((_words(name), "overdamped" if value is None else f"{value:.5g}", "", "", "", entry["unit"]))
            continue
        factor = np.exp(1.96 * error / abs(value)) if value else 1.0
        ends = sorted((value / factor, value * factor))
        rows.append(
            (
                _words(name),
                f"{value:.5g}",
                f"{error:.2g}",
                _percent(abs(error / value)),
                f"{ends[0]:.4g} to {ends[1]:.4g}",
                entry["unit"],
            )
        )
    return Table(("parameter", "value", "standard error", "relative", "95 % interval", "unit"), rows)


def correlations(fit: Identification) -> Table:
    """The correlation matrix of the parameters' errors."""
    names = [_words(name) for name in fit.names]
    rows = [(name, *(f"{value:+.2f}" for value in row)) for name, row in zip(names, fit.correlation, strict=True)]
    return Table(("parameter", *names), rows, "Correlations of the errors [1]", shades=True)


def directions(fit: Identification) -> Table:
    """The combinations of log-parameters by their standard error."""
    rows = []
    for value, direction in zip(fit.singular_values, fit.directions, strict=True):
        order = [k for k in np.argsort(-np.abs(direction)) if abs(direction[k]) > 0.3]
        rows.append(
            (
                f"{1 / value:.2g}" if value > 0 else "not identifiable",
                ", ".join(f"{direction[k]:+.2f} {_words(fit.names[k])}" for k in order),
            )
        )
    return Table(("standard error of the logarithm [1]", "combination"), rows, "Combinations that the data determine")


def _percent(share: float) -> str:
    """A share with two digits, as in 0.043%."""
    return f"{100 * share:.2g}%"
