"""What commands print: nothing is cut, values of a grid differ, every number has its unit."""

import json
import os
import re
import subprocess
import sys

import numpy as np
import pytest
from scipy.io import loadmat

from motofmi.cli.main import main
from motofmi.cli.screen import Screen, grid_values
from tests import ROOT


def printed(capsys, *arguments):
    assert main([*map(str, arguments)]) == 0
    return capsys.readouterr().out


@pytest.mark.slow
def test_tables_are_not_cut_without_a_terminal(capsys):
    shipped = json.loads(printed(capsys, "list", "--json", "-"))
    out = printed(capsys, "list")
    lines = out.splitlines()
    for kind in ("riders", "motorcycles", "dampers", "mechanisms"):
        for entry in shipped[kind]:
            (line,) = (line for line in lines if line.split()[:1] == [entry["name"]])
            assert entry["description"] in line and entry["source"] in line
    for effect in shipped["effects"]:
        assert (
            len(
                [
                    line
                    for line in lines
                    if effect["description"] in line and effect["source"] in line and effect["form"] in line.split()
                ]
            )
            == 1
        )
    rows = [line for line in lines if line]
    assert len(set(rows)) == len(rows)  # no row twice
    assert "…" not in out


def test_one_name_is_listed_with_its_parameters(capsys):
    """Sharp 1971, Appendix 3: a trail of 0.38 ft, a steering damper of 5 lbf.ft.s; the delayed reflex has two forms."""
    lines = printed(capsys, "list", "sharp_1971").splitlines()
    rows = {line.split()[0]: line.split()[2:4] for line in lines if line.strip()}
    assert lines[0].startswith("sharp_1971: ") and "Appendix 3" in lines[1]
    assert rows["trail"] == [f"{0.38 * 0.3048:.6g}", "m"]
    assert rows["steering_damping"] == [f"{5 * 4.4482216152605 * 0.3048:.6g}", "N.m.s/rad"]
    assert printed(capsys, "list", "rider:mean_2011") == printed(capsys, "list", "mean_2011")
    assert [line for line in printed(capsys, "list", "reflex").splitlines() if line.startswith("reflex, ")][1:]


@pytest.mark.slow
@pytest.mark.skipif(os.name != "posix", reason="terminals of POSIX")
def test_tables_wrap_on_a_terminal():
    reading, writing = os.openpty()
    environment = {**os.environ, "COLUMNS": "60", "LINES": "30", "TERM": "xterm"}
    process = subprocess.Popen(
        [sys.executable, "-m", "motofmi", "list"], stdout=writing, stderr=writing, env=environment, cwd=ROOT
    )
    os.close(writing)
    received = b""
    try:
        while block := os.read(reading, 65536):
            received += block
    except OSError:  # Linux: the other end is closed
        pass
    os.close(reading)
    assert process.wait() == 0
    text = re.sub(r"\x1b\[[0-9;]*m", "", received.decode())
    assert "…" not in text
    assert max(len(line.rstrip()) for line in text.splitlines()) <= 60
    assert "Cossalter" in text and "mean_2011" in text


def test_markup_in_a_text_is_printed_as_it_is(capsys):
    screen = Screen()
    screen.print("unit [furlong], a[/red]b :smile:")
    screen.table(("name", "value"), [("a[/red]b", "1 [red]")])
    out = capsys.readouterr().out
    assert "unit [furlong], a[/red]b :smile:" in out and "a[/red]b  1 [red]" in out


@pytest.mark.parametrize("values, texts", [
    ([11.25, 11.5, 11.75], ["11.25", "11.50", "11.75"]),
    ([1.0, 2.0, 60.0], ["1", "2", "60"]),
    ([0.1 + 0.2, 0.4], ["0.3", "0.4"]),
    ([0.5 + 0.05 * k for k in range(4)], ["0.50", "0.55", "0.60", "0.65"]),
])  # fmt: skip
def test_values_of_a_grid_have_the_digits_that_tell_them_apart(values, texts):
    assert grid_values(values) == texts


def test_frequencies_of_a_table_differ(capsys):
    out = printed(capsys, "device", "damper:7.5", "--frequency", "11:12:0.25")
    assert [line.split()[0] for line in out.splitlines()[2:]] == ["11.00", "11.25", "11.50", "11.75", "12.00"]


def test_one_speed_is_no_range(capsys):
    out = printed(capsys, "modes", "--speed", "30")
    assert "capsize: unstable at 30 m/s\n" in out and "from 30" not in out
    assert "capsize: unstable from 20 to 30 m/s\n" in printed(capsys, "modes", "--speed", "20:30:5")


@pytest.mark.slow
def test_a_vehicle_alone_is_without_a_device(capsys):
    assert printed(capsys, "modes", "--speed", "30").startswith("sharp_1971 without a device: ")
    assert printed(capsys, "modes", "--speed", "30", "--device", "damper:7.5").startswith(
        "sharp_1971 with damper_7.5: "
    )


def test_names_that_are_mixed_are_explained(capsys):
    out = printed(capsys, "modes", "--device", "rider:mean_2011", "--speed", "10,20")
    assert out.count("(mixed)") == 3 and "\n(mixed): rear-wobble and rider-wobble are not distinct" in out
    assert "(mixed)" not in printed(capsys, "modes", "--device", "rider:mean_2011", "--speed", "20")


@pytest.mark.slow
def test_modes_without_a_name_say_so(capsys, tmp_path):
    out = printed(
        capsys,
        "cosimulate",
        "--device",
        "rider:mean_2011,rider:roll_1971",
        "--speed",
        "40",
        "--duration",
        "0.1",
        "--out",
        tmp_path / "run.csv",
    )
    assert re.search(r"^unnamed mode, \d\.\d\d Hz ", out, re.M) and "_Hz" not in out and "-Hz" not in out
    assert "\nResidual power: " in out


TABLES = [("modes", "--speed", "20"), ("device", "rider:mean_2011"), ("cosimulate", "--duration", "0.1")]


@pytest.mark.slow
@pytest.mark.parametrize("arguments", TABLES, ids=lambda words: words[0])
def test_every_column_of_numbers_has_a_unit(arguments, capsys, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    lines = printed(capsys, *arguments).splitlines()
    title, heading = next(
        (lines[k - 1], line) for k, line in enumerate(lines) if line.startswith(("speed", "f [", "mode "))
    )
    for column in re.split(r"\s{2,}", heading.strip()):
        # Modes are columns of frequency and damping ratio, whose units the title gives.
        assert (
            "[" in column
            or column == "mode"
            or (column in ("weave", "wobble", "capsize", "rear-wobble", "rider-wobble") and "[Hz]" in title)
        )


def numbers_in(result, path=()):
    """The innermost name under which a result holds numbers."""
    if isinstance(result, dict):
        return {
            name
            for key, value in result.items()
            if key not in ("units", "modes", "bonds", "predicted")
            for name in numbers_in(value, (*path, key))
        } | {
            name
            for key in ("modes", "bonds", "predicted")
            for entry in result.get(key, {}).values()
            for name in numbers_in(entry)
        }
    if isinstance(result, list):
        return {name for value in result for name in numbers_in(value, path)}
    return {path[-1]} if isinstance(result, (int, float)) and not isinstance(result, bool) else set()


@pytest.mark.slow
@pytest.mark.parametrize("arguments", TABLES, ids=lambda words: words[0])
def test_json_has_the_unit_of_every_quantity(arguments, capsys, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    result = json.loads(printed(capsys, *arguments, "--json", "-"))
    quantities = numbers_in(result) - {
        "steps",
        "weave",
        "wobble",
        "capsize",
        "rear_wobble",
        "rider_wobble",
    }  # counts, and the bands of `unstable`
    assert quantities <= set(result["units"])


@pytest.mark.slow
def test_a_root_locus_of_several_devices_with_its_table(capsys, tmp_path):
    out = printed(capsys, "modes", "--device", "none", "--device", "rider:mean_2011", "--device", "damper:7.5", "--speed", "10:30:10",
                  "--plot", tmp_path / "locus.png", "--csv", tmp_path / "modes.csv", "--json", tmp_path / "modes.json")  # fmt: skip
    titles = [line.partition(":")[0] for line in out.splitlines() if line.startswith("sharp_1971 ")]
    assert titles == ["sharp_1971 without a device", "sharp_1971 with mean_2011", "sharp_1971 with damper_7.5"]
    assert (tmp_path / "locus.png").read_bytes().startswith(b"\x89PNG")
    result = json.loads((tmp_path / "modes.json").read_text())
    assert list(result["devices"]) == ["none", "rider_mean_2011", "damper_7.5"]
    alone = json.loads(printed(capsys, "modes", "--device", "damper:7.5", "--speed", "10:30:10", "--json", "-"))
    assert result["devices"]["damper_7.5"]["modes"] == alone["modes"]
    heading, *rows = [line.split(",") for line in (tmp_path / "modes.csv").read_text().splitlines()]
    assert heading[:2] == ["device", "speed [m/s]"] and all(re.search(r" \[.+\]$", name) for name in heading[1:])
    assert [row[0] for row in rows] == [name for name in result["devices"] for _ in range(3)]
    weave = [float(row[heading.index("weave frequency [Hz]")]) for row in rows[-3:]]
    assert weave == pytest.approx(alone["modes"]["weave"]["frequency"])


@pytest.mark.slow
def test_transfer_functions_as_a_table_and_a_figure(capsys, tmp_path):
    printed(
        capsys, "device", "damper:7.5", "--frequency", "1,2", "--csv", tmp_path / "f.csv", "--plot", tmp_path / "f.svg"
    )
    heading, _, second = (tmp_path / "f.csv").read_text().splitlines()
    assert heading == ("frequency [Hz],handlebar_torque real [N.m/rad],handlebar_torque imag [N.m/rad],"
                       "frame_torque real [N.m/rad],frame_torque imag [N.m/rad]")  # fmt: skip
    assert float(second.split(",")[2]) == pytest.approx(-2 * 6.283185307 * 2 / 2 * 7.5)  # -i w d (2011, eq. 14)
    assert "<svg" in (tmp_path / "f.svg").read_text()[:500]


@pytest.mark.slow
def test_runs_as_a_figure(capsys, tmp_path):
    out = printed(
        capsys, "cosimulate", "--duration", "0.1", "--csv", tmp_path / "run.csv", "--plot", tmp_path / "run.pdf"
    )
    assert out.endswith(f"written: {tmp_path / 'run.csv'}\nwritten: {tmp_path / 'run.pdf'}\n")
    printed(
        capsys,
        "simulate",
        "rider:mean_2011",
        "--duration",
        "0.1",
        "--out",
        tmp_path / "one.csv",
        "--plot",
        tmp_path / "one.pdf",
    )
    assert all((tmp_path / name).read_bytes().startswith(b"%PDF") for name in ("run.pdf", "one.pdf"))


def test_linear_systems_are_written_for_matlab(capsys, tmp_path):
    device = ("--device", "rider:mean_2011")
    out = printed(capsys, "modes", *device, "--speed", "20,30", "--matlab", tmp_path / "bike.mat",
                  "--json", tmp_path / "modes.json")  # fmt: skip
    assert [line.split("/")[-1] for line in out.splitlines() if line.startswith("written")] == [
        "bike.mat",
        "modes.json",
    ]
    bike = loadmat(tmp_path / "bike.mat")
    names = {kind: [str(cell[0]) for cell in bike[kind].ravel()] for kind in ("states", "inputs", "outputs")}
    assert bike["speed"].ravel() == pytest.approx([20.0, 30.0]) and "vehicle.steer_rate" in names["states"]
    for letter, rows, columns in zip(
        "ABCD", ("states", "states", "outputs", "outputs"), ("states", "inputs") * 2, strict=True
    ):
        assert bike[letter].shape == (len(names[rows]), len(names[columns]), 2)
    weave = json.loads((tmp_path / "modes.json").read_text())["modes"]["weave"]["eigenvalue"][1]
    expected = complex(*weave)
    assert np.abs(np.linalg.eigvals(bike["A"][:, :, 1]) - expected).min() < 1e-6 * abs(expected)
    printed(capsys, "modes", *device, "--speed", "30", "--matlab", tmp_path / "one.mat")
    assert loadmat(tmp_path / "one.mat")["A"] == pytest.approx(bike["A"][:, :, 1], rel=1e-12)
    assert main(["modes", *device, "--device", "none", "--matlab", str(tmp_path / "two.mat")]) == 2
    assert "give --device once" in capsys.readouterr().err
