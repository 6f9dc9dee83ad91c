"""Modes as a notebook uses them: keys, a table, a data frame, a figure."""

import numpy as np
import pandas as pd
import pytest

from fmus import InputError
from rider_fmu import riders
from vehicle_fmu import MODES, modes, motorcycles, over_speed, ridden

SPEEDS = np.array([10.0, 30.0, 50.0])  # m/s


@pytest.fixture(scope="module")
def found():
    return modes(over_speed(ridden(motorcycles.load("sharp_1971"), riders.load("mean_2011"))), SPEEDS)


def test_a_wrong_mode_is_an_error_with_the_nearest_name(found):
    with pytest.raises(
        InputError, match=r"unknown mode 'rear-wobble', did you mean 'rear_wobble'\? \(valid: capsize, rear_wobble"
    ):
        found["rear-wobble"]


def test_reprs_are_one_line_of_what_is_there(found):
    assert repr(found) == f"Modes(modes: 3 speeds, 10 to 50 m/s; {', '.join(found.unstable)})"
    assert repr(found["weave"]).startswith("Mode(3 of 3 speeds, ") and "Hz" in repr(found["weave"])
    page = found._repr_html_()
    assert "<th>damped frequency [Hz]</th>" in page and "<td>weave</td>" in page and "<img" in page


def test_the_data_frame_has_a_row_for_each_speed_and_units_in_its_columns(found):
    table = found.to_dataframe()
    assert isinstance(table, pd.DataFrame) and len(table) == 3
    assert table["speed [m/s]"].tolist() == SPEEDS.tolist()
    assert table["wobble real [1/s]"].to_numpy() == pytest.approx(found["wobble"].eigenvalue.real)
    assert table["wobble frequency [Hz]"].to_numpy() == pytest.approx(
        table["wobble imag [rad/s]"].to_numpy() / (2 * np.pi)
    )


@pytest.mark.slow
def test_the_dataset_has_modes_and_speeds_as_coordinates(found):
    data = found.to_xarray()
    assert data.frequency.sel(mode="weave", speed=30.0) == pytest.approx(found["weave"].frequency[1])
    assert data.frequency.attrs["units"] == "Hz"


def test_the_dictionary_has_the_keys_of_the_command(found):
    result = found.to_dict()
    assert set(result) == {"speed", "eigenvalues", "modes", "unstable", "mixed"}
    assert set(result["modes"]) == set(MODES)
    assert set(result["modes"]["weave"]) == {"eigenvalue", "frequency", "damping_ratio"}


def test_the_figure_is_a_root_locus_with_units_and_a_shaded_unstable_half(found):
    axes = found.plot()
    assert (axes.get_xlabel(), axes.get_ylabel()) == ("real part [1/s]", "imaginary part [rad/s]")
    assert {text.get_text() for text in axes.get_legend().get_texts()} == {m.replace("_", "-") for m in found.unstable}
    largest = max(found[m].eigenvalue.real.max() for m in found.unstable)
    assert axes.get_xlim()[1] < max(2 * largest, 50.0)  # the shaded half does not set the limits
    assert len(axes.patches) == 1
    again = found.plot(axes, label="again")
    assert again is axes and len(axes.patches) == 1
