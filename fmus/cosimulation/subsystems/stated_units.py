"""Units that a model description leaves out. Such a unit is unknown, which is not the unit [1]: the number is taken as
it is, with one warning, or the user states the unit."""

import warnings
from collections.abc import Mapping
from typing import Any

from fmpy.model_description import ModelVariable

from fmus.declaration.units import unit
from fmus.support.errors import InputError, unknown

ENDS = ("input", "output")
SHOWN = 8  # variables that a warning names


class MissingUnitsWarning(UserWarning):
    """Variables of an FMU have no unit."""


def described_unit(variable: ModelVariable) -> str:
    """The unit of a variable in the model description; an empty text where there is none."""
    return variable.unit or getattr(variable.declaredType, "unit", None) or ""


def stated_units(owner: str, variables: Mapping[str, ModelVariable], units: Mapping[str, str]) -> dict[str, str]:
    """The units that are stated for variables of an FMU by name.

    Raises InputError for a name that the FMU does not have, a unit that is unknown, and a unit that differs from that
    of the description.
    """
    for name, stated in units.items():
        if name not in variables:
            ends = (n for n, v in variables.items() if v.causality in ENDS)
            raise unknown(f"variable of {owner}", name, ends)
        unit(stated)
        described = described_unit(variables[name])
        if described and described != stated:
            raise InputError(
                f"{owner}.{name} has the unit [{described}] in its model description; it cannot be stated as [{stated}]"
            )
    return dict(units)


def by_fmu(units: Mapping[str, str], fmus: Mapping[str, Mapping[str, ModelVariable]]) -> dict[str, dict[str, str]]:
    """Units by FMU and variable, from units by `variable` or `fmu.variable`; fmus holds the variables of each FMU.

    Raises InputError for a name that none has, and for one that several have.
    """
    found: dict[str, dict[str, str]] = {name: {} for name in fmus}
    every = [f"{name}.{v}" for name, variables in fmus.items() for v in variables]
    for key, stated in units.items():
        matching = [key] if key in every else [full for full in every if full.partition(".")[2] == key]
        if not matching:
            ends = [f"{fmu}.{n}" for fmu, rows in fmus.items() for n, v in rows.items() if v.causality in ENDS]
            raise unknown("variable", key, ends if "." in key else {full.partition(".")[2] for full in ends})
        parts = [(name, variable) for name, _, variable in (full.partition(".") for full in matching)]
        without = [(name, variable) for name, variable in parts if not described_unit(fmus[name][variable])]
        for name, variable in without or parts:  # variables of one name meet at a port: one may have its unit
            found[name][variable] = stated
    return found


def warn_of_missing_units(fmus: Mapping[str, Any]) -> None:
    """One warning that lists the inputs and outputs of FMUs, by name, without a unit."""
    missing = [f"{name}.{v}" for name, fmu in fmus.items() for v in (*fmu.inputs, *fmu.outputs) if not fmu.unit_of(v)]
    if missing:
        named = f"{', '.join(missing[:SHOWN])}{f' and {len(missing) - SHOWN} more' if len(missing) > SHOWN else ''}"
        warnings.warn(
            f"no unit in the model description: {named}; the values are taken as they are; state a unit with "
            f"--unit {missing[0].partition('.')[2]}=UNIT (in Python: units={{...}})",
            MissingUnitsWarning,
            stacklevel=3,
        )
