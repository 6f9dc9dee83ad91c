"""The first lines of a gap's report, from the contents of `verdict.json`: the verdict in one sentence, the law that was
found with its values, and the misfit before and after."""

from collections.abc import Mapping
from math import floor, log10
from typing import Any

import numpy as np
from scipy.sparse.csgraph import connected_components

from fmus.declaration.units import written

SHOWN = 5  # models of a tie that are shown
BAR = 40  # characters of the longer bar
DIGITS, MOST_DIGITS = 4, 10  # of a value
# What a reader who does not know the verdicts' names reads instead of them.
BEGINNINGS = {"named": "An effect is missing: ", "tied": "An effect is missing, but ", "none": "No effect is missing: ",
              "unknown": ""}  # fmt: skip


def answer(result: dict[str, Any]) -> str:
    """The verdict as the first sentence of a report."""
    verdict, _, sentence = headline(result).partition(": ")
    beginning = "Effects are missing: " if len(result["effects"]) > 1 else BEGINNINGS[verdict]
    said = beginning + sentence
    return said[0].upper() + said[1:] + "."


def headline(result: dict[str, Any]) -> str:
    """The verdict in one sentence: what is missing, the share of the closable misfit that it closes, what is left."""
    if result["verdict"] == "named":
        return "named: " + " and ".join(map(_placed, result["effects"])) + _closed(result) + _left(result)
    if result["verdict"] == "tied":
        return "tied: the data do not decide between " + ", ".join(result["tied"]) + _closed(result) + _left(result)
    if result["verdict"] == "none":
        return f"none: the model is {_sufficient(result)}{_left(result)}"
    if result["ended"]:
        return "unknown: the search was ended before its verdict" + _left(result)
    if result["disagreement"]:
        return "unknown: the fitted and the validation runs disagree on the base" + _left(result)
    return "unknown: the model is not sufficient, and none of the library is named" + _left(result)


def _sufficient(result: dict[str, Any]) -> str:
    """Why nothing is missing: the noise, or the tolerance, which the option replaces."""
    if result["complete"]:
        return "consistent with the noise"
    share, tolerance = result["remainder"]["share"], result["criteria"]["tolerance"]
    within = share is not None and share <= tolerance
    return f"sufficient within the tolerance of {tolerance:.3g} (--tolerance)" if within else "sufficient"


def _placed(effect: dict[str, Any]) -> str:
    """The name of an effect, with the element at which it acts where the component has several for it."""
    element = effect["element"]
    named = element and effect["form"].endswith(f"_{element.replace(' ', '_')}")
    return f"{effect['name']} ({element})" if named else effect["name"]


def _closed(result: dict[str, Any]) -> str:
    """The share of the closable misfit that is closed on validation runs or, without them, on left-out blocks of the
    fitted runs, with its 95 % interval."""
    share = result["explained"]
    if share is None:
        return ""
    validated = result["gap"]["rms"]["holdout_after"] is not None
    where = "validation runs" if validated else "left-out blocks of the fitted runs"
    several = len(result["effects"]) > 1
    if share["share"] <= 0:
        return f"; on {where} {'they close' if several else 'it closes'} nothing of the closable misfit"
    interval = f"[{share['low']:.1%}, {share['high']:.1%}]"
    closes = "they close" if several else f"{_beside(result)}closes"
    return f"; {closes} {share['share']:.1%} {interval} of the closable misfit on {where}"


def _beside(result: dict[str, Any]) -> str:
    """Where an effect is named that the best of several pairs has in common, the other effect of that pair: shares and
    rms refer to both."""
    named = {effect["name"] for effect in result["effects"]}
    others = [e["name"] for model in result["alternatives"][:1] for e in model["effects"] if e["name"] not in named]
    return f"with {' and '.join(others)}, one of several possible second effects, it " if named and others else ""


def _left(result: dict[str, Any]) -> str:
    """The rms of the residuals, and its share of the measured rms."""
    left = result["remainder"]
    share = "" if left["share"] is None else f", {left['share']:.2%} of the measured rms"
    return f"; {left['rms']:.3g} {left['unit']} (rms) is left{share}"


def nearest(result: dict[str, Any]) -> list[str]:
    """Where nothing is named, the reason; where the verdict is unknown, the nearest model of the library, and the misfit with it; where the
    runs disagree on the base, the value that differs. Where it is tied, the models of the tie with their values, and
    where the misfit is within the tolerance, the model that would reduce it."""
    if result["disagreement"]:
        return [result["disagreement"]]
    if result["verdict"] == "none":
        within = [f"not named, within the tolerance: {_alternative(each)}; --tolerance 0 compares it with the base"
                  for each in result["alternatives"]]  # fmt: skip
        return [*([result["reason"]] if result["reason"] else []), *within]
    if result["verdict"] != "unknown":
        shown, rest = result["alternatives"][:SHOWN], len(result["alternatives"][SHOWN:])
        more = [f"possible: {rest} more, in `alternatives` of verdict.json"] if rest else []
        return [*(f"possible: {_alternative(each)}" for each in shown), *more]
    lines = [result["reason"]] if result["reason"] else []
    if not result["closest"]:
        return lines
    rms, [near] = result["gap"]["rms"], result["alternatives"] or [None]
    name = " and ".join(e["name"] for e in near["effects"]) if near else result["closest"]["name"]
    if rms["after"] >= rms["before"]:
        said = (
            f"Nearest in the library: {name}. It does not reduce the rms of the misfit, "
            f"{rms['before']:.3g} {rms['unit']}."
        )
    else:
        said = (
            f"Nearest in the library: {name}{_closed(result)}. The best candidate reduces the misfit of the fitted "
            f"runs from {rms['before']:.3g} to {rms['after']:.3g} {rms['unit']} (rms)."
        )
    return [*lines, said, *([f"values: {_effects_with_values(near)}"] if near else [])]


def _alternative(model: dict[str, Any]) -> str:
    """A model that is not named, in one line: its effects with their values, and the share that it closes."""
    closed = model["closed"]
    share = "" if closed is None else f"; closes {max(closed, 0.0):.1%} of the closable misfit"
    return _effects_with_values(model) + share


def _effects_with_values(model: dict[str, Any]) -> str:
    effects = [f"{e['name']} ({e['form']})" + (f": {_values(e)}" if e["parameters"] else "") for e in model["effects"]]
    return "; and ".join(effects)


def laws(result: dict[str, Any]) -> list[str]:
    """A line for each effect that was found: its equations, and the values of its parameters with standard errors."""
    lines = []
    for effect in result["effects"]:
        law = "; ".join(effect["equations"]) or effect["sentence"].rstrip(".")
        nearest_form = "nearest form: " if effect["form"] == "open" else ""
        lines.append(
            f"{_placed(effect)}: {nearest_form}{law}" + (f", {_values(effect)}" if effect["parameters"] else "")
        )
    return lines


def _values(effect: dict[str, Any]) -> str:
    return ", ".join(_value(n, p) for n, p in effect["parameters"].items())


def _value(name: str, parameter: dict[str, Any]) -> str:
    return f"{name} = {written(f'{value_text(parameter)} +- {error_text(parameter)}', parameter['unit'])}"


def value_text(parameter: Mapping[str, Any]) -> str:
    """The value of a parameter with four digits, or with as many as its standard error of two digits determines."""
    value, error = parameter["value"], parameter["standard_error"]
    determined = floor(log10(abs(value))) - floor(log10(error)) + 2 if value and error else 0
    return f"{value:.{min(max(determined, DIGITS), MOST_DIGITS)}g}"


def error_text(parameter: Mapping[str, Any]) -> str:
    """The standard error of a parameter; infinite for one without influence on the data."""
    error = parameter["standard_error"]
    return "inf" if error is None else f"{error:.2g}"


def next_run(result: dict[str, Any]) -> str:
    """The next experiment with what it is expected to distinguish; empty where there is none."""
    proposed = result["next_experiment"]
    if not proposed:
        return ""
    said, worth = proposed["sentence"], result["criteria"]["further_run_delta_chi2"]
    apart = {(r["truth"], r["rival"]): r["delta_chi2"] for r in proposed.get("rivals", [])}
    least = {pair: min(value, apart[pair[::-1]]) for pair, value in apart.items()}
    clear = [value for value in least.values() if value >= worth]
    if not clear or len(clear) == len(least):
        return f"{said} Expected delta chi-square: {proposed['expected_delta_chi2']:.3g}."
    names = sorted({name for pair in least for name in pair})
    _, group_of = connected_components(np.array([[least.get((a, b), worth) < worth for b in names] for a in names]))
    groups = [[n for n, group in zip(names, group_of, strict=True) if group == k] for k in sorted(set(group_of))]
    alike = "; ".join(", ".join(group) for group in groups if len(group) > 1)
    return f"{said} Expected delta chi-square: {min(clear):.3g}, except between {alike}: these it does not distinguish."


def bars(result: dict[str, Any]) -> list[str]:
    """The misfit before and after as bars of text: on the validation runs, else on the fitted ones."""
    rms = result["gap"]["rms"]
    where = "fitted" if rms["holdout_before"] is None else "validation"
    before, after = (
        rms[key] for key in (("before", "after") if where == "fitted" else ("holdout_before", "holdout_after"))
    )
    longest = max(before, after)
    if not longest > 0:
        return []
    return [f"{label:<7}{'#' * max(round(BAR * value / longest), 1):<{BAR + 1}} "
            f"{value:.3g} {rms['unit']} (rms, {where} runs)"
            for label, value in (("before", before), ("after", after))]  # fmt: skip
