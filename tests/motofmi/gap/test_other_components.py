"""The gap of components that are no mechanism with one input and one output: tanks, an operator, two forces and two
positions, an accelerometer. The recordings are simulated by scipy's `solve_ivp`."""

from typing import Any

import pytest

import motofmi as mf
from fmus import Component
from motofmi.recordings.recording import Recording
from tests import SHARED_DATA
from tests.simulators.other_components import (
    Accelerometer,
    Operator,
    Tanks,
    TwoCarts,
    accelerometer_run,
    carts_run,
    operator_run,
    tanks_run,
)

MEASURED = SHARED_DATA / "measured" / "cascaded_tanks"


def gap(component: Component, fitted: Recording | str, validation: Recording | str) -> Any:
    return mf.find_gap(fitted, validation=validation, component=component)


def effect(found: Any) -> tuple[str, str]:
    """Name and form of the only effect."""
    [only] = found.effects
    return only["name"], only["form"]


def value(found: Any, name: str) -> tuple[float, float]:
    """A parameter of the only effect with its standard error."""
    [only] = found.effects
    return only["parameters"][name]["value"], only["parameters"][name]["standard_error"]


def within(found: Any, name: str, true: float, errors: float = 3.0) -> bool:
    known, error = value(found, name)
    return abs(known - true) < errors * error


@pytest.mark.slow
@pytest.mark.study
def test_tanks_that_miss_nothing_have_no_gap():
    found = gap(Tanks(), tanks_run("fit", 1), tanks_run("held", 2))
    assert (found.verdict, found.effects) == ("none", [])
    outflow = found.to_dict()["base"]["lower_outflow"]
    assert outflow["value"] == pytest.approx(0.0075, abs=4 * outflow["standard_error"])


@pytest.mark.slow
@pytest.mark.study
def test_an_overflow_into_the_next_tank_is_named_with_its_threshold_and_share():
    runs = (tanks_run(name, seed, overflow=0.12, share=0.5) for name, seed in (("fit", 1), ("held", 2)))
    found = gap(Tanks(), *runs)
    assert found.verdict == "named"
    assert effect(found) == ("overflow", "transfer_upper_level_to_level")
    assert all(within(found, n, true) for n, true in {"threshold": 0.12, "share": 0.5, "rate": 0.5}.items())
    assert value(found, "threshold")[1] < 0.02 * 0.12
    assert found.to_dict()["explained"]["low"] > 0.95


@pytest.mark.slow
@pytest.mark.study
@pytest.mark.skipif(not MEASURED.exists(), reason=f"the recordings of the cascaded tanks are not at {MEASURED}")
def test_real_tanks_that_overflow_are_not_refused_as_clipped():
    """The upper tank of the benchmark overflows into the lower one, whose sensor stops at 10 V."""

    class CascadedTanks(Tanks):
        pump_gain = mf.parameter("1/s", "Rise of the upper level per voltage", min=0, start=0.05)
        upper_outflow = mf.parameter("V/s", "Fall of the upper level at 1 V", min=0, start=0.05)
        lower_outflow = mf.parameter("V/s", "Fall of the lower level at 1 V", min=0, start=0.05)
        upper_level = mf.state("V", "Level of the upper tank", start=5.0)
        level = mf.state("V", "Level of the lower tank", start=5.0, exposed=True)

    found = gap(CascadedTanks(), *(str(MEASURED / f"{n}.csv") for n in ("estimation", "validation")))
    assert found.verdict == "named"
    assert effect(found) == ("overflow", "transfer_upper_level_to_level")
    assert any("at its limit of 10 V are left out" in sentence for sentence in found.to_dict()["limitations"])
    assert found.to_dict()["explained"]["low"] > 0.1  # a name needs a tenth of the closable misfit


@pytest.mark.slow
@pytest.mark.study
def test_dry_friction_is_named_at_the_second_of_two_driven_masses():
    found = gap(TwoCarts(), carts_run("fit", 1, friction=1.5), carts_run("held", 2, friction=1.5))
    name, form = effect(found)
    assert (found.verdict, name) == ("named", "coulomb_friction") and form.endswith("_at_other_position")
    assert within(found, "friction_torque", 1.5, 4.0) and value(found, "friction_torque")[1] < 0.05


@pytest.mark.slow
@pytest.mark.study
def test_dry_friction_is_named_from_an_acceleration():
    found = gap(Accelerometer(), accelerometer_run("fit", 1, friction=1.5), accelerometer_run("held", 2, friction=1.5))
    assert (found.verdict, effect(found)[0]) == ("named", "coulomb_friction")
    assert within(found, "friction_torque", 1.5, 4.0) and value(found, "friction_torque")[1] < 0.05
    assert found.to_dict()["base"]["stiffness"]["value"] == pytest.approx(300.0, rel=0.01)


@pytest.mark.slow
@pytest.mark.study
@pytest.mark.parametrize(
    ("hidden", "expected", "name", "true"),
    [
        ({}, None, "", 0.0),
        ({"delay": 0.25}, ("channel_delay", "delay"), "delay", 0.1),  # beyond the 0.15 s of the component
        ({"threshold": 0.04}, ("dead_zone", "threshold_error"), "half_width", 0.04),
    ],
)
def test_what_an_operator_model_misses_is_named(hidden, expected, name, true):
    found = gap(Operator(), operator_run("fit", 1, **hidden), operator_run("held", 2, **hidden))
    if expected is None:
        assert (found.verdict, found.effects) == ("none", [])
        return
    assert (found.verdict, effect(found)) == ("named", expected)
    # The Pade approximation of the component is 0.4 ms off at the highest frequency: (w T)^5 / 720 / w
    assert value(found, name)[0] == pytest.approx(true, rel=0.02)
