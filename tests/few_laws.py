"""A library of some families only, for tests of what a search does with its candidates, however many these are."""

from collections.abc import Sequence

import pytest

from motofmi.gap.estimation import base_fit

FAMILIES = ("coulomb_friction", "hardening_stiffness", "progressive_damping", "sensor_nonlinearity")


def only_families(monkeypatch: pytest.MonkeyPatch, families: Sequence[str] = FAMILIES) -> None:
    """Let the laws of these families be the only candidates."""
    original = base_fit.candidate_laws

    def some(*given):
        laws, sentences = original(*given)
        return [law for law in laws if law.family in families], sentences

    monkeypatch.setattr(base_fit, "candidate_laws", some)
