"""One question per file, answered on the screen and in files; and the command line."""

import os

# Matrices are small here: threads inside one multiplication would wait for each other longer than it takes.
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
