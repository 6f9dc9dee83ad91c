"""Laws outside the library, on machines that no model explains: nothing is named in their place, and they are stated."""

import re
from dataclasses import replace

import numpy as np
import pytest

import motofmi as mf
from motofmi.gap.comparison.compared_model import CommonBlocks
from motofmi.gap.estimation import stages
from motofmi.recordings.recording import Recording
from tests import sampled
from tests.few_laws import only_families
from tests.simulators.three_sines import three_sines

COGGING, PITCH = 0.3, 0.02  # N, m: a force that is periodic in the displacement and in no library
LAWS = {  # force [N] over a coefficient, from displacement [m] and rate [m/s]; the coefficient
    "The damping falls in proportion to the rate": (lambda x, v: -abs(v) * v, 40.0),
    "a force grows with deflection times rate": (lambda x, v: x * v, 400.0),
    "The damping changes with the square of the deflection": (lambda x, v: x**2 * v, 6000.0),
    "": (lambda x, v: np.sign(v), 2.0),
}


def recording_of(name: str, seed: int, sentence: str) -> Recording:
    """25 s at 100 Hz of a mass of 1 kg, a spring and a damper that are moved along three sines: their force with that
    of a law, cogging and noise."""
    law, coefficient = LAWS[sentence]
    generator, time = np.random.default_rng(seed), np.arange(2500) / 100
    x, v, a = three_sines(generator, time)
    force = a + 20 * v + 40 * x + coefficient * law(x, v) + COGGING * np.sin(2 * np.pi * x / PITCH)
    force += 0.005 * generator.standard_normal(len(time))
    return Recording(name, time, {"force": force, "displacement": x}, {"force": "N", "displacement": "m"})


@pytest.mark.parametrize("sentence", sampled(LAWS, every=4))
def test_a_law_outside_the_library_is_stated_and_nothing_is_named_in_its_place(sentence):
    """Of the library, friction or friction with a sensor's gain reduce the misfit on fitted and validation runs."""
    runs = [recording_of(name, seed, sentence) for name, seed in (("fitted", 1), ("held", 2))]
    found = mf.find_gap(runs[0], validation=runs[1], component="mass_spring_damper", impose="displacement").to_dict()
    outside = [s for s in found["limitations"] if s.startswith("The missing effect is outside the library")]
    if sentence:
        assert (found["verdict"], found["effects"]) == ("unknown", [])
        assert sentence in outside[0] and found["reason"] == outside[0]
        # Cogging of 0.3 N is not orthogonal to the law in a run of 25 s.
        value = float(re.search(r"size = (\S+) \+- ", outside[0]).group(1))
        assert value == pytest.approx(LAWS[sentence][1], rel=0.1)
        # Cogging is left by every model, so that the models are compared on blocks.
        [row] = [row for row in found["compared"] if row["effects"] and row["effects"][0]["name"] == "outside_library"]
        assert row["closed"]["share"] > 0.9
        members = [row["effects"][0]["name"] for row in found["compared"] if row["standing"] == "in the confidence set"]
        assert members == ["outside_library"]  # what it replaces is withheld
    else:
        assert (found["verdict"], [e["name"] for e in found["effects"]], outside) == ("named", ["coulomb_friction"], [])


OWN = """
from motofmi import Effect, adds_to, parameter


class OneSidedDamping(Effect):
    \"\"\"The damping grows with the deflection.\"\"\"

    family, form, element = "one_sided_damping", "linear", "spring"
    damping = parameter("N.m.s/rad2", "Damping per deflection", start=10.0)

    @adds_to("force")
    def product(self, v, m):
        return v.damping * v.deflection * v.rate
"""


def test_an_effect_of_ones_own_with_the_term_of_a_law_is_named(tmp_path, monkeypatch):
    monkeypatch.setattr("motofmi.gap.selection.staged_selection.leaves_noise", lambda *_: False)  # compared on blocks
    monkeypatch.setattr("motofmi.gap.comparison.compare.pairs", lambda *_: [])
    refined = CommonBlocks.refined_and_evaluated

    def with_rounding_errors(blocks, fits, description):
        """Equal terms have equal losses but for rounding: those of the law are slightly less here."""
        return [
            replace(m, fitted=m.fitted * (1 - 1e-6), validation=m.validation * (1 - 1e-6))
            if m.families == {"outside_library"}
            else m
            for m in refined(blocks, fits, description)
        ]

    monkeypatch.setattr(CommonBlocks, "refined_and_evaluated", with_rounding_errors)
    (tmp_path / "own.py").write_text(OWN)
    sentence = "a force grows with deflection times rate"
    runs = [recording_of(name, seed, sentence) for name, seed in (("fitted", 1), ("held", 2))]
    found = mf.find_gap(
        runs[0], validation=runs[1], component="mass_spring_damper", impose="displacement", effects=str(tmp_path)
    ).to_dict()
    assert (found["verdict"], [e["name"] for e in found["effects"]]) == ("named", ["one_sided_damping"])
    assert found["compared"]


def test_a_law_whose_magnitude_is_not_determined_is_not_stated(monkeypatch):
    only_families(monkeypatch)
    determined = CommonBlocks.is_undetermined

    def without_laws(blocks, found, simpler=()):
        of_law = any(effect.family == "outside_library" for effect in found.model.effects)
        return of_law or determined(blocks, found, simpler)

    monkeypatch.setattr(CommonBlocks, "is_undetermined", without_laws)
    sentence = "a force grows with deflection times rate"
    runs = [recording_of(name, seed, sentence) for name, seed in (("fitted", 1), ("held", 2))]
    found = mf.find_gap(runs[0], validation=runs[1], component="mass_spring_damper", impose="displacement").to_dict()
    assert not [s for s in found["limitations"] if s.startswith("The missing effect is outside the library")]


def test_a_budget_that_ends_while_laws_are_compared_leaves_the_verdict_of_the_library(monkeypatch):
    only_families(monkeypatch)

    def at_the_end(*_):
        monkeypatch.setattr(stages, "time_is_up", lambda: True)

    monkeypatch.setattr("motofmi.gap.comparison.compare.sufficient_law", at_the_end)
    sentence = "a force grows with deflection times rate"
    runs = [recording_of(name, seed, sentence) for name, seed in (("fitted", 1), ("held", 2))]
    found = mf.find_gap(
        runs[0], validation=runs[1], component="mass_spring_damper", impose="displacement", time=1000
    ).to_dict()
    nearest, *_ = found["compared"]
    assert {e["name"] for e in nearest["effects"]} == {"sensor_nonlinearity", "coulomb_friction"}
    assert found["verdict"] == "unknown"  # a gain of the sensor at its bound is not named
    assert all(e["name"] != "outside_library" for row in found["compared"] for e in row["effects"])
    assert "was not compared with effects outside the library" in found["limitations"][0]
