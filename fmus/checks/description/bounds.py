"""Minimum, maximum, nominal and start values of numeric variables."""

import math

import numpy as np

from fmus.checks.checked_fmu import CheckedFmu
from fmus.checks.model import INTEGERS, Variable
from fmus.checks.problem import Problem
from fmus.checks.settings import start_values

STAGE = "description"


def check(fmu: CheckedFmu) -> list[Problem]:
    """Bounds in the wrong order, start values outside, numbers that are none."""
    return [problem for variable in fmu.model.variables for problem in _problems(fmu, variable)]


def _problems(fmu: CheckedFmu, v: Variable) -> list[Problem]:
    if not v.real and v.type not in (*INTEGERS, "Enumeration"):
        return []
    if math.isnan(v.low) or math.isnan(v.high) or math.isnan(v.nominal):
        return [fmu.error("bounds", "a bound or the nominal value is not a number", v.name, "2.2.7", "2.4.7.5")]
    if v.low > v.high:
        return [fmu.error("bounds", f"min {v.low:g} is above max {v.high:g}", v.name, "2.2.7", "2.4.7.5")]
    if v.nominal == 0:
        return [
            fmu.warning(
                "bounds",
                "the nominal value is zero, so that no tolerance can be derived from it",
                v.name,
                "2.2.7",
                "2.4.7.5",
            )
        ]
    start = start_values(v, len(str(v.start).split()) if v.start is not None else 0)
    if start is None:
        return []
    if v.real and np.isnan(start.astype(float)).any():
        return [fmu.warning("bounds", "the start value is not a number", v.name, "2.2.7", "2.4.7.5")]
    if (start < v.low).any():
        return [fmu.error("bounds", f"min {v.low:g} is above start {start.min():g}", v.name, "2.2.7", "2.4.7.5")]
    if (start > v.high).any():
        return [fmu.error("bounds", f"start {start.max():g} is above max {v.high:g}", v.name, "2.2.7", "2.4.7.5")]
    return []
