"""Recordings in the formats of other programs, and text as other programs write it, hold the same run as the CSV."""

import gzip
from pathlib import Path

import numpy as np
import pytest

from fmus.support.errors import InputError, MissingToolError
from motofmi.cli.main import main
from motofmi.frequency_response.estimators import estimate
from motofmi.recordings import formats, readers
from motofmi.recordings.channels import CHANNELS
from motofmi.recordings.reading import read_recording, write_recording
from tests import ROOT
from tests.motofmi.recordings.test_recordings import good, text


def assert_good(recording):
    np.testing.assert_allclose(recording["steer_torque"], good()["steer_torque"], atol=1e-9)
    np.testing.assert_allclose(recording.time, good().time, atol=1e-9)
    assert recording.units == {"steer_angle": "rad", "steer_torque": "N.m"}


def test_matlab(tmp_path):
    scipy_io = pytest.importorskip("scipy.io")
    units = {"time": "s", "steer_angle": "rad", "steer_torque": "N.m"}
    scipy_io.savemat(tmp_path / "run.mat", {"time": good().time, **good().columns, "units": units})
    assert_good(read_recording(tmp_path / "run.mat"))
    (tmp_path / "bad.mat").write_text("no MATLAB file")
    with pytest.raises(InputError, match=r"bad\.mat"):
        read_recording(tmp_path / "bad.mat")


PREAMBLE = ["Drive 1", "Number of samples,2560", "Interval (ms),7.8125", ""]
AS_WIDE = ["Drive,1,left", "Date,30.11.2026,", "Interval (ms),7.8125,", ""]  # as many cells as the samples


@pytest.mark.parametrize("preamble", [PREAMBLE, PREAMBLE[:1], ["% exported", *PREAMBLE], AS_WIDE, AS_WIDE[1:2]])
@pytest.mark.parametrize("units", [True, False])
def test_what_an_instrument_writes_above_the_names_is_left_out(write, preamble, units):
    names, *rows = text(good())
    heading = ["time,steer_angle,steer_torque", "s,rad,N.m"] if units else [names]
    assert_good(read_recording(write([*preamble, *heading, *rows])))


@pytest.mark.parametrize("preamble", [["Drive 1", "Interval (ms);7,8125"], ["Antrieb;1;links", "Datum;30.11.2026;", ""]])
def test_settings_above_rows_with_decimal_commas_are_left_out(write, preamble):
    names, *rows = (line.replace(",", ";").replace(".", ",") for line in text(good(), "time (s),steer_angle (rad),steer_torque (Nm)"))
    assert_good(read_recording(write([*preamble, names, *rows])))


def test_missing_values_below_the_names_are_no_names(write):
    names, first, *rows = text(good())
    recording = read_recording(write([names, f"{first.partition(',')[0]},NA,NA", *rows]))
    np.testing.assert_allclose(recording["steer_torque"][-100:], good()["steer_torque"][-100:], atol=1e-9)


def test_a_fault_below_a_preamble_is_found_in_its_line(write):
    names, *rows = text(good())
    rows[10] = rows[10].rpartition(",")[0] + ",overload"
    with pytest.raises(InputError, match=r"line 16, column 'steer_torque \[N\.m\]': 'overload' is not a number"):
        read_recording(write([*PREAMBLE, names, *rows]))


def test_columns_of_a_matlab_matrix_are_mapped(tmp_path):
    scipy_io = pytest.importorskip("scipy.io")
    samples = np.column_stack([good().time, *good().columns.values()])
    mapping = {"log_1": "time [s]", "log_2": "steer_angle [rad]", "log_3": "steer_torque [N.m]"}
    for matrix in (samples, samples.T):
        scipy_io.savemat(tmp_path / "run.mat", {"log": matrix, "gains": np.eye(3), "rate": 128.0})
        assert_good(read_recording(tmp_path / "run.mat", mapping))
    units = {"time": "s", "steer_angle": "rad", "steer_torque": "N.m"}
    vectors = {"time": good().time, **good().columns, "units": units}
    scipy_io.savemat(tmp_path / "run.mat", {**vectors, "picture": np.ones((4000, 2))})  # longer than the samples
    assert_good(read_recording(tmp_path / "run.mat"))


def test_dates_in_parquet_are_seconds_from_the_first_one(tmp_path):
    pyarrow = pytest.importorskip("pyarrow")
    parquet = pytest.importorskip("pyarrow.parquet")
    dates = np.datetime64("2024-02-28T23:59:59.9") + (1e9 * good().time).astype("timedelta64[ns]")
    columns = {f"{name} [{good().units[name]}]": values for name, values in good().columns.items()}
    parquet.write_table(pyarrow.table({"Timestamp": dates, **columns}), tmp_path / "run.parquet")
    assert_good(read_recording(tmp_path / "run.parquet"))


def test_parquet(tmp_path):
    pyarrow = pytest.importorskip("pyarrow")
    parquet = pytest.importorskip("pyarrow.parquet")
    table = pyarrow.table(
        {
            "time [s]": good().time,
            "steer_angle [rad]": good()["steer_angle"],
            "steer_torque [N.m]": good()["steer_torque"],
        }
    )
    parquet.write_table(table, tmp_path / "run.parquet")
    assert_good(read_recording(tmp_path / "run.parquet"))


def test_universal_file(tmp_path):
    pyuff = pytest.importorskip("pyuff")
    for name, values in good().columns.items():
        data = {"type": 58, "func_type": 1, "id1": name, "rsp_node": 1, "rsp_dir": 1, "ref_node": 1, "ref_dir": 1, "binary": 0, "orddenom_spec_data_type": 0,
                "ordinate_axis_units_lab": good().units[name], "x": good().time, "data": values}  # fmt: skip
        pyuff.UFF(str(tmp_path / "run.uff")).write_sets(data, mode="add")
    recording = read_recording(tmp_path / "run.uff")
    # single precision in the file
    np.testing.assert_allclose(recording["steer_torque"], good()["steer_torque"], rtol=1e-5, atol=1e-5)


@pytest.mark.slow
def test_mdf4(tmp_path):
    asammdf = pytest.importorskip("asammdf")
    with asammdf.MDF(version="4.10") as file:
        file.append(
            [
                asammdf.Signal(values, good().time, unit=good().units[name], name=name)
                for name, values in good().columns.items()
            ]
        )
        file.save(tmp_path / "run.mf4")
    assert_good(read_recording(tmp_path / "run.mf4"))


def test_excel(tmp_path):
    """Settings above the names, a row of units, a column of labels, and a sheet of notes before that of the samples."""
    openpyxl = pytest.importorskip("openpyxl")
    book = openpyxl.Workbook()
    book.active.append(["Notes of the test, not of the samples"])
    sheet = book.create_sheet("run")
    for row in (["Drive, left", 1], [], ["time", "state", "steer_angle", "steer_torque"], ["s", None, "rad", "N.m"]):
        sheet.append(row)
    for time, *values in zip(good().time, *good().columns.values(), strict=True):
        sheet.append([float(time), "on", *map(float, values)])
    book.save(tmp_path / "run.xlsx")
    assert_good(read_recording(tmp_path / "run.xlsx"))
    book.remove(sheet)
    book.save(tmp_path / "bare.xlsx")
    with pytest.raises(InputError, match=r"bare\.xlsx: sheet 'Sheet': "):
        read_recording(tmp_path / "bare.xlsx")
    (tmp_path / "bad.xlsx").write_text("no workbook")
    with pytest.raises(InputError, match=r"bad\.xlsx: not a valid Excel file"):
        read_recording(tmp_path / "bad.xlsx")


def test_tdms(tmp_path):
    nptdms = pytest.importorskip("nptdms")
    timing = {"wf_increment": float(good().time[1]), "wf_start_offset": 0.0, "wf_samples": len(good().time)}
    channels = [
        nptdms.ChannelObject("rig", name, values, {**timing, "unit_string": good().units[name]})
        for name, values in good().columns.items()
    ]
    with nptdms.TdmsWriter(tmp_path / "run.tdms") as file:
        file.write_segment(channels)
    assert_good(read_recording(tmp_path / "run.tdms"))


def test_matlab_structs(tmp_path):
    scipy_io = pytest.importorskip("scipy.io")
    units = {"time": "s", "steer_angle": "rad", "steer_torque": "N.m"}
    columns = {"time": good().time, **good().columns}
    for name, contents in {
        "units_inside": {"run": {**columns, "units": units}},
        "units_beside": {"run": columns, "units": units},
        "a_struct_per_channel": {"run": {n: {"data": y, "unit": units[n]} for n, y in columns.items()}, "rate": 128.0},
    }.items():
        scipy_io.savemat(tmp_path / f"{name}.mat", contents)
        assert_good(read_recording(tmp_path / f"{name}.mat"))


@pytest.mark.parametrize("kind", ["mat", "parquet"])
def test_all_columns_without_units_are_reported_at_once_and_the_options_are_right(kind, tmp_path):
    columns, path = {"time": good().time, **good().columns}, tmp_path / f"run.{kind}"
    if kind == "mat":
        pytest.importorskip("scipy.io").savemat(path, columns)
    else:
        pytest.importorskip("pyarrow.parquet").write_table(pytest.importorskip("pyarrow").table(columns), path)
    with pytest.raises(InputError, match=r"columns 'time', 'steer_angle' and 'steer_torque' have no unit") as caught:
        read_recording(path)
    options = str(caught.value).split('--map "')[1:]
    assert_good(read_recording(path, dict(option.split('"')[0].split("=") for option in options)))


LINES = text(good())
NAMES, ROWS = "time,steer_angle,steer_torque", LINES[1:]
WRITTEN = {
    "latin-1": ["# Prüfstand", "time [s],steer_angle [rad],steer_torque [N.m]", *ROWS],
    "utf-8-sig": LINES,
    "utf-16": LINES,
}


@pytest.mark.parametrize("encoding", WRITTEN)
def test_encodings(encoding, tmp_path):
    (tmp_path / "run.csv").write_bytes("\r\n".join(WRITTEN[encoding]).encode(encoding))
    assert_good(read_recording(tmp_path / "run.csv"))


@pytest.mark.parametrize("encoding", ["utf-8", "latin-1"])
def test_degree_signs(encoding, tmp_path):
    (tmp_path / "run.csv").write_bytes(
        "\n".join(["time [s],steer_angle [°],steer_torque [N·m]", *ROWS]).encode(encoding)
    )
    np.testing.assert_allclose(
        read_recording(tmp_path / "run.csv")["steer_angle"], np.radians(good()["steer_angle"]), atol=1e-10
    )


@pytest.mark.parametrize("units", ["s,rad,N.m", "[s],[rad],[N.m]", "(s),(rad),(Nm)"])
@pytest.mark.parametrize("delimiter", [",", ";", "\t"])
def test_a_row_of_units(units, delimiter, tmp_path):
    lines = [line.replace(",", delimiter) for line in [NAMES, units, "", *ROWS]]
    (tmp_path / "run.txt").write_text("\n".join(lines))
    assert_good(read_recording(tmp_path / "run.txt"))


def test_a_spreadsheet_of_germany(tmp_path):
    """Separator line, units row, decimal commas, an empty last column, Latin-1."""
    rows = [
        "sep=;",
        f"{NAMES};".replace(",", ";"),
        "s;°;N.m;",
        *(f"{row.replace(',', ';').replace('.', ',')};" for row in ROWS),
    ]
    (tmp_path / "run.csv").write_bytes("\r\n".join(rows).encode("cp1252"))
    read = read_recording(tmp_path / "run.csv")
    np.testing.assert_allclose(read["steer_angle"], np.radians(good()["steer_angle"]), atol=1e-10)
    np.testing.assert_allclose(read["steer_torque"], good()["steer_torque"], atol=1e-9)


def test_other_names_of_the_channels(tmp_path):
    (tmp_path / "run.csv").write_text("\n".join(["Time (s),Steering Angle (rad),steer-torque [N.m]", *ROWS]))
    assert_good(read_recording(tmp_path / "run.csv"))


def test_a_channel_of_an_unknown_unit_that_nobody_asked_for_is_left_out(tmp_path):
    (tmp_path / "run.csv").write_text(
        "\n".join(["time [s],steer_angle [rad],steer_torque [N.m],oil [degF]", *(f"{row},80" for row in ROWS)])
    )
    read = read_recording(tmp_path / "run.csv")
    assert_good(read)
    assert read.warnings == ("oil is left out: its unit [degF] is unknown",)


def test_acceleration_in_g_is_said_to_be_gram(tmp_path):
    (tmp_path / "run.csv").write_text("\n".join(["time [s],mockup_acceleration [g],steer_torque [N.m]", *ROWS]))
    with pytest.raises(InputError, match=r"\[gn\]"):
        read_recording(tmp_path / "run.csv")


@pytest.mark.parametrize("name", ["run.csv", "run.txt"])
def test_packed_text(name, tmp_path):
    (tmp_path / f"{name}.gz").write_bytes(gzip.compress("\n".join(LINES).encode()))
    read = read_recording(tmp_path / f"{name}.gz")
    assert_good(read)
    assert read.name == "run"
    (tmp_path / "cut.csv.gz").write_bytes(gzip.compress("\n".join(LINES).encode())[:2000])
    with pytest.raises(InputError, match=r"cut\.csv\.gz: not a valid \.gz file"):
        read_recording(tmp_path / "cut.csv.gz")


def test_a_missing_row_does_not_smear_what_is_reduced(tmp_path):
    """Where rows are missing, the reduced recording has a gap; elsewhere it is the same as without."""
    fast = good(20_000, 1000.0)
    paths = [tmp_path / "whole.csv", tmp_path / "gap.csv"]
    write_recording(fast, paths[0])
    lines = paths[0].read_text().splitlines()
    paths[1].write_text("\n".join([*lines[:9001], *lines[9051:]]))
    whole, gap = (read_recording(path, rate=125.0) for path in paths)
    assert any("missing" in w for w in gap.warnings)
    assert 0 < len(whole.time) - len(gap.time) < 30  # the 20 periods of the filter and the six of the gap
    at = np.searchsorted(whole.time, gap.time - 1e-6)
    np.testing.assert_allclose(gap["steer_torque"], whole["steer_torque"][at], atol=1e-9)


READER = '''
"""Recordings of the kind this test made up: one number in a line, all channels of a sample after each other."""

import numpy as np

from motofmi.recordings.table import Format, Table


def read(path):
    rows = np.loadtxt(path).reshape(-1, 3)
    return Table.of(zip(("time", "steer_angle", "steer_torque"), ("s", "rad", "N.m"), rows.T))


FORMAT = Format("one in a line", (".lines",), read)
'''


def test_a_format_is_one_file(tmp_path, monkeypatch, capsys):
    """A reader in a folder of the package is used, and listed in help texts and messages, without any other change."""
    recording = tmp_path / "run.lines"
    np.savetxt(recording, np.column_stack([good().time, *good().columns.values()]).ravel())
    assert ".lines" not in formats.supported()
    (tmp_path / "one_in_a_line.py").write_text(READER)
    monkeypatch.setattr(readers, "__path__", [*readers.__path__, str(tmp_path)])
    assert_good(read_recording(recording))
    binary = tmp_path / "run.bin"
    binary.write_bytes(bytes(10))
    with pytest.raises(InputError, match=r"\.lines"):
        read_recording(binary)
    assert main(["frf", "--help"]) == 0
    assert ".lines" in capsys.readouterr().out


def test_a_package_that_is_not_installed_is_named(tmp_path, monkeypatch):
    (tmp_path / "other.py").write_text(
        READER.replace("read)", 'read, needs="a_package_that_nobody_wrote")').replace(".lines", ".other")
    )
    (tmp_path / "run.other").write_text("1")
    monkeypatch.setattr(readers, "__path__", [*readers.__path__, str(tmp_path)])
    with pytest.raises(MissingToolError, match=r"a_package_that_nobody_wrote: pip install motofmi\[formats\]"):
        read_recording(tmp_path / "run.other")


def test_the_documentation_lists_every_format_and_channel():
    page = (ROOT / "docs" / "identification.md").read_text("utf-8")
    assert [suffix for suffix in formats.formats() if suffix not in page] == []
    assert [c.name for c in CHANNELS.values() if f"| `{c.name}` | {c.unit} | {c.meaning} |" not in page] == []


def test_missing_torque_says_which_column_to_map(tmp_path):
    path = Path(tmp_path / "missing_torque.csv")
    path.write_text("\n".join(["time [s],steer_angle [rad],T [N.m]", *ROWS]))
    with pytest.raises(
        InputError,
        match=r'recording missing_torque\.csv has no column .steer_torque. .*steer_angle, T.*"COLUMN=steer_torque',
    ):
        estimate(read_recording(path))


def test_a_column_in_another_kind_of_unit_is_refused_with_the_option_that_reads_its_numbers(write):
    """The current of a motor stands for its torque; the numbers are scaled in the file, or read as they are."""
    lines = text(good(), "time [s],steer_angle [deg],current [A]")
    mapping = {"current": "steer_torque"}
    with pytest.raises(InputError, match=r'scale its numbers in the file, or add --map "current=steer_torque \[N\.m\]" to read'):
        read_recording(write(lines), mapping)
    recording = read_recording(write(lines), {"current": "steer_torque [N.m]"})
    np.testing.assert_allclose(recording["steer_torque"], good()["steer_torque"], atol=1e-9)
    assert recording.converted == {"steer_angle"}
