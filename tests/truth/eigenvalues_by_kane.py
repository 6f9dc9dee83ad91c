"""Eigenvalues of the flexible motorcycles by Kane's equations, stored: a derivation takes 10 to 20 s.

    python -m tests.truth.eigenvalues_by_kane      # derives and stores them anew, after a change of the values

`pytest -m study` compares the stored numbers with a new derivation.
"""

import json
from pathlib import Path

import numpy as np

FILE = Path(__file__).with_suffix(".json")


def stored(name: str) -> tuple[np.ndarray, np.ndarray]:
    """The speeds (n,) [m/s] and the eigenvalues (n, nx) [1/s] of a motorcycle at each of them."""
    found = json.loads(FILE.read_text("utf-8"))[name]
    return np.array(found["speed"]), np.array(found["real"]) + 1j * np.array(found["imag"])


def main() -> None:
    from tests.vehicle_fmu import test_compliant_motorcycle as compliant  # noqa: PLC0415 - they import this module
    from tests.vehicle_fmu import test_touring_motorcycle as touring  # noqa: PLC0415

    def of_touring(kane, speed):
        mass, slopes = touring.second(kane, touring.TUM, speed)
        return np.linalg.eigvals(np.linalg.solve(mass, slopes)[:, : len(touring.TUM.states)])

    made = {"tum_2020": _table(np.linspace(5.0, 80.0, 20), of_touring, touring.touring_motorcycle_by_kane.derive())}
    kane = compliant.compliant_motorcycle_by_kane.derive()
    for hands, on in compliant.HANDS.items():
        motorcycle = compliant.SHARP.with_values(hands_on=on)

        def of_compliant(kane, speed, motorcycle=motorcycle):
            arguments = compliant.arguments(motorcycle, speed)
            matrices = compliant.compliant_motorcycle_by_kane.linearised(kane, arguments)
            return np.linalg.eigvals(matrices[:, : len(motorcycle.states)])

        made[f"sharp_1994, {hands}"] = _table(np.linspace(4.0, 80.0, 20), of_compliant, kane)
    lines = [f"{json.dumps(name)}: {json.dumps(table)}" for name, table in made.items()]
    FILE.write_text("{\n" + ",\n".join(lines) + "\n}\n", "utf-8")


def _table(speeds, eigenvalues, kane) -> dict[str, list]:
    found = np.array([np.sort_complex(eigenvalues(kane, speed)) for speed in speeds])
    return {"speed": speeds.tolist(), "real": found.real.tolist(), "imag": found.imag.tolist()}


if __name__ == "__main__":
    main()
