r"""The prior of an effect's parameters: a log-normal distribution.

    r = W (ln(p + p_0) - m),     W' W = covariance of the logarithms to the power of -1

The residuals r (k,) are independent and of unit variance. The offset p_0 is zero except for a parameter that is known
only as a sum with a constant, such as an inertia that a rig measures together with that of its handlebar.
"""

from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True, eq=False)
class LogNormalPrior:
    """Names (k,) of parameters, their offsets (k,), mean (k,) and covariance (k, k) of the logarithms, and the
    published values (n, k) behind them, from which fits start as well."""

    names: tuple[str, ...]
    offset: np.ndarray
    mean: np.ndarray
    covariance: np.ndarray
    sample: np.ndarray

    @property
    def weight(self) -> np.ndarray:
        """W (k, k)."""
        return np.linalg.inv(np.linalg.cholesky(self.covariance))

    @property
    def median(self) -> np.ndarray:
        """The medians (k,) of the parameters."""
        return np.exp(self.mean) - self.offset

    def residuals(self, values: np.ndarray) -> np.ndarray:
        """r (k,) at parameter values (k,)."""
        return self.weight @ (np.log(values + self.offset) - self.mean)

    def slopes(self, values: np.ndarray) -> np.ndarray:
        """dr/dp (k, k)."""
        return self.weight / (values + self.offset)
