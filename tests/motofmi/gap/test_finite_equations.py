"""Components whose equations are not finite where a search for values simulates: the root of a level below zero."""

import numpy as np
import pytest

import motofmi as mf
from fmus import Component, input, parameter, state
from fmus.support.errors import InputError
from motofmi.gap.estimation.finite_equations import hint_where_not_finite
from motofmi.gap.experiments.input_output import input_output_experiment
from motofmi.gap.preprocessing.sampled_run_preparation import prepare_sampled_run
from motofmi.recordings.recording import Recording

GAIN, OUTFLOW = 0.25, 0.16  # 1/s, V/s: those of a laboratory's tank, per sample


class Tank(Component):
    """A tank that a pump fills; its outflow is the square root of the level."""

    gain = parameter("1/s", "Inflow by the pump's voltage", min=0, start=0.2)
    outflow = parameter("V/s", "Outflow at a level of 1 V", min=0, start=0.1)
    voltage = input("V", "Pump voltage")
    level = state("V", "Level", start=5.0, exposed=True)

    def equations(self, v, m):
        return {"der(level)": v.gain * v.voltage - v.outflow * m.sqrt(v.level)}


class Float(Tank):
    """A tank with a float valve that closes the outflow at 1 V, in place of one that opens it."""

    def equations(self, v, m):
        return {"der(level)": v.gain * v.voltage - v.outflow * m.sqrt(1.0 - v.level)}


class LinearTank(Tank):
    """A tank whose outflow is proportional to its level."""

    def equations(self, v, m):
        return {"der(level)": v.gain * v.voltage - v.outflow * v.level}


def filled(seed: int) -> Recording:
    """A tank that nearly runs dry while the pump is off."""
    random = np.random.default_rng(seed)
    voltage, level, levels = np.repeat(random.uniform(0.0, 2.4, 60), 20), 0.4, []
    for volts in voltage:
        levels.append(level)
        for _ in range(20):
            level = max(level + (GAIN * volts - OUTFLOW * np.sqrt(level)) / 20, 0.0)
    columns = {"voltage": voltage, "level": np.array(levels) + 0.005 * random.standard_normal(len(levels))}
    return Recording(f"run_{seed}", np.arange(len(voltage), dtype=float), columns, {"voltage": "V", "level": "V"})


@pytest.mark.parametrize(("tank", "finite"), [(Tank(), False), (LinearTank(), True)])
def test_a_state_at_which_the_equations_are_not_finite_is_given(tank, finite):
    recording = filled(1)
    experiment = input_output_experiment(tank, list(recording.columns))
    hint = hint_where_not_finite(tank, [prepare_sampled_run(recording, experiment)])
    assert bool(hint) != finite
    if not finite:
        assert "its der(level) is not finite where level is -" in hint


def test_the_error_of_a_base_that_cannot_be_simulated_says_so():
    with pytest.raises(InputError, match=r"der\(level\) is not finite where level is .* V, which a search"):
        mf.find_gap(filled(1), validation=filled(2), component=Float())


def test_a_held_input_is_no_delay_of_half_a_sample():
    """Held inputs are nearly those of a spline with a delay of half a sample; the base has no delay."""
    found = mf.find_gap(filled(1), validation=filled(2), component=Tank())
    assert (found.verdict, found.effects) == ("none", [])
    assert found.to_dict()["base"]["gain"]["value"] == pytest.approx(GAIN, rel=5e-3)  # Euler's method, 20 steps per sample
