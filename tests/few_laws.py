"""A library of some families only, for tests of what a search does with its candidates: all laws take a minute."""

import pytest

from motofmi.gap.estimation import base_fit


def only_families(monkeypatch: pytest.MonkeyPatch, *families: str) -> None:
    """Let the laws of these families be the only candidates."""
    original = base_fit.candidate_laws

    def some(*given):
        laws, sentences = original(*given)
        return [law for law in laws if law.family in families], sentences

    monkeypatch.setattr(base_fit, "candidate_laws", some)
