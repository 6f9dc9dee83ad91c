"""Sentences and tables of the gap reports, from the contents of `verdict.json`."""

from typing import Any

import numpy as np

from motofmi.reports.charts import SEQUENCE, Axis, Chart, Curve, Panel
from motofmi.reports.gap_summary import error_text, nearest, next_run, value_text
from motofmi.reports.report import Section, Table

# The keys of `gap` in words.
RUNS = {
    "before": "fitted runs, before",
    "after": "fitted runs, after",
    "holdout_before": "validation runs, before",
    "holdout_after": "validation runs, after",
}


HOW_TO_READ = (
    "Reduced chi-square 1 is consistent with the noise. An effect is preferred to another where its BIC is smaller: "
    "a delta "
    "BIC above 10 is strong evidence. The closable misfit is what a flexible regression of the same data explains "
    "beyond the base."
)


ON_BLOCKS = (
    "These models were compared on blocks of their residuals, and that decides: delta BIC only orders the candidates. "
    "The loss is the mean logarithm of a block's mean square, smaller by 0.1 where the rms is smaller by 5 %."
)


def verdict_section(result: dict[str, Any], *more: Table) -> Section:
    """A sentence for each effect, the next experiment, the limitations, and the parameters found."""
    said = [*(e["sentence"] for e in result["effects"]), *nearest(result)]
    if result["tied"]:
        said.append(f"The data do not decide between {', '.join(result['tied'])}.")
    if proposed := next_run(result):
        said.append(f"Next experiment: {proposed}")
    said += result["limitations"]
    return Section("Verdict", said or ["Nothing is missing."], [], [_effects(result), *more])


def statistics_section(result: dict[str, Any]) -> Section:
    """The candidates that reduce chi-square, and how to read their numbers; folded."""
    tables = [table for table in (candidates(result), compared(result)) if table.rows]
    said = [HOW_TO_READ, *([ON_BLOCKS] if result.get("compared") else [])]
    return Section("Candidates and their statistics", said, [], tables, folded=True)


MODES_SHOWN = {"before": "without", "after": "with, at rest", "in_motion": "with, describing function"}
STYLES = {"before": "dashed", "after": "line", "in_motion": "dotted"}


def modes_over_speed(result: dict[str, Any]) -> Section:
    """The vehicle's modes without and with the effect, if the verdict contains them."""
    modes = result.get("modes")
    if not modes:
        return Section("Effect on the modes", ["No effect was named: the modes do not change."])
    shown = {label: heading for label, heading in MODES_SHOWN.items() if label in modes}
    every = [
        (mode.replace("_", "-"), f"{speed:g}", *(_mode(modes[label][mode], i) for label in shown))
        for mode in modes["before"]
        for i, speed in enumerate(modes["speed"])
    ]
    rows = [row for row in every if any("Hz" in cell for cell in row[2:])]
    said = [
        "Frequency and damping ratio without and with the effects found. At rest, friction, backlash and other effects "
        "that depend on the amplitude are linearised there."
    ]
    if "in_motion" in modes:
        said.append(
            "By describing functions they are linearised in the least-squares sense over the motion of the fitted "
            "runs; at smaller amplitudes they are nearer to rest."
        )
    if still := [mode for mode in modes["before"] if mode.replace("_", "-") not in {row[0] for row in rows}]:
        said.append(f"Without oscillation or absent at all of these speeds: {', '.join(still).replace('_', '-')}.")
    figures = [(_modes_chart(modes, shown), "Modes over speed; a mode is drawn where it oscillates.")] if rows else []
    return Section("Effect on the modes", said, figures, [Table(("mode", "speed [m/s]", *shown.values()), rows)])


def _modes_chart(modes: dict[str, Any], shown: dict[str, str]) -> Chart:
    """Frequency and damping ratio over speed, a colour for each mode and a style for each linearisation."""
    panels = []
    for quantity, unit in (("frequency", "Hz"), ("damping_ratio", "1")):
        curves = []
        for colour, mode in zip(SEQUENCE, modes["before"], strict=False):
            for label, heading in shown.items():
                values = np.array(modes[label][mode][quantity], float)
                swings = np.isfinite(np.array(modes[label][mode]["damping_ratio"], float))
                if swings.any():
                    curves.append(
                        Curve(
                            f"{mode.replace('_', '-')}, {heading}",
                            modes["speed"],
                            np.where(swings, values, np.nan),
                            colour,
                            STYLES[label],
                        )
                    )
        panels.append(Panel(Axis("speed", "m/s"), Axis(quantity.replace("_", " "), unit), curves, height=320))
    return Chart(panels, columns=2, linked=True)


def _mode(mode: dict[str, Any], i: int) -> str:
    frequency, ratio = (mode[word][i] for word in ("frequency", "damping_ratio"))
    if frequency is None or frequency != frequency:
        return "absent"
    return "no oscillation" if ratio is None or ratio != ratio else f"{frequency:.3f}\u00a0Hz, {ratio:.4f}"


def _effects(result: dict[str, Any]) -> Table:
    """The effects found with their parameters."""
    rows = [(e["name"], e["form"], n, value_text(p), error_text(p), p["unit"])
            for e in result["effects"] for n, p in e["parameters"].items()]  # fmt: skip
    return Table(("effect", "form", "parameter", "value", "standard error", "unit"), rows)


def candidates(result: dict[str, Any], most: int | None = None) -> Table:
    """The candidates that reduce chi-square, at most so many, with what each closes alone on validation runs.

    The probability follows from the delta BIC and assumes residuals that are independent. Models are compared on blocks
    where they are not; the table then has no probability.
    """
    independent = not result.get("compared")
    rows = [(c["name"], c["form"], f"{c['delta_chi2']:.1f}", f"{c['delta_bic']:.1f}",
             *([f"{c['probability']:.3f}"] if independent else []), _percent(c.get("validation")))
            for c in result["candidates"][:most] if c["delta_chi2"] > 0]  # fmt: skip
    chance = ["probability"] if independent else []
    return Table(
        ("candidate", "form", "delta chi-square", "delta BIC", *chance, "closed on validation runs [%]"), rows
    )


def compared(result: dict[str, Any]) -> Table:
    """The models that were compared on blocks, the least loss first, and what became of them; no rows where none
    were."""
    rows = [(" and ".join(f"{e['name']} ({e['form']})" for e in m["effects"]) or "base", f"{m['loss_fitted']:.2f}",
             "" if m["loss_validation"] is None else f"{m['loss_validation']:.2f}",
             _percent(m["closed"] and m["closed"]["share"]), m["standing"])
            for m in result.get("compared", [])]  # fmt: skip
    return Table(
        ("compared on blocks", "log loss, fitted runs [1]", "log loss, validation runs [1]",
         "closable misfit closed [%]", "outcome"), rows
    )  # fmt: skip


def _percent(share: float | None) -> str:
    return "" if share is None else f"{100 * share:.1f}"


# The directions of an imposed motion, by the unit of their range.
DIRECTIONS = {"rad": "side", "m": "side", "rad/s": "turning", "m/s": "moving", "Hz/s": "sweep", "1": "asymmetry"}


def axis_of(axis: str, order: int | None, unit: str) -> str:
    """The axis of a place in words."""
    if axis.endswith("direction"):
        return f"{axis}, {DIRECTIONS.get(unit, unit)}"
    return axis if order is None or axis.endswith("order") else f"{axis}, order {order}"


def places(result: dict[str, Any], axis: str = "axis", most: int = 40) -> Table:
    """Where the base deviates from the data, the most significant first; axis is the heading of the second column."""
    rows = [(p["run"], axis_of(p["axis"], p["order"], p["unit"]), f"{p['from']:.3g}", f"{p['to']:.3g}", p["unit"],
             f"{p['excess']:.3g}", _small(p["p_value"]))
            for p in result["where"][:most]]  # fmt: skip
    return Table(("run", axis, "from", "to", "unit", "excess", "p"), rows)


def _small(p_value: float) -> str:
    """A p-value as text; a value that underflows is given as an upper bound."""
    return f"{p_value:.1g}" if p_value > 0 else "< 1e-300"


def before_and_after(result: dict[str, Any]) -> Table:
    """Reduced chi-square and rms of the fitted and of the validation runs."""
    gap = result["gap"]
    rows = [(label, f"{gap[n]:.3f}", "" if gap["rms"][n] is None else f"{gap['rms'][n]:.4g}")
            for n, label in {**RUNS, "noise_floor": "noise floor"}.items() if gap[n] is not None]  # fmt: skip
    return Table(("runs", "reduced chi-square [1]", f"rms [{gap['rms']['unit']}]"), rows)
