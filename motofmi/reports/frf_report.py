"""The report of frequency response functions: modulus and phase with every run, coherence, and a table of the bands."""

from collections.abc import Sequence
from pathlib import Path

import numpy as np

from motofmi.frequency_response.frf import FRF
from motofmi.frequency_response.roll_motion import RollFRF
from motofmi.reports.charts import SEQUENCE, Axis, Chart, Curve, Panel
from motofmi.reports.report import Report, Section, Table

INERTANCE = "(rad/s2)/(N.m)"
FREQUENCY = Axis("frequency", "Hz")
COHERENT = (
    0.8  # coherence below which an answer says so: the standard error of a band of ten averages is then over 10 %
)


def frf_report(each: Sequence[FRF], mean: FRF, warnings: Sequence[str], inputs: Sequence[Path]) -> Report:
    """The report of the FRFs of runs and of their mean."""
    runs = f"{len(each)} runs" if len(each) > 1 else f"the run {each[0].name}"
    sections = [
        Section("Coherence", [COHERENCE_SAYS], [(coherence(each, mean), "Coherence of each run over frequency.")]),
        Section("Nyquist plane", [NYQUIST_SAYS], [(nyquist(each, mean), "Inertance in the Nyquist plane.")]),
        Section("Bands of frequency", [BANDS_SAY.format(mean.reference)], [], [bands(mean)]),
        *([Section("Runs", [], [], [runs_table(each)])] if len(each) > 1 else []),
    ]
    return Report(
        "Frequency response function", answer(mean, len(each)), sections, warnings=warnings, inputs=inputs,
        asked=f"What is the inertance of rider and handlebar, from {runs} of the steer test?",
        figures=[(amplitude_and_phase(each, mean), f"Modulus and phase of the inertance; the band is {spread(mean)}.")],
    )  # fmt: skip


COHERENCE_SAYS = (
    "The coherence is the share of the torque's power that a linear relation to the motion explains. Below 1 there "
    "is noise, a torque of the rider's own (remnant), or a relation that is not linear."
)
NYQUIST_SAYS = "Each point is one band of frequency; a resonance is a loop, and where runs differ their loops differ."
BANDS_SAY = (
    "Cross-spectra with {}. The 95 % interval is that of the estimate; the standard deviation is that over the runs, "
    "if there are several."
)


def answer(mean: FRF, count: int) -> str:
    """Range of the inertance, its spread and the coherence in one sentence."""
    modulus, lowest = np.abs(mean.inertance), int(np.argmin(mean.coherence))
    share = np.median(_half(mean)[0] / modulus)
    of = (
        f"over {count} runs (median of the bands)"
        if mean.repeated.any()
        else "by the estimate's standard error (median of the bands)"
    )
    sentence = (
        f"From {mean.frequency[0]:g} to {mean.frequency[-1]:g} Hz the inertance is {modulus.min():.3g} to "
        f"{modulus.max():.3g} "
        f"{INERTANCE}, known to {share:.1%} {of}; the coherence is {mean.coherence[lowest]:.3f} or more"
    )
    low = mean.coherence < COHERENT
    return sentence + (
        f", below {COHERENT:g} in {low.sum()} of {len(low)} bands, lowest at {mean.frequency[lowest]:g} Hz."
        if low.any()
        else "."
    )


def spread(mean: FRF) -> str:
    """What the band of a figure is."""
    return (
        "one standard deviation over the runs"
        if mean.repeated.any()
        else "the 95 % confidence interval of the estimate"
    )


def _half(mean: FRF) -> tuple[np.ndarray, np.ndarray]:
    """Standard deviation over the runs, for a single run that of the estimate: of modulus and phase [rad] (n,)."""
    own = mean.confidence(1.0)
    return (
        np.where(mean.repeated, mean.modulus_deviation, own[0]),
        np.where(mean.repeated, mean.phase_deviation, own[1]),
    )


def phase(inertance: np.ndarray) -> np.ndarray:
    """The phase (n,) [deg] without jumps, near 90 deg, where the inertance of a passive device lies."""
    unwrapped = np.degrees(np.unwrap(np.angle(inertance)))
    return unwrapped - 360 * np.round(np.median(unwrapped - 90) / 360)


def amplitude_and_phase(
    each: Sequence[FRF], mean: FRF, more: tuple[Sequence[Curve], Sequence[Curve]] = ((), ())
) -> Chart:
    """Modulus above phase: the mean with its band, every run, and more curves of either."""
    modulus, angle = np.abs(mean.inertance), phase(mean.inertance)
    half = [
        np.minimum(h, 10 * np.nanmedian(modulus)) for h in mean.deviation
    ]  # a band without information must not scale the axis
    name = "mean of the runs" if len(each) > 1 else each[0].name
    style = {"colour": "measured", "style": "points"}
    first = [
        Curve(
            name,
            mean.frequency,
            modulus,
            band=(modulus - half[0], modulus + half[0]),
            **style,  # type: ignore[arg-type]
        )
    ]
    turn = np.degrees(half[1])
    second = [Curve(name, mean.frequency, angle, band=(angle - turn, angle + turn), **style)]  # type: ignore[arg-type]
    for k, run in enumerate(each if len(each) > 1 else ()):
        colour = colour_of_run(k)
        first.append(Curve(run.name, run.frequency, np.abs(run.inertance), colour, width=1.0, shown=not more[0]))
        second.append(Curve(run.name, run.frequency, phase(run.inertance), colour, width=1.0, shown=not more[0]))
    top = float(1.3 * np.percentile(modulus, 98))
    return Chart(
        [
            Panel(
                FREQUENCY,
                Axis("modulus of the inertance", INERTANCE, low=0.0, high=float(f"{top:.2g}")),
                [*first, *more[0]],
            ),
            Panel(FREQUENCY, Axis("phase of the inertance", "deg", low=-50, high=200), [*second, *more[1]], height=240),
        ],
        linked=True,
    )


def colour_of_run(k: int) -> str:
    """The colour of run k in all charts; the first colour is that of a fit."""
    return SEQUENCE[1:6][k % 5]


def coherence(each: Sequence[FRF], mean: FRF) -> Chart:
    """Coherence over frequency, a curve for each run."""
    curves = [
        Curve(run.name, run.frequency, run.coherence, colour_of_run(k), "both", width=1.2)
        for k, run in enumerate(each)
    ]
    lowest = min(float(np.floor(10 * min(r.coherence.min() for r in each)) / 10), COHERENT)
    return Chart([Panel(FREQUENCY, Axis("coherence", "1", low=max(lowest, 0.0), high=1.0), curves, height=240)])


def nyquist(each: Sequence[FRF], mean: FRF, more: Sequence[Curve] = ()) -> Chart:
    """Real against imaginary part, a curve for each run; the pointer shows the frequency."""
    several = len(each) > 1
    curves = [
        Curve(
            run.name,
            run.inertance.real,
            run.inertance.imag,
            colour_of_run(k) if several else "measured",
            "points",
            text=[f"{f:g} Hz" for f in run.frequency],
        )
        for k, run in enumerate(each)
    ]
    return Chart(
        [
            Panel(
                Axis("real part of the inertance", INERTANCE),
                Axis("imaginary part", INERTANCE),
                [*curves, *more],
                hover="point",
                square=True,
                height=380,
            )
        ]
    )


def bands(mean: FRF) -> Table:
    """The numbers of every band."""
    half, interval = _half(mean), mean.confidence()
    rows = [
        (
            f"{f:g}",
            f"{abs(z):.4g}",
            f"{s:.2g}",
            f"{c:.2g}",
            f"{a:.1f}",
            f"{np.degrees(t):.1f}",
            f"{np.degrees(u):.1f}",
            f"{k:.3f}",
            f"{n:.0f}",
        )
        for f, z, s, c, a, t, u, k, n in zip(
            mean.frequency,
            mean.inertance,
            half[0],
            interval[0],
            phase(mean.inertance),
            half[1],
            interval[1],
            mean.coherence,
            mean.runs,
            strict=True,
        )
    ]
    return Table(
        (
            "frequency [Hz]",
            f"modulus [{INERTANCE}]",
            f"standard deviation [{INERTANCE}]",
            f"95 % interval, half [{INERTANCE}]",
            "phase [deg]",
            "standard deviation [deg]",
            "95 % interval, half [deg]",
            "coherence [1]",
            "runs",
        ),
        rows,
    )


def runs_table(each: Sequence[FRF]) -> Table:
    """Frequencies, coherence and warnings of every run."""
    rows = [
        (
            f.name,
            f"{f.frequency[0]:g} to {f.frequency[-1]:g}",
            f"{np.median(f.coherence):.3f}",
            f"{f.coherence.min():.3f}",
            "; ".join(f.warnings) or "none",
        )
        for f in each
    ]
    return Table(("run", "frequencies [Hz]", "median coherence [1]", "lowest coherence [1]", "warnings"), rows)


def roll_chart(frf: RollFRF) -> Chart:
    """Amplitude and phase of FRF_i and rFRF_i at waist, shoulders and head (2008, Figs 16 to 23)."""
    panels = []
    for part, unit in (("modulus", "1"), ("phase", "deg")):
        for name, by_point in (("FRF", frf.absolute), ("rFRF", frf.relative)):
            curves = [
                Curve(
                    point,
                    frf.frequency,
                    np.abs(z) if part == "modulus" else np.degrees(np.unwrap(np.angle(z))),
                    colour,
                    "both",
                    width=1,
                )
                for (point, z), colour in zip(by_point.items(), SEQUENCE, strict=False)
            ]
            panels.append(Panel(FREQUENCY, Axis(f"{part} of {name}", unit), curves, height=260))
    return Chart(panels, columns=2, linked=True)
