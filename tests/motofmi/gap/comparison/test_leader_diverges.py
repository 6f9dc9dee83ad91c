"""Nothing is named in place of an effect that cannot be simulated on the validation runs."""

import motofmi as mf
from motofmi.gap.comparison.compared_model import CommonBlocks
from tests.simulators.swings import swing

VALUES = {"J": 0.1, "k": 4.0, "c": 0.003, "T_c": 0.02, "c_2": 0.0}


def test_nothing_is_named_in_place_of_an_effect_that_cannot_be_simulated(monkeypatch):
    runs = [swing(f"from {q} rad", q, 12.0, 40.0, VALUES, noise=1e-3, seed=k) for k, q in enumerate((0.5, 0.3))]
    held = swing("held", 0.4, 12.0, 40.0, VALUES, noise=1e-3, seed=7)
    evaluated = CommonBlocks.evaluated

    def without_friction(blocks, found):
        families = {effect.family for effect in found.model.effects}
        return None if "coulomb_friction" in families else evaluated(blocks, found)

    monkeypatch.setattr(CommonBlocks, "evaluated", without_friction)
    monkeypatch.setattr("motofmi.gap.selection.any_component._leaves_noise", lambda *_: False)
    found = mf.find_gap(runs, validation=held, component="pendulum").to_dict()
    assert found["verdict"] == "unknown" and not found["effects"]
    assert any(
        s.startswith("No effect is named: coulomb_friction leaves less on the fitted runs") for s in found["limitations"]
    )
