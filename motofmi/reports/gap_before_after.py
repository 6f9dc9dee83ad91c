"""The residuals of one run, before and after: over time, by order, as a response, in the Nyquist plane, against noise.

The run is the first validation run, else the first that was fitted.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from matplotlib.figure import Figure

from motofmi.gap.estimation.fit_result import Fit
from motofmi.gap.preprocessing.harmonics import Column
from motofmi.gap.preprocessing.steer_test_run import SteerTestRun
from motofmi.gap.selection.model_selection import Verdict
from motofmi.reports.figures import COLOURS, new_figure

ORDERS = (1, 2, 3)
LAGS = 20


def without_and_with(verdict: Verdict) -> list[tuple[Fit, str, str]]:
    """Fit, colour and label of base and best on the validation runs, else on the fitted ones; of the base alone
    if no effect was found."""
    found = [each.fit for each in verdict.validation_gap] if verdict.validation_gap else [verdict.base, verdict.best]
    both = list(zip(found, (COLOURS["damper"], COLOURS["rider"]), ("base", "with the effects found"), strict=True))
    return both if verdict.best.model.effects else both[1:]


def shown_run(verdict: Verdict) -> str:
    """A sentence that names the validation runs and the run that is shown."""
    names = [run.name for run in verdict.validation_gap[1].fit.runs] if verdict.validation_gap else []
    return (
        f"Validation runs, not used to fit: {', '.join(names)}. Shown is {names[0]}."
        if names
        else "No validation run: shown is the first that was fitted."
    )


@dataclass(frozen=True)
class _Left:
    """The harmonics of a run's effort (m,): measured, and the residuals of a fit."""

    run: SteerTestRun
    columns: list[Column]
    measured: np.ndarray
    left: np.ndarray

    @classmethod
    def of(cls, found: Fit) -> "_Left":
        run: SteerTestRun = found.runs[0]
        return cls(
            run, run.reduction.columns, run.effort.data, found.residuals[: len(run.effort.data)] * run.effort.deviation
        )

    def windows(self, values: np.ndarray) -> np.ndarray:
        """The rms (w,) of such numbers (m,) over each window's samples."""
        samples = np.array([last - first for first, last, _ in self.run.reduction.bases])
        return np.sqrt(np.bincount([c.window for c in self.columns], values**2, len(samples)) / samples)

    def order(self, k: int) -> np.ndarray:
        """The places (w, 2) of the cosines and sines of an order."""
        return np.array([i for i, c in enumerate(self.columns) if c.order == k and c.degree == 0], int).reshape(-1, 2)

    def amplitudes(self, values: np.ndarray, k: int) -> np.ndarray:
        """Amplitude (w,) of an order in such numbers (m,)."""
        samples = np.array(
            [np.subtract(*self.run.reduction.bases[self.columns[i].window][1::-1]) for i, _ in self.order(k)]
        )
        return np.hypot(*values[self.order(k)].T) * np.sqrt(2 / samples)

    def frequency(self, k: int = 1) -> np.ndarray:
        return np.array([self.columns[i].frequency for i, _ in self.order(k)])

    def response(self, values: np.ndarray) -> np.ndarray:
        """Such numbers (m,) at the first order over the motion's (w,), complex."""
        motion = self.run.reduction.reduce(self.run.motion_at(self.run.recording.time)[0])
        cos, sin = self.order(1).T
        return (values[cos] - 1j * values[sin]) / (motion[cos] - 1j * motion[sin])


def figures(shown: Sequence[tuple[Fit, str, str]]) -> list[tuple[Figure, str]]:
    """The pictures of a swept or stepped run, with their captions."""
    name = shown[0][0].runs[0].name
    left = [(_Left.of(fit), colour, label) for fit, colour, label in shown]
    return [
        (_over_time(left), f"{name}: the recording, and the residuals of its harmonics in each window, against the "
                           "noise."),
        (_by_order(left), f"{name}: amplitude of the residuals at each order of the excitation, against the noise."),
        (_response(left), f"{name}: first harmonic of the torque over the imposed angle."),
        (_nyquist(left), "The same as impedance in the Nyquist plane."),
        (whiteness(shown, _in_time(left[0][0].columns)), f"{name}: residuals in units of the noise against the normal "
                                                         "distribution, and how they "
         "depend on their neighbours in time; noise alone stays within the grey lines (95 %)."),
    ]  # fmt: skip


def _over_time(left: Sequence[tuple[_Left, str, str]]) -> Figure:
    figure, (upper, lower) = new_figure(rows=2, sharex=True, height=5.6)
    first = left[0][0]
    output = first.run.effort
    unit = first.run.recording.units[output.column]
    upper.plot(first.run.recording.time, output.measured, color=COLOURS["reference"], linewidth=0.4)
    upper.set_ylabel(f"{output.column.replace('_', ' ')} [{unit}]")
    bases = first.run.reduction.bases
    time = [first.run.recording.time[(begin + end) // 2] for begin, end, _ in bases]
    for of, colour, label in left:
        lower.semilogy(time, of.windows(of.left), color=colour, label=label)
    lower.semilogy(time, first.windows(output.deviation), "--", color=COLOURS["reference"], label="noise")
    lower.set(xlabel="time [s]", ylabel=f"residual, rms [{unit}]")
    lower.legend()
    return figure


def _by_order(left: Sequence[tuple[_Left, str, str]]) -> Figure:
    figure, rows = new_figure(rows=len(ORDERS), sharex=True, height=6.4)
    unit = left[0][0].run.recording.units[left[0][0].run.effort.column]
    for axes, k in zip(rows, ORDERS, strict=True):
        for of, colour, label in left:
            axes.semilogy(of.frequency(k), of.amplitudes(of.left, k), ".-", color=colour, label=label, linewidth=0.8)
        noise = left[0][0]
        axes.semilogy(
            noise.frequency(k),
            noise.amplitudes(noise.run.effort.deviation, k),
            "--",
            color=COLOURS["reference"],
            label="noise",
        )
        axes.set_ylabel(f"order {k} [{unit}]")
    rows[0].legend(loc="upper left", ncols=3, fontsize=8)
    rows[-1].set_xlabel("frequency of the excitation [Hz]")
    return figure


def _response(left: Sequence[tuple[_Left, str, str]]) -> Figure:
    figure, (size, phase) = new_figure(rows=2, sharex=True)
    for of, values, style, colour, label in _measured_and_modelled(left):
        order = np.argsort(of.frequency())
        response = of.response(values)[order]
        size.plot(of.frequency()[order], np.abs(response), style, color=colour, label=label)
        phase.plot(of.frequency()[order], np.angle(response, deg=True), style, color=colour)
    size.set_ylabel("|T/angle| [N.m/rad]")
    phase.set(xlabel="frequency [Hz]", ylabel="phase [deg]")
    size.legend()
    return figure


def _nyquist(left: Sequence[tuple[_Left, str, str]]) -> Figure:
    figure, axes = new_figure()
    for of, values, style, colour, label in _measured_and_modelled(left):
        response = of.response(values)[np.argsort(of.frequency())]
        axes.plot(response.real, response.imag, style, color=colour, label=label)
    axes.set(xlabel="Re T/angle [N.m/rad]", ylabel="Im T/angle [N.m/rad]")
    axes.legend()
    return figure


def _measured_and_modelled(left: Sequence[tuple[_Left, str, str]]) -> list[tuple[_Left, np.ndarray, str, str, str]]:
    first = left[0][0]
    return [
        (first, first.measured, ".", COLOURS["reference"], "measured"),
        *((of, of.measured + of.left, "-", colour, label) for of, colour, label in left),
    ]


def _in_time(columns: Sequence[Column]) -> np.ndarray:
    """The places of a run's data, one kind of number after the other, each over time."""
    part = np.zeros(len(columns), int)  # of an order and degree: cosine, then sine
    for i in range(1, len(columns)):
        alike = (columns[i].window, columns[i].order, columns[i].degree) == (
            columns[i - 1].window,
            columns[i - 1].order,
            columns[i - 1].degree,
        )
        part[i] = part[i - 1] + 1 if alike else 0
    return np.array(
        sorted(range(len(columns)), key=lambda i: (columns[i].order, columns[i].degree, part[i], columns[i].window))
    )


def whiteness(shown: Sequence[tuple[Fit, str, str]], sequence: np.ndarray | None = None) -> Figure:
    """Residuals of the first run in units of the noise, and their correlation with their neighbours in a
    sequence of data (m,)."""
    figure, (spread, neighbours) = new_figure(columns=2, height=3.6)
    bins, lags = np.linspace(-6, 6, 61), np.arange(1, LAGS + 1)
    for fit, colour, label in shown:
        left = fit.residuals[: len(fit.runs[0].data)]
        left = left if sequence is None else left[sequence]
        spread.hist(np.clip(left, -6, 6), bins, density=True, histtype="step", color=colour, label=label)
        neighbours.plot(lags, [float(left[:-k] @ left[k:]) / float(left @ left) for k in lags], ".-", color=colour)
    spread.plot(bins, np.exp(-(bins**2) / 2) / np.sqrt(2 * np.pi), color=COLOURS["reference"], label="noise alone")
    spread.set(xlabel="residual over noise", ylabel="probability density")
    for bound in (-1.96, 1.96):
        neighbours.axhline(bound / np.sqrt(len(left)), color=COLOURS["reference"], linestyle="--")
    neighbours.set(xlabel="lag", ylabel="autocorrelation")
    spread.legend(fontsize=8)
    return figure
