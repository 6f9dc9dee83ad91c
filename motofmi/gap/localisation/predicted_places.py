"""Where the misfit of one-step predictions lies: by output, frequency and time."""

from collections.abc import Iterator
from itertools import pairwise

import numpy as np

from motofmi.gap.localisation.locating import Place, place
from motofmi.gap.preprocessing.predicted_run import PredictedRun

PARTS = 6  # of the band, and of the run


def cells(run: PredictedRun, z: np.ndarray) -> Iterator[Place]:
    """Each output over frequency and over time, with the residuals z (m,) there."""
    parts = z.reshape(len(run.outputs), len(run.blocks), len(run.frequency))
    bands = np.linspace(0, len(run.frequency), PARTS + 1).astype(int)
    times = np.unique(np.linspace(0, len(run.blocks), PARTS + 1).astype(int))
    begin = run.recording.time[0] + np.append(run.blocks, run.blocks[-1] + run.length) * run.step
    for name, part in zip(run.outputs, parts, strict=True):
        for a, b in pairwise(bands):
            yield place(
                run,
                part[:, a:b].ravel(),
                f"{name} over frequency",
                float(run.frequency[a]),
                float(run.frequency[b - 1]),
                "Hz",
            )
        for a, b in pairwise(times):
            yield place(run, part[a:b].ravel(), f"{name} over time", float(begin[a]), float(begin[b]), "s")
