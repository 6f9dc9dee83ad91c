"""Options of the commands that read recordings: files, column names, frequency band, figure and report."""

import argparse
from dataclasses import dataclass
from pathlib import Path

from fmus.support.errors import InputError
from motofmi.cli.arguments import mapping_of
from motofmi.cli.outputs import FIGURES, output_file
from motofmi.frequency_response.estimators import REFERENCES
from motofmi.recordings.formats import supported


def add_arguments(parser: argparse.ArgumentParser, files: str = "+") -> None:
    """Add the options; `files` is the number of recordings as argparse takes it (`+` at least one, `*` any)."""
    parser.add_argument(
        "files", nargs=files, metavar="FILE", help=f"recordings, one run each, of the formats {supported()}"
    )
    parser.add_argument("--map", dest="mapping", action="append", default=[], metavar="COLUMN=VARIABLE",
                        help='variable that a column holds, with its unit where the file gives none, as in '
                             '"Torque=steer_torque [N.m]", and a minus where its sign is reversed, as in '
                             '"Torque=-steer_torque"; repeatable')  # fmt: skip
    parser.add_argument(
        "--rate",
        type=float,
        metavar="HZ",
        help="sampling rate [Hz] to which faster recordings are reduced while they are read",
    )
    parser.add_argument("--rig", metavar="FILE", help="rig.json (default: the one beside the first recording)")
    parser.add_argument("--reference", choices=REFERENCES, default="",
                        help="reference signal of the cross-spectra (default: the commanded angle where it was "
                             "recorded, else the steer angle; the published estimates use the torque)")  # fmt: skip
    parser.add_argument(
        "--band", default="0.5:12", metavar="LOW:HIGH", help="frequency band [Hz] (default: %(default)s)"
    )
    parser.add_argument(
        "--width",
        type=float,
        metavar="HZ",
        help="bandwidth of the spectral averages [Hz] (default: 0.25, larger for recordings shorter than 48 s)",
    )
    parser.add_argument("--plot", metavar="FILE", type=output_file(*FIGURES), help="figure, as .png, .svg or .pdf")
    parser.add_argument("--report", metavar="FILE.html", type=output_file(), help="HTML report")


@dataclass(frozen=True)
class Options:
    """The checked options: variable names by column name, and the frequency band [Hz]."""

    mapping: dict[str, str]
    band: tuple[float, float]


def checked(options: argparse.Namespace) -> Options:
    """The options, checked. Raises InputError for a missing rig file, a width that is not positive, or a wrong band."""
    if options.rig and not Path(options.rig).exists():
        raise InputError(f"cannot read {options.rig}: no such file")
    if options.width is not None and not options.width > 0:
        raise InputError(f"--width {options.width:g} Hz is not positive")
    return Options(mapping_of(options.mapping), limits(options.band, "--band"))


def limits(text: str, what: str) -> tuple[float, float]:
    """The two numbers of `LOW:HIGH`. Raises InputError unless 0 <= LOW < HIGH."""
    try:
        low, high = (float(part) for part in text.split(":"))
    except ValueError:
        low, high = 1.0, 0.0
    if not 0 <= low < high:
        raise InputError(f"{what} {text!r} is not LOW:HIGH with LOW below HIGH, as in 0.5:12")
    return low, high
