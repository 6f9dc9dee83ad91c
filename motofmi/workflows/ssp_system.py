"""A system of FMUs in an SSP archive, in place of a vehicle and its devices."""

from collections.abc import Mapping
from pathlib import Path
from typing import TypeGuard

from fmus.cosimulation.ssp import SspSystem, read_ssp
from fmus.cosimulation.subsystems.stated_units import warn_of_missing_units
from fmus.support.errors import InputError


def whole_system(ssp: str | Path | None, vehicle: object, device: object) -> TypeGuard[str | Path]:
    """Whether a system is given. Raises InputError when it is given beside a vehicle or a device."""
    if ssp is not None and not (vehicle is None and device is None):
        raise InputError(f"{ssp} is a whole system: it takes neither vehicle nor device; change the FMUs in it")
    return ssp is not None


def open_system(path: str | Path, changed: Mapping[str, float] | None = None, units: Mapping[str, str] | None = None,
                speed: float | None = None) -> SspSystem:  # fmt: skip
    """The system of an archive, initialised: a context manager.

    changed replaces values by `fmu.variable`, or by a variable that one FMU has; speed [m/s] is that of the FMU with an
    input `speed`. Raises InputError as `fmus.cosimulation.ssp.read_ssp` does; warns of units that are missing.
    """
    system = read_ssp(path, {**(changed or {}), **({} if speed is None else {"speed": speed})}, units)
    warn_of_missing_units(system.fmus)
    return system
