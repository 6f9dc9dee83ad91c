"""Named modes at 591 speeds against a bare numpy.linalg.eig of the stacked matrices."""

from statistics import median
from time import perf_counter

import numpy as np

from rider_fmu import riders
from vehicle_fmu import modes, motorcycles, over_speed, ridden

SPEEDS = np.linspace(1, 60, 591)


def run(progress, rounds: int = 30) -> dict:
    """Seconds of both, medians over paired rounds, and the median ratio."""
    linearised = over_speed(ridden(motorcycles.load("sharp_1971"), riders.load("mean_2011")))
    matrices = linearised(SPEEDS).A
    ours, bare = [], []
    for _ in progress(range(rounds), "modes at 591 speeds"):
        start = perf_counter()
        np.linalg.eig(matrices)
        middle = perf_counter()
        modes(linearised, SPEEDS)
        bare.append(middle - start)
        ours.append(perf_counter() - middle)
    ratio = median(a / b for a, b in zip(ours, bare, strict=True))
    return {"speeds": len(SPEEDS), "modes_s": median(ours), "eig_s": median(bare), "ratio": ratio}
