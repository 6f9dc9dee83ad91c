"""Measured data: recordings, frequency response functions, fits, and the gap workflow.

    from identification import estimate, read_recording
    estimate(read_recording("sweep.csv")).inertance
"""

from identification.fit import Identification, identify
from identification.frf import FRF, estimate, exact_frf, mean_frf
from identification.recordings import Recording, read_recording, write_recording
from identification.response import Response

__all__ = ["FRF", "Identification", "Recording", "Response", "estimate", "exact_frf", "identify", "mean_frf",
           "read_recording", "write_recording"]  # fmt: skip
