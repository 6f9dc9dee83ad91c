"""Tests, in the tree of what they test."""

from pathlib import Path

ROOT = Path(__file__).parent.parent
SHARED_DATA = (
    ROOT.parent / "shared" / "data"
)  # recordings that are not part of the project; tests that use them skip without
