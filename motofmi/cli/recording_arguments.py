"""Options of the commands that read recordings: files, names of columns, the band, figure and report."""

import argparse
from dataclasses import dataclass
from pathlib import Path

from fmus.support.errors import InputError
from motofmi.cli.arguments import mapping_of
from motofmi.cli.outputs import FIGURES, output_file
from motofmi.frequency_response.estimators import REFERENCES
from motofmi.recordings.formats import supported


def add_arguments(parser: argparse.ArgumentParser, files: str = "+") -> None:
    parser.add_argument(
        "files", nargs=files, metavar="FILE", help=f"recordings, one run each, of the formats {supported()}"
    )
    parser.add_argument("--map", dest="mapping", action="append", default=[], metavar="COLUMN=VARIABLE",
                        help='another name for a column, with its unit where the file has none: "Torque=steer_torque '
                             '[N.m]"')  # fmt: skip
    parser.add_argument(
        "--rate",
        type=float,
        metavar="HZ",
        help="sampling rate [Hz] to which faster recordings are reduced while they are read",
    )
    parser.add_argument("--rig", metavar="FILE", help="rig.json (default: the one beside the first recording)")
    parser.add_argument("--reference", choices=REFERENCES, default="",
                        help="reference signal of the cross-spectra (default: the commanded angle where it was "
                             "recorded, else the steer angle; the papers took the torque)")  # fmt: skip
    parser.add_argument(
        "--band", default="0.5:12", metavar="LOW:HIGH", help="frequency band [Hz] (default: %(default)s)"
    )
    parser.add_argument(
        "--width",
        type=float,
        metavar="HZ",
        help="bandwidth of the spectral averages [Hz] (default: 0.25, more for recordings under 48 s)",
    )
    parser.add_argument("--plot", metavar="FILE", type=output_file(*FIGURES), help="figure, as .png, .svg or .pdf")
    parser.add_argument("--report", metavar="FILE.html", type=output_file(), help="HTML report")


@dataclass(frozen=True)
class Options:
    """What the options mean: names of columns, and the band [Hz]."""

    mapping: dict[str, str]
    band: tuple[float, float]


def checked(options: argparse.Namespace) -> Options:
    """The options' meaning. Raises InputError for what is wrong with them."""
    if options.rig and not Path(options.rig).exists():
        raise InputError(f"cannot read {options.rig}: no such file")
    if options.width is not None and not options.width > 0:
        raise InputError(f"--width {options.width:g} Hz is not positive")
    return Options(mapping_of(options.mapping), limits(options.band, "--band"))


def limits(text: str, what: str) -> tuple[float, float]:
    """`LOW:HIGH` as numbers. Raises InputError for what is none."""
    try:
        low, high = (float(part) for part in text.split(":"))
    except ValueError:
        low, high = 1.0, 0.0
    if not 0 <= low < high:
        raise InputError(f"{what} {text!r} is not LOW:HIGH with LOW below HIGH, as in 0.5:12")
    return low, high
