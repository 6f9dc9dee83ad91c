"""Studies too long for the tests: ratios measured in one run, kept in results.json with the machine and the date.

    python -m benchmarks                 all studies
    python -m benchmarks modes --json -  one of them, as JSON
"""

import os

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")  # as on the command line (see `scenarios`)
