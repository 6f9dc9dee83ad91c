"""The first lines of a report never contradict each other or the numbers, for any contents of `verdict.json`."""

import re

import numpy as np
import pytest

from motofmi.reports.gap_summary import bars, headline, laws, nearest

NAMES = ("coulomb_friction", "hysteresis", "drift")


def drawn(rng):
    """Contents with every combination of verdict, misfit before and after, share, and end of the search."""
    kind = str(rng.choice(["named", "tied", "none", "unknown"]))
    before, after, held_before, held_after = 10.0 ** rng.uniform(-4, 2, 4)
    held, share = rng.random() < 0.7, rng.uniform(-0.5, 1.0)
    parameters = {"friction_torque": {"value": 0.5, "standard_error": 0.01, "unit": "N.m"}}
    effect = {"name": NAMES[0], "form": str(rng.choice(["coulomb", "open"])), "sentence": "Dry friction.",
              "equations": ["force += friction_torque tanh(rate/sliding_rate)"] * int(rng.integers(2)), "parameters": parameters}  # fmt: skip
    return {
        "verdict": kind, "effects": [effect] if kind == "named" else [], "tied": list(NAMES[:2]) if kind == "tied" else [],
        "closest": {"name": NAMES[0], "delta_bic": 5.0} if kind == "unknown" and rng.random() < 0.8 else None,
        "complete": bool(rng.random() < 0.5) and kind in ("named", "none"),
        "ended": "The time budget of 60 s ended." if rng.random() < 0.3 else None,
        "explained": {"share": share, "low": share - 0.1, "high": share + 0.1} if held and kind != "none" else None,
        "remainder": {"rms": float(held_after if held else after), "share": float(rng.uniform(0, 1)), "unit": "rad", "nearest": None},
        "gap": {"rms": {"before": before, "after": after, "holdout_before": held_before if held else None,
                        "holdout_after": held_after if held else None, "unit": "rad"}},
    }  # fmt: skip


@pytest.mark.parametrize("seed", range(300))
def test_no_line_contradicts_the_numbers(seed):
    result = drawn(np.random.default_rng(seed))
    lines = [headline(result), *nearest(result), *laws(result), *bars(result)]
    text = "\n".join(lines)
    assert lines[0].startswith(result["verdict"])
    for a, b in re.findall(r"from (\S+) to (\S+) rad", text):
        assert float(b) <= float(a)
    for share in re.findall(r"closes (-?[\d.]+)%", text):
        assert float(share) >= 0
    if result["verdict"] == "unknown":  # an effect that closes most of the misfit is no absence of effects
        assert "no effect of the library" not in text and "nothing in the library" not in text
        assert ("ended" in lines[0]) == bool(result["ended"])
    if result["verdict"] == "none" and not result["complete"]:
        assert "noise" not in lines[0]
    assert (f"{result['remainder']['rms']:.3g} rad (rms) is left" in lines[0])


@pytest.mark.parametrize("seed", range(50))
def test_the_longer_bar_is_the_larger_misfit(seed):
    result = drawn(np.random.default_rng(seed))
    lengths = [line.count("#") for line in bars(result)]
    rms = result["gap"]["rms"]
    pair = ("before", "after") if rms["holdout_before"] is None else ("holdout_before", "holdout_after")
    before, after = (rms[key] for key in pair)
    assert lengths[0] >= lengths[1] if before >= after else lengths[1] >= lengths[0]


def test_the_law_stands_with_its_values_errors_and_units():
    result = drawn(np.random.default_rng(0)) | {"effects": [
        {"name": "coulomb_friction", "form": "coulomb", "sentence": "Dry friction.",
         "equations": ["force += friction_torque tanh(rate/sliding_rate)"],
         "parameters": {"friction_torque": {"value": 20.61, "standard_error": 0.42, "unit": "N"}}}]}  # fmt: skip
    assert laws(result) == [
        "coulomb_friction: force += friction_torque tanh(rate/sliding_rate), friction_torque = 20.61 +- 0.42 N"
    ]
