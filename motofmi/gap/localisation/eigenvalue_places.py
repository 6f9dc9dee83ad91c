"""Where the misfit of measured eigenvalues lies: by mode and by band of the input (speed)."""

from collections.abc import Iterator

import numpy as np

from motofmi.gap.localisation.locating import Place, place
from motofmi.gap.preprocessing.eigenvalues import MeasuredEigenvalues

BANDS = 5  # of the input
FEWEST = 2  # data in a cell


def cells(run: MeasuredEigenvalues, z: np.ndarray) -> Iterator[Place]:
    """The cells of each mode: bands of the input, real and imaginary parts separately, with the
    residuals z (m,) in them."""
    over, mode, part = run.labels
    names, parts = np.array(mode), np.array(part)
    edges = np.quantile(over, np.linspace(0, 1, BANDS + 1))
    band = np.clip(np.searchsorted(edges, over, side="right") - 1, 0, BANDS - 1)
    for name in dict.fromkeys(mode):
        for kind in ("real", "imag"):
            for i in range(BANDS):
                inside = (names == name) & (parts == kind) & (band == i)
                if np.count_nonzero(inside) >= FEWEST:
                    yield place(run, z[inside], f"{name or 'mode'} {kind}", float(edges[i]), float(edges[i + 1]), "m/s")
