"""The options by which commands name a vehicle, devices at its ports, archives instead of them, and parameters."""

import argparse

VEHICLE = "sharp_1971"
DEVICE = (
    "rider:NAME, damper:NAME, damper:VALUE [N.m.s/rad], a .toml, a comma list of devices that act together, or none"
)


def add_vehicle(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        "--vehicle", default=VEHICLE, help="a motorcycle: a NAME of motofmi list, or a .toml (default: %(default)s)"
    )


def add_archives(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("--fmu", action="append", default=[], metavar="PATH",
                        help="an FMU instead of the vehicle or of the devices; its variables say which: the handlebar "
                             "port or the roll port")  # fmt: skip


def add_settings(parser: argparse.ArgumentParser, of: str = "a parameter") -> None:
    parser.add_argument("--set", dest="settings", action="append", default=[], metavar="NAME=VALUE",
                        help=f"change {of}; names, units and bounds as motofmi list --json gives them; "
                             "repeatable")  # fmt: skip
