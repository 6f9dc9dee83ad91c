"""A recorded angle and its recorded rate that contradict each other are refused before any fit."""

import re

import numpy as np
import pytest

import motofmi as mf
from fmus.mechanisms import DrivenJoint
from fmus.support.errors import InputError
from motofmi.gap.preprocessing.recorded_rates import require_rates
from motofmi.recordings.recording import Recording

TIME = np.arange(0, 20, 0.01)
UNITS = {"torque": "N.m", "angle": "rad", "rate": "rad/s"}


def swing(
    factor: float = 1.0, noise: float = 0.0, offset: float = 0.0, drift: float = 0.0, gap: bool = False
) -> Recording:
    """An angle 0.3 sin(2 t) + 0.1 sin(7 t), and its rate times a factor, with errors of the sensors."""
    random = np.random.default_rng(1)
    angle = 0.3 * np.sin(2 * TIME) + 0.1 * np.sin(7 * TIME) + noise * random.standard_normal(len(TIME))
    rate = 0.6 * np.cos(2 * TIME) + 0.7 * np.cos(7 * TIME) + noise * random.standard_normal(len(TIME))
    columns = {"torque": np.sin(TIME), "angle": angle + drift * TIME, "rate": factor * rate + offset}
    kept = (TIME < 5) | (TIME > 9) if gap else np.full(len(TIME), True)
    return Recording("swing", TIME[kept], {name: x[kept] for name, x in columns.items()}, UNITS)


@pytest.mark.parametrize("errors", [
    {}, {"factor": 1.3}, {"noise": 0.05}, {"offset": 2.0}, {"drift": 0.5, "offset": -1.0}, {"gap": True},
    {"factor": -1.0, "noise": 3.0},  # noise of ten times the motion shows nothing
], ids=str)  # fmt: skip
def test_errors_of_sensors_are_no_contradiction(errors):
    require_rates(DrivenJoint(), [swing(**errors)])


@pytest.mark.parametrize("errors", [{}, {"noise": 0.05}, {"offset": 2.0}, {"gap": True}], ids=str)
@pytest.mark.parametrize("factor", [-1.0, 180 / np.pi, 2 * np.pi / 60])
def test_a_wrong_sign_or_unit_is_refused_with_the_ratio(factor, errors):
    with pytest.raises(InputError, match="rate is the rate of angle, and angle changes by") as error:
        require_rates(DrivenJoint(), [swing(factor, **errors)])
    (ratio,) = re.findall(r"changes by (\S+) times", str(error.value))
    # noise of up to a twelfth of the rate, and a constant rate across the gap
    assert float(ratio) == pytest.approx(1 / factor, rel=0.1)
    assert '--map "rate=-rate" or --map "angle=angle [deg]"' in str(error.value)


def test_an_imposed_angle_is_not_compared_with_its_rate():
    require_rates(DrivenJoint(), [swing(-1.0)], imposed="angle")


def test_the_workflow_refuses_it_before_any_fit():
    with pytest.raises(InputError, match="rate is the rate of angle"):
        mf.find_gap([swing(-1.0)], component="driven_joint")
