"""Co-simulations of FMUs: names of modes, inputs from a file, interrupted runs, memory."""

import json
import subprocess
import sys
import time
import tracemalloc

import numpy as np
import pytest

from fmus.cosimulation.cosimulate import cosimulate
from fmus.cosimulation.network import Network
from fmus.cosimulation.profiles import Profile, read_profile
from fmus.cosimulation.ssp.converter import Converter
from fmus.cosimulation.ssp.units import IDENTITY
from fmus.cosimulation.subsystems.fmu_subsystem import FmuSubsystem
from fmus.export.build import build
from fmus.support.errors import InputError
from motofmi.cli.main import main
from motofmi.workflows.ridden_fmus import errors_by_mode, mode_names, ridden_fmus
from tests.coupled import MOTORCYCLE, RIDER
from tests.fmus.cosimulation.test_cosimulation import exact_motion
from vehicle_fmu import ridden

SPEED, START = 30.0, 0.5


@pytest.mark.slow
def test_mode_errors_carry_the_modes_names():
    subsystems = ridden_fmus(MOTORCYCLE, RIDER, speed=SPEED)
    found = cosimulate(subsystems, 1e-3, 0.01, "jacobi")
    named = errors_by_mode(mode_names(subsystems), found.predicted)
    assert set(named) == {"weave", "wobble", "rider_wobble"}
    assert named["weave"]["frequency"] < named["rider_wobble"]["frequency"] < named["wobble"]["frequency"]


@pytest.mark.slow
def test_modes_of_a_nonlinear_device_have_names_where_it_starts(tmp_path):
    result = tmp_path / "run.json"
    words = [
        "--device",
        "damper:progressive",
        "--step",
        "0.01",
        "--duration",
        "0.1",
        "--initial",
        "steer_rate=2",
        "--speed",
        "20",
    ]
    assert main(["cosimulate", *words, "--out", str(tmp_path / "run.csv"), "--json", str(result)]) == 0
    assert set(json.loads(result.read_text())["predicted"]) == {"weave", "wobble"}


def test_inputs_from_a_file_are_converted_and_checked(tmp_path):
    file = tmp_path / "in.csv"
    file.write_text("\ufefftime [s],speed [km/h]\n0,72\n2,36\n", "utf-8")  # with the byte order mark of a spreadsheet
    times, columns, units = read_profile(file)
    assert times.tolist() == [0, 2] and columns["speed"].tolist() == [72, 36] and units == {"speed": "km/h"}
    converter = Converter(IDENTITY, ("m/s", "m/s"))
    network = Network({"vehicle": converter}, {})
    assert Profile.over_time(network, times, {"given": columns["speed"]}, {"given": "km/h"}).at(
        np.ones(1)
    ) == pytest.approx(15.0)
    with pytest.raises(InputError, match=r"the column given of the inputs: unit \[kg\] cannot be converted to \[m/s\]"):
        Profile.over_time(network, times, {"given": columns["speed"]}, {"given": "kg"})
    file.write_text("t,speed\n0,1\n")
    with pytest.raises(InputError, match="unknown column 'time'"):
        read_profile(file)
    file.write_text("time,speed\n0,fast\n")
    with pytest.raises(InputError, match="every row needs 2 numbers"):
        read_profile(file)


@pytest.mark.slow
def test_a_killed_run_leaves_what_was_flushed(tmp_path):
    out = tmp_path / "run.csv"
    process = subprocess.Popen([sys.executable, "-m", "motofmi", "cosimulate", "--duration", "100000", "--initial", "steer_rate=0.5",
                                "--coupling", "jacobi", "--speed", "20", "--out", str(out)], stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)  # fmt: skip
    try:
        began = time.monotonic()
        while time.monotonic() - began < 60 and (not out.exists() or out.stat().st_size < 200_000):
            time.sleep(0.05)
    finally:
        process.kill()
        process.wait()
    header, *rows = out.read_text().splitlines()
    whole = np.array([[float(x) for x in row.split(",")] for row in rows[:-1]])
    assert len(whole) >= 500 and whole.shape[1] == len(header.split(","))
    assert whole[:, 0] == pytest.approx(1e-3 * np.arange(len(whole)))


@pytest.mark.slow
def test_modes_of_fmus_are_those_of_their_components(tmp_path):
    rider = build(RIDER, tmp_path).path
    found = []
    for name, words in (("fmu", ["--fmu", str(rider)]), ("component", ["--device", "rider:mean_2011"])):
        result = tmp_path / f"{name}.json"
        assert main(["modes", *words, "--speed", "20,40", "--json", str(result)]) == 0
        found.append(json.loads(result.read_text()))
    for mode, values in found[1]["modes"].items():
        for ours, exact in zip(found[0]["modes"][mode]["eigenvalue"], values["eigenvalue"], strict=True):
            assert ours == exact or ours == pytest.approx(exact, rel=1e-9)


@pytest.mark.slow
def test_a_system_in_one_fmu_has_no_coupling_error(tmp_path):
    one = FmuSubsystem(
        build(ridden(MOTORCYCLE, RIDER), tmp_path).path, "ridden", {"vehicle.speed": SPEED, "vehicle.steer_rate": START}
    )
    found = cosimulate({"ridden": one}, 1e-2, 0.5)
    exact = exact_motion(found["time"])
    assert found["ridden.vehicle.steer_angle"] == pytest.approx(exact, abs=1e-9 * np.abs(exact).max())
    one.close()


@pytest.mark.slow
def test_memory_does_not_grow_with_the_duration(tmp_path):
    peaks = []
    for duration in (10.0, 30.0):
        subsystems = ridden_fmus(MOTORCYCLE, RIDER, {"steer_rate": START}, SPEED)
        tracemalloc.start()
        cosimulate(subsystems, 1e-3, duration, "jacobi", out=tmp_path / "run.csv")
        peaks.append(tracemalloc.get_traced_memory()[1])
        tracemalloc.stop()
        for subsystem in subsystems.values():
            subsystem.close()
    assert peaks[1] < 1.1 * peaks[0]  # rows of 10 s are 1.2 MB as numbers, more as text
