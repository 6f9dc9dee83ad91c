"""Recordings: what is read back, and the message for each kind of bad file."""

import subprocess
import sys
from types import SimpleNamespace

import numpy as np
import psutil
import pytest

from fmus.support.errors import InputError
from motofmi.frequency_response.estimators import estimate
from motofmi.recordings.reading import read_recording, write_recording
from motofmi.recordings.recording import Recording
from tests import SHARED_DATA

RATE = 128.0
CASES = SHARED_DATA / "gap_open"


def good(samples: int = 2560, rate: float = RATE) -> Recording:
    """A rigid handlebar of 0.5 kg.m2 on a sine of growing frequency: torque and angle are in phase opposition."""
    time = np.arange(samples) / rate
    phase = 2 * np.pi * (0.5 * time + 0.1 * time**2)
    angle = 0.05 * np.sin(phase)
    torque = 0.5 * np.gradient(np.gradient(angle, time), time) + 2.0 * np.gradient(angle, time)
    return Recording(
        "good", time, {"steer_angle": angle, "steer_torque": torque}, {"steer_angle": "rad", "steer_torque": "N.m"}
    )


def text(recording: Recording, header: str = "time [s],steer_angle [rad],steer_torque [N.m]") -> list[str]:
    rows = np.column_stack([recording.time, *recording.columns.values()])
    return [header, *(",".join(f"{x:.9g}" for x in row) for row in rows)]


def warned(path, *words):
    recording = read_recording(path)
    assert any(all(word in warning for word in words) for warning in recording.warnings), recording.warnings
    return recording


def test_written_recording_is_read_back(tmp_path):
    recording = good()
    write_recording(recording, tmp_path / "run.csv")
    back = read_recording(tmp_path / "run.csv")
    assert back.warnings == ()
    assert back.rate == pytest.approx(RATE, rel=1e-9)
    for name, values in recording.columns.items():
        # six digits are written
        np.testing.assert_allclose(back[name], values, rtol=1e-5, atol=1e-12)
    assert [p.name for p in tmp_path.iterdir()] == ["run.csv"]  # nothing half-written stays beside it


def test_degrees_and_other_units_become_si(write):
    lines = text(good(), "time [ms],steer_angle [deg],steer_torque [mNm]")
    recording = read_recording(write(lines))
    np.testing.assert_allclose(recording["steer_angle"], np.radians(good()["steer_angle"]), atol=1e-10)
    np.testing.assert_allclose(recording["steer_torque"], 1e-3 * good()["steer_torque"], atol=1e-7)
    assert recording.rate == pytest.approx(1000 * RATE, rel=1e-6)
    assert recording.units == {"steer_angle": "rad", "steer_torque": "N.m"}


def test_columns_are_mapped_and_get_units(write):
    lines = text(good(), "t,Pot (deg),Torque")
    mapping = {"t": "time [s]", "Pot": "steer_angle", "Torque": "steer_torque [N.m]"}
    recording = read_recording(write(lines), mapping)
    np.testing.assert_allclose(recording["steer_angle"], np.radians(good()["steer_angle"]), atol=1e-10)
    with pytest.raises(InputError, match="unknown column 'Pott', did you mean 'Pot'"):
        read_recording(write(lines), {"Pott": "steer_angle"})


@pytest.mark.parametrize("target, reverse", [("steer_torque", "-steer_torque"), ("-steer_torque", "steer_torque")])
def test_the_option_that_reverses_a_column_names_its_heading(write, target, reverse):
    path = write(text(good(), "time [s],steer_angle [rad],Load Cell [N.m]"))
    recording = read_recording(path, {"Load Cell": target})
    assert recording.option("steer_torque") == f'--map "Load Cell={reverse}"'
    assert recording.option("steer_angle", "deg") == '--map "steer_angle=steer_angle [deg]"'
    again = read_recording(path, {"Load Cell": reverse})
    np.testing.assert_array_equal(again["steer_torque"], -recording["steer_torque"])


def test_semicolons_comments_and_a_byte_order_mark(write):
    lines = [line.replace(",", ";") for line in text(good())]
    lines[0] = "\ufeff" + lines[0]
    np.testing.assert_allclose(read_recording(write(lines))["steer_angle"], good()["steer_angle"], atol=1e-9)
    np.testing.assert_allclose(
        read_recording(write(["# a test", *text(good())]))["steer_angle"], good()["steer_angle"], atol=1e-9
    )


# Bad recordings, one by one -------------------------------------------------------------------------


def refused(path, *words, **options):
    with pytest.raises(InputError) as caught:
        read_recording(path, **options)
    message = str(caught.value)
    assert "\n" not in message
    for word in words:
        assert word in message, message


def test_wrong_unit(write):
    refused(write(text(good(), "time [s],steer_angle [rad],steer_torque [N]")), "steer_torque", "[N]", "[N.m]")


def test_unknown_unit(write):
    refused(write(text(good(), "time [s],steer_angle [gon],steer_torque [N.m]")), "unknown unit [gon]")


def test_no_unit(write):
    refused(write(text(good(), "time [s],steer_angle,steer_torque [N.m]")), "no unit", "steer_angle [rad]", "--map")


def test_text_in_a_column_is_named_with_its_line(write):
    lines = text(good())
    lines[700] = lines[700].replace(",", ",overload ", 1)
    refused(write(lines), "line 701", "'steer_angle [rad]'", "overload")


@pytest.mark.parametrize("rate", [None, 64.0])
def test_a_label_without_a_unit_is_left_out(write, rate):
    lines = text(good(), "comment,time [s],steer_angle [rad],steer_torque [N.m]")
    plain, labelled = write(text(good()), "plain.csv"), write([lines[0], *("hands on," + line for line in lines[1:])])
    expected, found = read_recording(plain, rate=rate), read_recording(labelled, rate=rate)
    assert set(found.columns) == set(expected.columns)
    np.testing.assert_array_equal(found["steer_torque"], expected["steer_torque"])
    lines[300] = lines[300].replace(",", ",overload", 1)
    refused(
        write([lines[0], *("hands on," + line for line in lines[1:])]), "line 301", "'steer_angle [rad]'", "overload"
    )


def test_missing_cell_and_ragged_line(write):
    lines = text(good())
    lines[10] = ",".join(lines[10].split(",")[:2])
    refused(write(lines), "line 11", "2 columns", "header has 3")


def test_decimal_commas(write):
    lines = [line.replace(",", ";").replace(".", ",") for line in text(good())]
    lines[0] = "time [s];steer_angle [rad];steer_torque [N.m]"
    np.testing.assert_allclose(read_recording(write(lines))["steer_torque"], good()["steer_torque"], atol=1e-9)
    lines[300] = lines[300].replace(",", ".")
    refused(write(lines), "decimal commas and decimal points")
    points = [line.replace(",", ";") for line in text(good())]
    points[2000] = points[2000].replace(".", ",")  # far below the lines from which the layout is found
    refused(write(points), "line 2001", "a decimal comma?")


@pytest.mark.parametrize("cell", ["", "nan", "NaN", "n/a", "-"])
def test_missing_values_are_missing_samples(write, cell):
    """What is bridged, and what is refused, is the same for missing values and for missing rows."""
    lines = text(good())
    without_rows = write([line for k, line in enumerate(lines) if not 401 <= k < 411], "rows.csv")
    lines[401:411] = [",".join([*line.split(",")[:2], cell]) for line in lines[401:411]]
    values = write(lines, "values.csv")
    recording = warned(values, "steer_torque has no value in 10 samples", f"{400 / RATE:g} s", f"{409 / RATE:g} s")
    np.testing.assert_array_equal(recording["steer_angle"], read_recording(without_rows)["steer_angle"])
    found, expected = (estimate(read_recording(path)) for path in (values, without_rows))
    np.testing.assert_array_equal(found.inertance, expected.inertance)


def test_many_missing_values_are_refused_as_many_missing_rows_are(write):
    recording = good()
    recording.columns["steer_torque"][500:580] = np.nan
    found = warned(write(text(recording)), "steer_torque", "80 samples", f"{500 / RATE:g} s", f"{579 / RATE:g} s")
    with pytest.raises(InputError, match="80 of 2560 samples are missing"):
        estimate(found)


def test_an_empty_channel(write):
    lines = text(good(), "time [s],steer_angle [rad],steer_torque [N.m],spare [V]")
    read = warned(
        write([lines[0], *(f"{line}," for line in lines[1:])]), "spare is left out", "no value in 2560 of 2560 samples"
    )
    assert len(read.time) == 2560 and set(read.columns) == {"steer_angle", "steer_torque"}
    lines = text(good())
    refused(
        write([lines[0], *(line.rsplit(",", 1)[0] + "," for line in lines[1:])]),
        "steer_torque has no value in any sample",
        "connected",
    )


def test_constant_channel(write):
    recording = good()
    recording.columns["steer_torque"][:] = 0.25
    refused(write(text(recording)), "steer_torque", "constant at 0.25 N.m")


def test_too_few_samples(write):
    refused(write(text(good())[:3]), "2 samples", "at least 16")


def test_missing_column_names_those_there(write):
    recording = read_recording(write(text(good(), "time [s],bar_angle [rad],steer_torque [N.m]")))
    with pytest.raises(
        InputError,
        match=r"recording run\.csv has no column 'steer_angle' \(columns there: bar_angle, steer_torque\).*--map \"COLUMN=steer_angle \[rad\]\"",
    ):
        estimate(recording)


def test_no_time_column(write):
    refused(
        write(text(good(), "clock [s],steer_angle [rad],steer_torque [N.m]")), "no column 'time [s]'", "clock", "--map"
    )


def test_no_header_empty_file_no_file_no_text(write, tmp_path):
    refused(write(text(good())[1:]), "line 1 holds numbers", "header row")
    refused(write([""]), "is empty", "header row")
    refused(write(text(good())[:1]), "no rows of numbers below the header")
    refused(tmp_path / "nowhere.csv", "nowhere.csv", "No such file")
    refused(tmp_path, "is a folder", "*.csv")
    binary = tmp_path / "run.dat"
    binary.write_bytes(bytes(range(256)) * 10)
    refused(binary, "neither text", ".mf4", ".unv", ".gz")


def test_time_that_goes_back(write):
    lines = text(good())
    refused(write(lines + lines[1:200]), "time goes back 1 times", "one file is one run")


# Large files -----------------------------------------------------------------------------------------

LIMITED = """
import resource, sys
import scipy.signal  # what is imported on use would count as memory of the recording
from motofmi.recordings.reading import read_recording
size = int(open("/proc/self/statm").read().split()[0]) * resource.getpagesize()
resource.setrlimit(resource.RLIMIT_AS, (size + 120_000_000, size + 120_000_000))
rate = float(sys.argv[2]) if len(sys.argv) > 2 else None
try:
    recording = read_recording(sys.argv[1], rate=rate)
    print(len(recording.time), recording.rate, *recording.warnings)
except Exception as error:
    print(type(error).__name__, error)
"""


@pytest.mark.study
@pytest.mark.skipif(sys.platform != "linux", reason="limits memory through RLIMIT_AS")
def test_130_MB_under_a_limit_of_120_MB(tmp_path):
    path = tmp_path / "long.csv"
    rate, block, extra = 2000.0, 20_000, 10
    time = np.arange(block) / rate
    more = ",0.123456789012" * extra
    tails = [
        f",{0.05 * np.sin(2 * np.pi * 3 * t):.9e},{10 * np.cos(2 * np.pi * 3 * t):.9e}{more}\n" for t in time
    ]  # whole periods
    with path.open("w") as file:
        file.write(
            f"time [s],steer_angle [rad],steer_torque [N.m],{','.join(f'spare_{k} [V]' for k in range(extra))}\n"
        )
        for k in range(36):
            file.write("".join(f"{k * block / rate + t:.4f}{tail}" for t, tail in zip(time, tails, strict=True)))
    assert path.stat().st_size > 130e6

    def read(*arguments):
        return subprocess.run(
            [sys.executable, "-c", LIMITED, path, *arguments], capture_output=True, text=True, check=True
        ).stdout

    message = read()
    assert message.startswith("InputError") and "does not fit" in message and "--rate 128" in message
    samples, reduced_rate, *note = read("125").split()
    assert float(reduced_rate) == pytest.approx(125)
    assert abs(int(samples) - 36 * block / 16) <= 21
    assert note[0] == "reduced"
    path.unlink()


def test_a_recording_larger_than_the_free_memory_is_refused_before_it_is_read(write, monkeypatch):
    path = write(
        [
            "time [s],steer_angle [rad],steer_torque [N.m]",
            *(f"{0.01 * k:.2f},{0.1 * (k % 41)},{0.2 * (k % 37)}" for k in range(1000)),
        ]
    )
    monkeypatch.setattr(psutil, "virtual_memory", lambda: SimpleNamespace(available=1000))
    with pytest.raises(InputError, match=r"does not fit in memory.*--rate 128"):
        read_recording(path)
    assert read_recording(path, rate=20).rate == pytest.approx(20)


def test_reduction_keeps_what_is_in_the_band_and_removes_what_would_alias(write):
    time = np.arange(20_000) / 1000.0
    angle = 0.05 * np.sin(2 * np.pi * 5 * time)
    columns = {"steer_angle": angle + 0.01 * np.sin(2 * np.pi * 120 * time), "steer_torque": 10 * angle}
    path = write(text(Recording("", time, columns, {"steer_angle": "rad", "steer_torque": "N.m"})))
    reduced = read_recording(path, rate=125)
    assert reduced.rate == pytest.approx(125, rel=1e-6)
    # a Hamming filter passes 5 of 62.5 Hz within 0.3 % and stops 120 Hz by 50 dB
    np.testing.assert_allclose(
        reduced["steer_angle"], 0.05 * np.sin(2 * np.pi * 5 * reduced.time), atol=0.003 * 0.05 + 0.01 * 10 ** (-50 / 20)
    )


@pytest.mark.slow
@pytest.mark.skipif(not CASES.exists(), reason="the solved cases of ../shared are not here")
def test_solved_cases_are_read_without_a_warning():
    for path in sorted(CASES.glob("*/*.csv")):
        recording = read_recording(path)
        assert recording.warnings == () and recording.rate == pytest.approx(128)
        assert recording.rig["handlebar_inertia"]["value"] == 0.125
