"""One page that works offline: root loci with sliders, the mode animated, live co-simulation."""

import argparse
from typing import Any

from motofmi.cli.arguments import assignments
from motofmi.cli.component_arguments import DEVICE, VEHICLE, add_settings, add_vehicle
from motofmi.cli.outputs import output_file
from motofmi.cli.screen import Screen
from motofmi.workflows.explore import DEVICES, explore

SUMMARY = "one HTML page with sliders, animated modes and live FMUs"
PLACE = 32
UNITS = {"bytes": "B"}
HELP = """Writes one HTML file that opens in a browser without a network: root locus and frequencies over speed with sliders
for device, damper, rider, trail, caster angle, tyres and gravity; two configurations side by side; the mode animated;
and the FMUs in WebAssembly, co-simulated in the page.

  motofmi explore
  motofmi explore --device none --device rider:mean_2011 --out rider.html
  motofmi explore --device rider:mean_2011 --device gap/augmented_rider.toml     # before and after an effect
  motofmi explore --device rider:mean_2011 --device rider:mean_2011,rider:roll_1971   # a rider who leans as well
  motofmi explore --device rider:mean_2011 --device rider_of_another_tool.fmu
"""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    add_vehicle(parser)
    parser.add_argument("--device", dest="devices", action="append", default=[], metavar="DEVICE",
                        help=f"{DEVICE}; or the .fmu of a device; the first two are compared "
                             "(default: none and rider:mean_2011)")  # fmt: skip
    parser.add_argument("--out", default="explore.html", type=output_file(".html"), metavar="FILE.html",
                        help="the page (default: %(default)s)")  # fmt: skip
    add_settings(parser)


def run(arguments: argparse.Namespace) -> dict[str, Any]:
    devices = arguments.devices or list(DEVICES)
    return explore(arguments.vehicle or VEHICLE, devices, arguments.out, set=assignments(arguments.settings)).to_dict()


def show(result: dict[str, Any], screen: Screen) -> None:
    screen.print(f"Open {result['page']} in a browser ({result['bytes'] / 1e6:.2f} MB)")
