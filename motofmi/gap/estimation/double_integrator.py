"""Segments of a mass without spring and damper, a double integrator, over which errors of its model stay small.

    x'' = a + e,   x_e(t) <= integral from 0 to t of |h(s)| ds max |e|,   h(t) = t:   x_e(T) <= T^2 / 2 max |e|

e is an acceleration that the model lacks, and h its impulse response. The integral of |h| is the peak gain of the
error. With w the mean angular frequency of the motion, |a| = w^2 |x|, so that a relative error of the acceleration is
that of the deflection times (w T)^2 / 2. For an undamped oscillator at its natural frequency, h(t) = sin(w t) / w,
this factor is 2 w T / pi, which is 4 n over n periods. A segment of a double integrator is so short that the factor
is no larger than that of the oscillator over a segment of usual length:

    (w T)^2 / 2 = 4 n,   T = sqrt(8 n) / w

Over longer segments the simulated motion departs from the recorded one. The least squares then reduce the gain of the
inputs, and have several minima.

Source: Boyd, Barratt, Linear Controller Design (1991), section 5.2.3, on the peak gain; Ribeiro et al., Automatica 121
(2020) 109158, on the length of a simulation and the minima of its least squares, and on multiple shooting.
"""

import numpy as np

from motofmi.gap.preprocessing.sampled_run_preparation import SEGMENT_PERIODS


def is_double_integrator(poles: np.ndarray, duration: float) -> bool:
    """Whether two of the poles (..., nx) [1/s] are not distinguishable from zero over a duration [s], at every point:
    their time constants are longer."""
    return bool(np.all(np.sum(np.abs(poles) * duration < 1, axis=-1) > 1))


def longest_segment(frequency: float) -> float:
    """The longest segment [s] of a double integrator whose motion has a mean frequency [Hz]."""
    return float(np.sqrt(8 * SEGMENT_PERIODS) / (2 * np.pi * frequency))
