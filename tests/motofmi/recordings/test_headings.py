"""Columns of one name, signs, dates in the place of times, and files without a time."""

import json
from datetime import datetime, timedelta

import numpy as np
import pytest

from fmus.support.errors import InputError
from motofmi.recordings.reading import read_recording

COUNT = 64
TIME = np.arange(COUNT) / 100.0
FORCE = np.sin(TIME)
QUANTITIES = {"time": "s", "force": "N"}


def table(heading, *columns):
    return [heading, *(",".join(map(str, row)) for row in zip(*columns, strict=True))]


@pytest.mark.parametrize(
    "heading", ["time [s],force (V),force (N)", "time [s],force [V],force [N]", "Time [s],Force [V],Force [N]"]
)
def test_of_two_columns_of_one_name_that_with_the_expected_dimension_is_used(write, heading):
    run = read_recording(write(table(heading, TIME, FORCE / 40, FORCE)), quantities=QUANTITIES)
    np.testing.assert_array_equal(run["force"], FORCE)
    (voltage,) = (y for n, y in run.columns.items() if n.lower() == "force [v]")
    np.testing.assert_array_equal(voltage, FORCE / 40)


@pytest.mark.parametrize("heading", ["Spring Force", "spring-force", "SPRING_FORCE"])
def test_an_expected_name_in_other_letters_is_that_quantity(write, heading):
    path = write(table(f"time [s],{heading} [kN]", TIME, FORCE / 1000))
    run = read_recording(path, quantities={"time": "s", "spring_force": "N"})
    np.testing.assert_allclose(run["spring_force"], FORCE, rtol=1e-12)  # a product and a quotient


def test_a_name_in_its_own_letters_comes_before_one_in_others(write):
    path = write(table("time [s],Force [N],force [N]", TIME, 2 * FORCE, FORCE))
    np.testing.assert_array_equal(read_recording(path, quantities=QUANTITIES)["force"], FORCE)


def test_columns_of_one_name_are_mapped_with_their_units(write):
    path = write(table("time [s],Load (V),Load (kN)", TIME, FORCE / 40, FORCE / 1000))
    run = read_recording(path, {"Load (kN)": "force"}, quantities=QUANTITIES)
    np.testing.assert_allclose(run["force"], FORCE, rtol=1e-12)  # a product and a quotient
    with pytest.raises(InputError, match="Load"):
        read_recording(path, {"Load": "force"}, quantities=QUANTITIES)


def test_columns_of_one_name_and_unit_are_refused(write):
    with pytest.raises(InputError, match=r"two columns are named force \[N\]; rename all but one"):
        read_recording(write(table("time [s],force [N],force [N]", TIME, FORCE, FORCE)))


def test_columns_of_one_name_have_the_name_of_their_group_before_it(write):
    """As programs for motion capture write them: a row of groups, each over its first column, then a row of names."""
    path = write(["plate,,actuator,", *table("t,x,t,x", TIME, 2 * FORCE, TIME, FORCE)])
    run = read_recording(path, {"actuator t": "time [s]", "actuator x": "force [N]", "plate x": "other [N]"})
    np.testing.assert_array_equal(run.time, TIME)
    np.testing.assert_array_equal(run["force"], FORCE)
    np.testing.assert_array_equal(run["other"], 2 * FORCE)


def test_a_minus_reverses_the_sign(write):
    path = write(table("time [s],Load [N]", TIME, FORCE))
    run = read_recording(path, {"Load": "-force"}, quantities=QUANTITIES)
    np.testing.assert_array_equal(run["force"], -FORCE)
    with_unit = read_recording(path, {"Load": "-force [kN]"}, quantities=QUANTITIES)
    np.testing.assert_array_equal(with_unit["force"], -1000 * FORCE)


@pytest.mark.parametrize("zone", ["", "+01:00"])
def test_dates_are_seconds_from_the_first_one(write, zone):
    begin = datetime(2024, 2, 28, 23, 59, 59, 900000)  # midnight and the leap day follow
    dates = [f"{begin + timedelta(seconds=t)}{zone}" for t in TIME.tolist()]
    run = read_recording(write(table("Timestamp,force [N]", dates, FORCE)), quantities=QUANTITIES)
    np.testing.assert_allclose(run.time, TIME, atol=1e-6)  # dates have microseconds
    np.testing.assert_array_equal(run["force"], FORCE)


def test_times_of_a_day_are_seconds_from_the_first_one(write):
    times = [f"09:59:59.{i:03}" if i < 1000 else f"10:00:00.{i - 1000:03}" for i in range(990, 990 + COUNT)]
    run = read_recording(write(table("Timestamp,force [N]", times, FORCE)), quantities=QUANTITIES)
    np.testing.assert_allclose(run.time, np.arange(COUNT) / 1000, atol=1e-9)


@pytest.mark.parametrize("wrong", ["2024-13-01 00:00:00", "2024-02-28 23:59:59+01:00"])
def test_a_faulty_date_is_found(write, wrong):
    dates = [f"2024-02-28 23:59:{i:02}" for i in range(60)]
    path = write(table("Timestamp,force [N]", [*dates[:40], wrong, *dates[41:]], FORCE[:60]))
    with pytest.raises(InputError, match=f"line 42, column 'Timestamp': '{wrong[:19]}.*is not a number"):
        read_recording(path, quantities=QUANTITIES)


def test_without_a_time_the_sampling_rate_of_the_rig_is_asked_for(write, tmp_path):
    path = write(table("count,force [N]", range(COUNT), FORCE))
    with pytest.raises(InputError, match=r"map one with --map .*or give the sampling rate in rig\.json"):
        read_recording(path, quantities=QUANTITIES)
    (tmp_path / "rig.json").write_text(json.dumps({"sampling": {"value": 0.1, "unit": "kHz"}}))
    run = read_recording(path, quantities=QUANTITIES)
    np.testing.assert_allclose(run.time, TIME, rtol=1e-14)
    np.testing.assert_array_equal(run["force"], FORCE)
    (tmp_path / "rig.json").write_text(json.dumps({"sampling": {"value": 0, "unit": "Hz"}}))
    with pytest.raises(InputError, match="expected a sampling rate above 0"):
        read_recording(path, quantities=QUANTITIES)


def test_rows_are_counted_over_all_blocks(write, tmp_path):
    count = 50_010  # more rows than a block has
    path = write(table("force [N],torque [N.m]", np.arange(count), np.arange(count)))
    (tmp_path / "rig.json").write_text(json.dumps({"sampling": {"value": 100, "unit": "Hz"}}))
    run = read_recording(path)
    np.testing.assert_allclose(run.time, run["force"] / 100.0, rtol=1e-14)


@pytest.mark.parametrize("delimiter", [",", ";", "\t"])
@pytest.mark.parametrize("mark", [".", ","])
def test_the_delimiter_in_a_quoted_cell_is_a_character(write, delimiter, mark):
    """As spreadsheet programs write headings with commas, and numbers with decimal commas between commas."""
    heading = delimiter.join(["time [s]", '"Wheel, Speed [RPM]"', '"force [N]"'])
    values = zip(TIME, FORCE, 2 * FORCE, strict=True)
    rows = [delimiter.join(f'"{x!r}"'.replace(".", mark) for x in map(float, row)) for row in values]
    run = read_recording(write([heading, *rows]), {"Wheel, Speed": "speed"}, quantities={"time": "s", "force": "N"})
    np.testing.assert_allclose(run["speed"], FORCE * np.pi / 30, rtol=1e-12)  # a product
    np.testing.assert_array_equal(run["force"], 2 * FORCE)


SAMPLES = np.column_stack([TIME, FORCE])


@pytest.mark.parametrize("header", ["time[s] force[N]", "time [s]  force (N)", "time force\ns N", "rig 7, 2 channels\ntime [s] force [N]"])
@pytest.mark.parametrize("comments", ["# ", "% ", ""])
def test_what_numpy_writes_is_read(tmp_path, header, comments):
    """Blanks between cells, and the names in a comment (numpy.savetxt)."""
    np.savetxt(tmp_path / "run.txt", SAMPLES, header=header, comments=comments, fmt="%12.9f")
    run = read_recording(tmp_path / "run.txt", quantities=QUANTITIES)
    np.testing.assert_allclose(run["force"], FORCE, atol=1e-9)  # digits that are written
    assert run.units["force"] == "N" and len(run.time) == COUNT


def test_names_in_a_comment_are_those_of_columns_between_tabs(write):
    lines = ["#Rig 7", "#time [s]\tforce [N]", *(f"{t}\t{y}" for t, y in SAMPLES)]
    np.testing.assert_array_equal(read_recording(write(lines), quantities=QUANTITIES)["force"], FORCE)


def test_a_comment_that_is_no_heading_is_left_out(write):
    lines = ["# time [s], force [V]", *table("time [s],force [N]", TIME, FORCE)]
    assert read_recording(write(lines), quantities=QUANTITIES).units["force"] == "N"
    with pytest.raises(InputError, match="line 2 holds numbers, expected a header row"):
        read_recording(write(["# measured at noon", *table("time [s],force [N]", TIME, FORCE)[1:]]), quantities=QUANTITIES)


def test_decimal_commas_between_blanks_are_read(write):
    lines = ["time [s]   force [N]", *(f" {t:.3f}   {y:.6f}".replace(".", ",") for t, y in SAMPLES)]
    np.testing.assert_allclose(read_recording(write(lines), quantities=QUANTITIES)["force"], FORCE, atol=1e-6)
    with_blanks = ["time [s], force [N]", *(f"{t:.3f}, {y:.6f}" for t, y in SAMPLES)]
    np.testing.assert_allclose(read_recording(write(with_blanks), quantities=QUANTITIES)["force"], FORCE, atol=1e-6)


def test_tabs_and_blanks_in_one_line_are_read(write):
    lines = ["time [s]\tforce [N] error", *(f"{t}\t{y} 0.008" for t, y in SAMPLES)]
    np.testing.assert_array_equal(read_recording(write(lines), quantities=QUANTITIES)["force"], FORCE)
