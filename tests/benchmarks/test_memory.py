"""The peak memory of a benchmark is that of its own program."""

import subprocess
import sys

import numpy as np
import pytest

from benchmarks._memory import STATUS, peak_memory
from tests import ROOT

USED = 200  # MB, several times what Python needs to start


@pytest.mark.skipif(not STATUS.exists(), reason="needs /proc of Linux")
def test_a_started_program_does_not_have_the_peak_of_the_one_that_starts_it():
    held = np.ones(USED * 10**6, np.uint8)
    call = "from benchmarks._memory import peak_memory; print(peak_memory())"
    run = subprocess.run([sys.executable, "-c", call], capture_output=True, text=True, cwd=ROOT, check=True)
    assert 1 < float(run.stdout) < held.nbytes / 1e6 < peak_memory()
