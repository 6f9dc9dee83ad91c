"""Every family of effects has a picture of its signature, or a sentence why there is none."""

import re

import numpy as np
import pytest

from tests import ROOT


@pytest.mark.slow
def test_every_family_has_a_picture_or_a_sentence(monkeypatch):
    monkeypatch.syspath_prepend(str(ROOT / "docs"))
    from extension import catalogue, signatures, system_signatures  # noqa: PLC0415 - modules of the documentation

    page = catalogue.effects()
    families, pictures = set(re.findall(r"^## (\w+)$", page, re.MULTILINE)), set(re.findall(r"\(signature_(\w+)\.svg\)", page))
    assert pictures == {*signatures.forms(), *system_signatures.forms()}
    assert families == pictures | set(system_signatures.WITHOUT_PICTURE) and not pictures & set(system_signatures.WITHOUT_PICTURE)


@pytest.mark.slow
def test_the_signature_of_a_reflex_is_a_delay(monkeypatch):
    """The torque of a reflex to the steer angle late by t is a constant times exp(-i w t)."""
    monkeypatch.syspath_prepend(str(ROOT / "docs"))
    from extension import system_signatures  # noqa: PLC0415 - a module of the documentation

    reflex = next(e for e in system_signatures.forms()["reflex"] if e.form == "delayed_angle")
    change = system_signatures.change_of_response(reflex)
    found, delay = change["real"] + 1j * change["imaginary"], reflex.starts["delay"][len(reflex.starts["delay"]) // 2]
    turned = found * np.exp(2j * np.pi * system_signatures.FREQUENCY * delay)
    low = system_signatures.FREQUENCY <= 2  # Hz: w t is at most 1.3, where the rational form of the delay is exact to 1e-6
    assert np.allclose(turned[low] / turned[0], 1, atol=1e-6)
