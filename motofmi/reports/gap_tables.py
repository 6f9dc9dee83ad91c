"""What every report of the gap workflow says in words and tables, from the contents of `verdict.json`."""

from typing import Any

from scenarios.report import Section, Table


def headline(result: dict[str, Any]) -> str:
    """The verdict in one line."""
    return {
        "named": "named: " + " and ".join(e["name"] for e in result["effects"]),
        "none": "none: the model is as good as the noise",
        "tied": "tied: these data cannot tell apart " + ", ".join(result["tied"]),
        "unknown": "unknown: something is missing, and nothing in the library is it",
    }[result["verdict"]]


def nearest(result: dict[str, Any]) -> list[str]:
    """Of something unknown, in a sentence, what in the library comes nearest and what is left then."""
    if not result["closest"]:
        return []
    rms = result["gap"]["rms"]
    return [f"Nearest in the library: {result['closest']['name']}. "
            f"The best that was tried takes what is missed from {rms['before']:.3g} to {rms['after']:.3g} {rms['unit']} (rms)."]  # fmt: skip


def verdict_section(result: dict[str, Any], *more: Table) -> Section:
    """The verdict, what was found in a sentence each, the next experiment, limitations; parameters and candidates."""
    said = [headline(result), *(e["sentence"] for e in result["effects"]), *nearest(result)]
    if result["next_experiment"]:
        proposed = result["next_experiment"]
        said.append(f"Next experiment: {proposed['sentence']} Expected delta chi-square: {proposed['expected_delta_chi2']:.3g}.")
    return Section("Verdict", [*said, *result["limitations"]], [], [*_effects_and_candidates(result), *more])


MODES_SHOWN = {"before": "without", "after": "with, at rest", "in_motion": "with, in motion"}


def modes_over_speed(result: dict[str, Any]) -> Section:
    """What the effect does to the vehicle's modes, where the verdict has them."""
    modes = result.get("modes")
    if not modes:
        return Section("What it does to the modes", ["Nothing was named, so nothing changes."])
    shown = {label: heading for label, heading in MODES_SHOWN.items() if label in modes}
    rows = [(mode.replace("_", "-"), f"{speed:g}", *(_mode(modes[label][mode], i) for label in shown)) for mode in modes["before"] for i, speed in enumerate(modes["speed"])]
    said = ["Frequency and damping ratio without and with what was found. At rest friction, play and whatever else depends on the amplitude count with their slope there."]
    if "in_motion" in modes:
        said.append("In motion they count as they do, in the mean square, in the motion of the fitted runs; smaller motion is nearer to rest.")
    return Section("What it does to the modes", said, [], [Table(("mode", "speed [m/s]", *shown.values()), rows)])


def _mode(mode: dict[str, Any], i: int) -> str:
    frequency, ratio = (mode[word][i] for word in ("frequency", "damping_ratio"))
    if frequency is None or frequency != frequency:
        return "absent"
    return "no oscillation" if ratio is None or ratio != ratio else f"{frequency:.3f} Hz, {ratio:.4f}"


def _effects_and_candidates(result: dict[str, Any]) -> list[Table]:
    """What was found with its parameters, and all candidates that gain."""
    effects = [(e["name"], e["form"], n, f"{p['value']:.5g}", f"{p['standard_error']:.2g}", p["unit"]) for e in result["effects"] for n, p in e["parameters"].items()]
    candidates = [(c["name"], c["form"], f"{c['delta_chi2']:.1f}", f"{c['delta_bic']:.1f}", f"{c['probability']:.3f}")
                  for c in result["candidates"] if c["delta_chi2"] > 0]  # fmt: skip
    tables = [Table(("effect", "form", "parameter", "value", "standard error", "unit"), effects),
              Table(("candidate", "form", "delta chi-square", "delta BIC", "probability"), candidates)]  # fmt: skip
    return [table for table in tables if table.rows]


# What an imposed motion's directions are, by the unit of the range that says which.
DIRECTIONS = {"rad": "side", "m": "side", "rad/s": "turning", "m/s": "moving", "Hz/s": "sweep", "1": "one side unlike the other"}


def axis_of(axis: str, order: int | None, unit: str) -> str:
    """The axis of a place in words."""
    if axis.endswith("direction"):
        return f"{axis}, {DIRECTIONS.get(unit, unit)}"
    return axis if order is None or axis.endswith("order") else f"{axis}, order {order}"


def places(result: dict[str, Any], axis: str = "axis", most: int = 40) -> Table:
    """Where the base misses the data, the clearest first; axis is what is said of a place beside its ends."""
    rows = [(p["run"], axis_of(p["axis"], p["order"], p["unit"]), f"{p['from']:.3g}", f"{p['to']:.3g}", p["unit"], f"{p['excess']:.3g}", _small(p["p_value"]))
            for p in result["where"][:most]]  # fmt: skip
    return Table(("run", axis, "from", "to", "unit", "excess", "p"), rows)


def _small(p_value: float) -> str:
    """A p-value; one that is too small for a number is less than any."""
    return f"{p_value:.1g}" if p_value > 0 else "< 1e-300"


def before_and_after(result: dict[str, Any]) -> Table:
    """Reduced chi-square and rms of the fitted and of the held-out runs."""
    gap = result["gap"]
    rows = [(n.replace("_", " "), "" if gap[n] is None else f"{gap[n]:.3f}", "" if gap["rms"][n] is None else f"{gap['rms'][n]:.4g}")
            for n in ("before", "after", "holdout_before", "holdout_after", "noise_floor")]  # fmt: skip
    return Table(("", "reduced chi-square", f"rms [{gap['rms']['unit']}]"), rows)
