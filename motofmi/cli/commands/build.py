"""FMUs from components."""

import argparse
from typing import Any

from motofmi.cli.arguments import assignments
from motofmi.cli.component_arguments import add_settings
from motofmi.cli.outputs import output_file, output_folder
from motofmi.cli.screen import Screen
from motofmi.workflows.build import SPEED, build

SUMMARY = "FMUs of riders, motorcycles and dampers"
PLACE = 50
UNITS: dict[str, str] = {}
HELP = """Writes FMUs of riders, motorcycles, dampers and mechanisms: FMI 2.0 or 3.0, co-simulation and model exchange
in one archive. With the back end compiled the archive needs no Python. Without a NAME everything in motofmi list is
built.

  motofmi build rider:mean_2011 sharp_1971 damper:7.5 --out fmus
  motofmi build rider:mean_2011 --set arm_damping=20 --fmi 3
  motofmi build mine.toml --backend python                   # FMI 2.0; the slave is a Python source file
  motofmi build sharp_1971 rider:mean_2011 --ssp ridden.ssp --speed 40    # both, coupled, for any SSP tool
  motofmi build tum_2020 --lean 30 --speed 30                # in large motion, starts in steady turning
  motofmi build rider:mean_2011 --platforms all              # needs: pip install 'motofmi[platforms]'
  motofmi build rider:mean_2011 --fmi 3 --platforms wasm     # WebAssembly, for browsers and sandboxes
"""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        "names",
        nargs="*",
        metavar="NAME",
        help="kind:NAME, damper:VALUE [N.m.s/rad], a NAME that is unique among the kinds, or a .toml (default: "
             "everything)",
    )
    parser.add_argument("--fmi", default="2", help="version of the FMI standard, 2 or 3 (default: %(default)s)")
    parser.add_argument(
        "--backend",
        default="compiled",
        help="compiled, or python for FMI 2.0 archives that run in Python (default: %(default)s)",
    )
    parser.add_argument(
        "--platforms",
        default="host",
        help="host, all, or a comma list such as linux-x86_64,windows-x86_64,wasm (default: %(default)s)",
    )
    parser.add_argument(
        "--out",
        default=".",
        type=output_folder,
        metavar="DIR",
        help="folder for the archives (default: the current folder)",
    )
    add_settings(parser, "a parameter of the only NAME, or of a part of the .ssp")
    parser.add_argument("--ssp", metavar="FILE.ssp", type=output_file(".ssp"),
                        help="write one system instead: a vehicle and the devices at its ports, coupled")  # fmt: skip
    parser.add_argument("--ssp-version", default="1", help="of the SSP standard, 1 or 2 (default: %(default)s)")
    parser.add_argument(
        "--speed", type=float, default=SPEED,
        help="forward speed in the .ssp or with --lean [m/s] (default: %(default)g)"
    )
    parser.add_argument(
        "--lean", type=float,
        help="build a vehicle in large motion (tum_2020) that starts in steady turning at this lean angle [deg], to "
             "the right positive, 0 for straight running"
    )
    parser.add_argument("--initial", action="append", default=[], metavar="NAME=VALUE",
                        help="start value of a state in the .ssp, in SI units; repeatable")  # fmt: skip


def run(arguments: argparse.Namespace) -> dict[str, Any]:
    return build(arguments.names or None, arguments.out, fmi=arguments.fmi, backend=arguments.backend,
                 platforms=arguments.platforms, set=assignments(arguments.settings), ssp=arguments.ssp,
                 ssp_version=arguments.ssp_version, initial=assignments(arguments.initial),
                 speed=arguments.speed, lean=arguments.lean).to_dict()  # fmt: skip


def show(result: dict[str, Any], screen: Screen) -> None:
    member = ": {name}" if result["ssp"] else ""
    rows = [(fmu["path"] + member.format(**fmu), " ".join(fmu["platforms"]), fmu["sha256"]) for fmu in result["fmus"]]
    screen.table(("FMU", "platforms", "sha256"), rows)
