"""The equations of effects in words are the terms that they add, by values of their parameters at random points."""

import re

import numpy as np
import pytest

from fmus.effects.added_terms import added_terms
from fmus.effects.placement import laws_at
from fmus.mechanisms import DrivenJoint

EFFECTS = [e for e in laws_at(DrivenJoint()) if added_terms(e)]
FUNCTIONS = {"tanh": np.tanh, "sinh": np.sinh, "sin": np.sin, "cos": np.cos, "exp": np.exp, "abs": np.abs}


class Values:
    """A number for every name."""

    def __init__(self, rng):
        self.rng, self.known = rng, {}

    def __getattr__(self, name):
        return self.known.setdefault(name, float(self.rng.uniform(0.3, 1.5)))


class Functions:
    tanh, sinh, sin, exp, absolute = np.tanh, np.sinh, np.sin, np.exp, np.abs
    cos, sqrt, sign = np.cos, np.sqrt, np.sign


def evaluated(text, values):
    """An equation in words read as a product wherever a blank stands between two factors."""
    code = re.sub(r"(?<=[\w)]) (?=[\w(])", " * ", text).replace("^", "**")
    return eval(code, {**FUNCTIONS, **values})


@pytest.mark.parametrize("effect", EFFECTS, ids=lambda e: f"{e.family}-{e.form}")
def test_an_equation_in_words_has_the_value_of_the_term(effect):
    values = Values(np.random.default_rng(1))
    if effect.element in DrivenJoint().table:  # of a signal, whose recorded value is its deflection
        values.known |= dict.fromkeys((effect.element, "force", "deflection"), 0.7)
    terms = {target: float(term(values, Functions)) for target, term in effect().additions()}
    for equation in added_terms(effect):
        target, text = re.split(r" \+?= ", equation)
        # numbers have four digits
        term = terms["force" if target == effect.element else target.removeprefix("element ")]
        assert evaluated(text, values.known) == pytest.approx(term, rel=2e-3, abs=2e-3)


def test_dry_friction_and_a_cubic_spring():
    every = {(e.family, e.form): added_terms(e) for e in laws_at(DrivenJoint())}
    assert every["coulomb_friction", "coulomb"] == ["force += friction_torque tanh(rate/sliding_rate)"]
    assert every["hardening_stiffness", "cubic"] == ["force += cubic_stiffness deflection^3"]
    assert every["saturation", "soft_torque"] == ["torque += -share (-limit tanh(torque/limit) + torque)"]
    assert every["backlash", "gap"] == []  # a case distinction has no short form
