"""Recordings, frequency responses and fits as a notebook shows them, and as other libraries take them."""

from functools import lru_cache

import control
import matplotlib.pyplot as plt
import numpy as np
import pytest

from fmus.support.errors import InputError
from motofmi.frequency_response.estimators import estimate
from motofmi.frequency_response.excitation import sweep
from motofmi.frequency_response.frf import mean_frf
from motofmi.identification.parameter_fit import identify
from motofmi.virtual_rig.simulated_rig import steer_test
from motofmi.workflows.measured_rider import rig_response
from rider_fmu import riders


@pytest.fixture(autouse=True)
def closed():
    yield
    plt.close("all")


@lru_cache
def runs():
    return tuple(
        steer_test(riders.load("mean_2011"), 0.125, sweep(duration=60), seed=seed, oversampling=2) for seed in (1, 2)
    )


@lru_cache
def frfs():
    return tuple(estimate(run) for run in runs())


@lru_cache
def found():
    return identify(frfs(), rig_response())


@pytest.mark.slow
@pytest.mark.parametrize("make", [lambda: runs()[0], lambda: frfs()[0], lambda: mean_frf(frfs()), found])
def test_short_in_a_line_and_a_table_with_a_figure_in_a_notebook(make):
    thing = make()
    assert len(repr(thing)) < 500 and "\n" not in repr(thing) and type(thing).__name__ in repr(thing)
    page = thing._repr_html_()
    assert "<table>" in page and "data:image/png" in page
    assert np.size(thing.plot()) >= 2
    axes = thing.plot()
    assert thing.plot(axes) is axes


def test_recording_as_a_table():
    run = runs()[0]
    frame = run.to_dataframe()
    np.testing.assert_array_equal(frame["steer_torque"], run["steer_torque"])
    np.testing.assert_array_equal(frame.index, run.time)
    assert frame.attrs["units"] == {"time": "s", **run.units}


def test_a_wrong_column_is_named_with_the_nearest():
    with pytest.raises(InputError, match=r"column of recording .* 'steer_torq', did you mean 'steer_torque'"):
        runs()[0]["steer_torq"]


def test_frf_as_a_table_and_in_python_control():
    frf = frfs()[0]
    frame = frf.to_dataframe()
    np.testing.assert_allclose(
        frame["modulus [(rad/s2)/(N.m)]"] * np.exp(1j * np.radians(frame["phase [deg]"])), frf.inertance
    )
    data = frf.to_control()
    assert isinstance(data, control.FrequencyResponseData) and data.input_labels == ["steer_torque"]
    np.testing.assert_allclose(data(2j * np.pi * frf.frequency), frf.inertance, rtol=1e-9)
    assert set(frf.to_dict()) == {
        "name",
        "reference",
        "frequency",
        "inertance",
        "standard_error",
        "coherence",
        "warnings",
    }


def test_fit_as_a_table():
    frame = found().to_dataframe()
    assert list(frame.columns) == ["value", "standard_error", "unit"] and len(frame) == 6
    assert frame.loc["rider.arm_stiffness", "unit"] == "N.m/rad"
    assert frame.loc["rider.arm_stiffness", "value"] == found()["rider.arm_stiffness"]
    with pytest.raises(
        InputError, match=r"unknown parameter 'rider\.arm_stifness', did you mean 'rider\.arm_stiffness'"
    ):
        found()["rider.arm_stifness"]
