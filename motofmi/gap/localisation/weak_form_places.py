"""Where along frequency and speed a model misses the equations of motion of a run."""

from collections.abc import Iterator

import numpy as np

from identification.gap.data.weak_form import WeakRun
from identification.gap.reporting.locating import Place, place

BANDS = np.array([0.3, 0.6, 1.0, 1.5, 2.0, 2.5, 3.0, 4.0, 5.0])  # Hz
TIMES = 6  # parts of a run


def cells(run: WeakRun, z: np.ndarray) -> Iterator[Place]:
    """Each equation over time, with the residuals z (m,) there, and over frequency as far as whitening keeps it apart."""
    kept = len(run.frequency) - run.nuisance.shape[1]
    by_block = z.reshape(len(run.rates), len(run.blocks), kept)
    when = run.recording.time[run.blocks]
    edges = np.linspace(when[0], when[-1] + run.length / run.recording.rate, TIMES + 1)
    cell = np.searchsorted(edges, when, side="right") - 1
    for name, part in zip(run.rates, by_block, strict=True):
        for i in range(TIMES):
            if np.any(cell == i):
                yield place(run, part[cell == i].ravel(), f"{name} over time", float(edges[i]), float(edges[i + 1]), "s")
