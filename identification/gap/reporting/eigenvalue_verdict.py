"""The verdict on measured eigenvalues, and where along the modes and the input a model misses them.

The effects of a linearised component have no forms but those of the library: a family of which none is adequate is not
named with its form open, as it would be where forces may have curves of their own, but `unknown`.
"""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace

import numpy as np

from fmus.effects import Effect
from identification.gap.data.eigenvalues import Spectrum
from identification.gap.models.eigenvalue_model import EigenvalueModel
from identification.gap.naming.decide import Verdict, decide
from identification.gap.reporting.locating import Place, place
from identification.gap.stands.linear_stand import LinearStand

BANDS = 5  # of the input, in which misfit is looked for
FEWEST = 2  # data in a cell


def decide_on_eigenvalues(stand: LinearStand, runs: Sequence[Spectrum], library: Sequence[type[Effect]], holdout: Sequence[Spectrum] = (),
                          so_far: Callable[[Verdict], None] = lambda verdict: None) -> Verdict:  # fmt: skip
    """The verdict on measured eigenvalues, with the effects of a library; held-out ones can only take a name back.

    so_far is told what is known at every stage.
    """
    verdict = decide(EigenvalueModel(stand), runs, library, holdout, so_far)
    return replace(verdict, verdict="unknown", effects=[], open_form=False) if verdict.open_form else verdict


def cells(run: Spectrum, z: np.ndarray) -> Iterator[Place]:
    """Each mode over bands of the input, real and imaginary parts apart, with the residuals z (m,) there."""
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
