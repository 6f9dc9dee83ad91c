"""Options shared by several commands: vehicle, devices at its ports, FMU archives in their place, parameter values."""

import argparse
from collections.abc import Sequence

from motofmi.cli.arguments import separate
from motofmi.workflows.components import ComponentLike
from motofmi.workflows.parts import with_archives

VEHICLE = "sharp_1971"
DEVICE = (
    "rider:NAME, damper:NAME, damper:VALUE [N.m.s/rad], a .toml, a comma list of devices that act together, or none"
)


def add_vehicle(parser: argparse.ArgumentParser) -> None:
    """Add `--vehicle`."""
    parser.add_argument(
        "--vehicle", help=f"a motorcycle: a NAME of motofmi list, or a .toml (default: {VEHICLE})"
    )


def vehicle_and_devices(
    arguments: argparse.Namespace, devices: str | None, usual: Sequence[ComponentLike | None]
) -> tuple[ComponentLike | None, list[ComponentLike | None] | None]:
    """The vehicle and the devices of `--vehicle`, a `--device` and `--fmu`; the `usual` devices where none is given.

    Beside `--ssp` only what is given: a system of FMUs takes neither.
    """
    held: list[ComponentLike | None] = [*separate(devices)] if devices else []
    if arguments.ssp:
        return arguments.vehicle, [*held, *arguments.fmu] or None
    return with_archives(arguments.vehicle, held, arguments.fmu, (VEHICLE, usual))


def add_archives(parser: argparse.ArgumentParser) -> None:
    """Add `--fmu`, archives in place of the vehicle or of devices."""
    parser.add_argument("--fmu", action="append", default=[], metavar="PATH",
                        help="FMU as the vehicle or as a device; which of them it is follows from the handlebar port or "
                             "the roll port among its variables; beside --device all of them act together; repeatable")  # fmt: skip


def add_units(parser: argparse.ArgumentParser) -> None:
    """Add `--unit`, the units of variables whose unit an FMU does not state."""
    parser.add_argument("--unit", dest="units", action="append", default=[], metavar="VARIABLE=UNIT",
                        help="unit of a variable that has none in its FMU, as in handlebar_torque=N.m; "
                             "repeatable")  # fmt: skip


def add_ssp(parser: argparse.ArgumentParser) -> None:
    """Add `--ssp`, a system of FMUs in place of vehicle and device."""
    parser.add_argument(
        "--ssp", metavar="FILE.ssp", help="a system of FMUs (SSP 1.0 or 2.0) in place of vehicle and device"
    )


def add_settings(parser: argparse.ArgumentParser, of: str = "a parameter") -> None:
    """Add `--set`; `of` says in the help text whose parameters it sets."""
    parser.add_argument("--set", dest="settings", action="append", default=[], metavar="NAME=VALUE",
                        help=f"value of {of}; names, units and bounds are in the output of motofmi list --json -, "
                             "those of an FMU in its model description; repeatable")  # fmt: skip
