"""Tests, in the tree of what they test."""

from functools import partial
from pathlib import Path

import pytest

ROOT = Path(__file__).parent.parent
SHARED_DATA = (
    ROOT.parent / "shared" / "data"
)  # recordings that are not part of the project; tests that use them skip without
as_study = partial(pytest.param, marks=pytest.mark.study)  # a case that only `pytest -m study` runs


def sampled(cases, every):
    """One of `every` cases of a parametrised test; the others as studies."""
    return [case if i % every == 0 else as_study(*(case if isinstance(case, tuple) else (case,))) for i, case in enumerate(cases)]
