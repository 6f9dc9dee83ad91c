"""Eigenvalues of the touring motorcycle in corners by Exudyn, stored: each case takes 5 s and an optional package.

    python -m tests.scenarios.eigenvalues_by_exudyn      # finds and stores them anew, after a change of the values
"""

import json
from pathlib import Path

import numpy as np

from motofmi.scenarios.hosts.exudyn_corner import MultibodyCorner
from rider_fmu import riders
from vehicle_fmu import motorcycles
from vehicle_fmu.large_motion.corner_modes import held
from vehicle_fmu.large_motion.equations import LargeMotion
from vehicle_fmu.large_motion.steady_turning import SteadyTurning

FILE = Path(__file__).with_suffix(".json")
POINTS = [(speed, lean, 0.0) for speed in (10.0, 30.0, 60.0) for lean in (0.0, 15.0, 30.0, 45.0)]
POINTS += [(30.0, 15.0, -4.0), (30.0, 30.0, 2.0)]


def main() -> None:
    import exudyn  # noqa: PLC0415 - an optional package

    vehicle, cases = motorcycles.load("tum_2020"), []
    for hands, devices in {"hands off": (), "mean rider": (riders.load("mean_2011"),)}.items():
        for speed, lean, acceleration in POINTS:
            motorcycle = held(vehicle, devices)
            turning = SteadyTurning(LargeMotion(motorcycle), speed)
            ours = turning.at(np.radians(lean), acceleration)
            host = MultibodyCorner(motorcycle, turning.motion.states, ours.u, ours.multipliers)
            first = int(acceleration != 0)
            found = np.sort_complex(np.linalg.eigvals(host.with_devices(ours.x, devices)[first:, first:]))
            cases.append({"speed": speed, "lean": lean, "acceleration": acceleration, "hands": hands,
                          "real": found.real.tolist(), "imag": found.imag.tolist()})  # fmt: skip
    lines = ",\n".join(json.dumps(case) for case in cases)
    FILE.write_text(f'{{"exudyn": "{exudyn.__version__}", "cases": [\n{lines}\n]}}\n', "utf-8")


if __name__ == "__main__":
    main()
