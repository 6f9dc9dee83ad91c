"""Where the misfit of the equations of motion lies: by equation and time."""

from collections.abc import Iterator

import numpy as np

from motofmi.gap.localisation.locating import Place, place
from motofmi.gap.preprocessing.weak_form import WeakFormRun

TIMES = 6  # parts of a run


def cells(run: WeakFormRun, z: np.ndarray) -> Iterator[Place]:
    """Each equation over time, with the residuals z (m,) there; whitening mixes frequencies."""
    kept = len(run.frequency) - run.nuisance.shape[1]
    by_block = z.reshape(len(run.rates), len(run.blocks), kept)
    when = run.recording.time[run.blocks]
    edges = np.linspace(when[0], when[-1] + run.length / run.recording.rate, TIMES + 1)
    cell = np.searchsorted(edges, when, side="right") - 1
    for name, part in zip(run.rates, by_block, strict=True):
        for i in range(TIMES):
            if np.any(cell == i):
                yield place(
                    run, part[cell == i].ravel(), f"{name} over time", float(edges[i]), float(edges[i + 1]), "s"
                )
