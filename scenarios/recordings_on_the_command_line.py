"""What the commands that read recordings share: files, names of columns, the band, and the FRFs of the runs."""

import argparse
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from fmus.errors import InputError
from identification.frf import FRF, REFERENCES, band_width, estimate
from identification.recordings import Recording, read_recording, read_rig


def add_arguments(parser: argparse.ArgumentParser, files: str = "+") -> None:
    parser.add_argument("files", nargs=files, metavar="FILE", help="recordings, one run each: .csv, .mat, .uff, .mf4 or .parquet")
    parser.add_argument("--map", dest="mapping", action="append", default=[], metavar="COLUMN=VARIABLE",
                        help='another name for a column, with its unit where the file has none: "Torque=steer_torque [N.m]"')  # fmt: skip
    parser.add_argument("--rate", type=float, metavar="HZ", help="reduce faster recordings to this sampling rate while reading")
    parser.add_argument("--rig", metavar="FILE", help="rig.json (default: the one beside the first recording)")
    parser.add_argument("--reference", choices=REFERENCES, default="",
                        help="signal of the cross-spectra: the commanded angle where logged, or the steer angle (unbiased); the papers took the torque")  # fmt: skip
    parser.add_argument("--band", default="0.5:12", metavar="LOW:HIGH", help="frequencies [Hz] (default: 0.5:12)")
    parser.add_argument("--width", type=float, metavar="HZ", help="width of the averages (default: 0.25, more for recordings under 48 s)")
    parser.add_argument("--plot", metavar="FILE", help="figure as .png, .svg or .pdf")
    parser.add_argument("--report", metavar="FILE.html", help="HTML report")


def mapping_of(texts: Sequence[str]) -> dict[str, str]:
    """Variables by column, of texts COLUMN=VARIABLE. Raises InputError for a text that is none."""
    mapping = {}
    for text in texts:
        column, equals, variable = text.partition("=")
        if not (equals and column.strip() and variable.strip()):
            raise InputError(f'--map {text!r} is not COLUMN=VARIABLE, as in "Torque=steer_torque [N.m]"')
        mapping[column.strip()] = variable.strip()
    return mapping


def recordings(options: argparse.Namespace) -> tuple[list[Recording], dict[str, Any]]:
    """The recordings and what rig.json says. Raises InputError for a mapping that is none."""
    mapping = mapping_of(options.mapping)
    runs = [read_recording(file, mapping, options.rate) for file in options.files]
    if options.rig and not Path(options.rig).exists():
        raise InputError(f"cannot read {options.rig}: no such file")
    return runs, read_rig(options.rig) if options.rig else (runs[0].rig if runs else {})


def frfs(runs: list[Recording], options: argparse.Namespace) -> list[FRF]:
    """The FRF of each run within the band. Raises InputError for a band that is none, or a width."""
    low, high = limits(options.band, "--band")
    if options.width is not None and not options.width > 0:
        raise InputError(f"--width {options.width:g} Hz is not positive")
    width = options.width or band_width(runs)
    return [estimate(run, options.reference, (low, high), width) for run in runs]


def limits(text: str, what: str) -> tuple[float, float]:
    """`LOW:HIGH` as numbers. Raises InputError for what is none."""
    try:
        low, high = (float(part) for part in text.split(":"))
    except ValueError:
        low, high = 1.0, 0.0
    if not 0 <= low < high:
        raise InputError(f"{what} {text!r} is not LOW:HIGH with LOW below HIGH, as in 0.5:12")
    return low, high


def warnings_of(runs: list[FRF]) -> list[str]:
    return [f"{frf.name}: {warning}" for frf in runs for warning in frf.warnings]
