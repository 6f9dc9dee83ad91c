"""Tests, in the tree of what they test."""

from functools import partial
from pathlib import Path

import pytest

ROOT = Path(__file__).parent.parent
SHARED_DATA = (
    ROOT.parent / "shared" / "data"
)  # recordings that are not part of the project; tests that use them skip without
as_study = partial(pytest.param, marks=pytest.mark.study)  # a case that only `pytest -m study` runs
