r"""The normal equations of a fit, scaled so that every parameter counts alike.

    N = S^-1 (J'J + P'P) S^-1,   S = diag(sqrt(diag(J'J + P'P)))

J are the derivatives of the residuals and P those of the prior terms. N has a diagonal of ones, so that the limit on
its eigenvalues does not depend on the units of the parameters.
"""

from functools import cached_property

import numpy as np

from motofmi.gap.comparison.residuals import Block, TimeResiduals

LEAST_INFLUENCE = 1e-12  # derivative over the largest one [1], below which a parameter has no influence on the outputs
LEAST_EIGENVALUE = 1e-9  # eigenvalue of N over the largest one [1], below which the data do not determine a direction


class NormalEquations:
    """The scaled normal matrix (parameters, parameters) of residuals, and the part of each block in it.

    scale (parameters,) is the diagonal of S, infinite for a parameter without influence; priors (k, parameters) are the
    scaled derivatives of the prior terms.
    """

    def __init__(self, residuals: TimeResiduals):
        self.residuals = residuals
        count = residuals.priors.shape[1]
        self._slopes = [run.reshape(-1, count) for run in residuals.slopes]
        matrix = sum(s.T @ s for s in self._slopes) + residuals.priors.T @ residuals.priors
        self.scale = np.sqrt(np.diag(matrix))
        self.scale[self.scale < LEAST_INFLUENCE * self.scale.max()] = np.inf
        self.matrix = matrix / np.outer(self.scale, self.scale)
        self.priors = residuals.priors / self.scale

    def of_block(self, block: Block) -> tuple[np.ndarray, np.ndarray]:
        """The scaled derivatives (m, parameters) and the residuals (m,) of a block; m are its samples times outputs."""
        run, first, last = block
        outputs = self.residuals.runs[run].shape[1]
        slopes = self._slopes[run][first * outputs : last * outputs] / self.scale
        return slopes, self.residuals.runs[run][first:last].ravel()

    @cached_property
    def inverse(self) -> np.ndarray:
        """The pseudo-inverse (parameters, parameters) of the scaled normal matrix."""
        return pseudo_inverse(self.matrix)


def pseudo_inverse(matrix: np.ndarray) -> np.ndarray:
    """The pseudo-inverse of a symmetric matrix without the directions that the data do not determine."""
    return np.linalg.pinv(matrix, rcond=LEAST_EIGENVALUE, hermitian=True)
