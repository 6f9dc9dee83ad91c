"""`cosimulate --sandbox` gives the numbers of the plain run, the errors of the command, and survives FMUs that crash."""

import json
import os
import subprocess
import sys
import time
from pathlib import Path

import psutil
import pytest

from fmus.export.build import build
from motofmi.cli.main import main
from rider_fmu import riders
from tests import ROOT
from tests.fmus.checks import bench

pytestmark = [pytest.mark.slow, pytest.mark.skipif(os.name == "nt", reason="crashes with signals")]


def test_numbers_and_files_are_those_of_the_plain_run(tmp_path, capsys):
    fmu = str(build(riders.load("mean_2011"), tmp_path).path)
    found = {}
    for name, words in (("plain", []), ("sandboxed", ["--sandbox"])):
        out = tmp_path / f"{name}.csv"
        assert main(["cosimulate", "--fmu", fmu, "--duration", "0.2", "--initial", "steer_rate=0.5", "--out", str(out),
                     "--json", str(tmp_path / f"{name}.json"), *words]) == 0  # fmt: skip
        found[name] = json.loads((tmp_path / f"{name}.json").read_text("utf-8"))
        assert f"written: {out}" in capsys.readouterr().out
    for result in found.values():
        del result["steps_per_second"], result["file"]
    assert found["plain"] == found["sandboxed"]
    assert (tmp_path / "plain.csv").read_bytes() == (tmp_path / "sandboxed.csv").read_bytes()


def test_errors_of_the_command_are_reported(tmp_path, capsys):
    missing = str(tmp_path / "missing.fmu")
    assert main(["cosimulate", "--fmu", missing, "--sandbox"]) == 2
    assert "cannot read" in capsys.readouterr().err


def archive(folder, call):
    """The path of an FMU of a damper that makes a call of C when its library is loaded."""
    library = bench.compiled("fmu2.c", folder / "bench.so", f"-DCONSTRUCTOR={call}")
    names = ("steer_angle", "steer_rate", "frame_rate")
    rows = "".join(f'<ScalarVariable name="{n}" valueReference="{i}" causality="input"><Real unit="{u}" start="0" /></ScalarVariable>'
                   for i, (n, u) in enumerate(zip(names, ("rad", "rad/s", "rad/s"), strict=True)))  # fmt: skip
    rows += "".join(f'<ScalarVariable name="{n}" valueReference="{3 + i}" causality="output"><Real unit="N.m" /></ScalarVariable>'
                    for i, n in enumerate(("handlebar_torque", "frame_torque")))  # fmt: skip
    xml = (f'<fmiModelDescription fmiVersion="2.0" modelName="m" guid="{{bench}}"><CoSimulation modelIdentifier="bench" />'
           '<UnitDefinitions><Unit name="rad"><BaseUnit rad="1" /></Unit><Unit name="rad/s"><BaseUnit rad="1" s="-1" /></Unit>'
           '<Unit name="N.m"><BaseUnit kg="1" m="2" s="-2" /></Unit></UnitDefinitions>'
           f'<ModelVariables>{rows}</ModelVariables><ModelStructure><Outputs><Unknown index="4" /><Unknown index="5" /></Outputs>'
           '<InitialUnknowns><Unknown index="4" /><Unknown index="5" /></InitialUnknowns></ModelStructure></fmiModelDescription>')  # fmt: skip
    return bench.written(folder / "faulty.fmu", xml, library)


def test_a_crash_ends_the_sandboxed_process_only(tmp_path, capsys):
    path = archive(tmp_path, "crash()")
    status = main(["cosimulate", "--fmu", str(path), "--duration", "0.1", "--out", str(tmp_path / "run.csv"), "--sandbox"])
    assert status == 1 and "crashed with signal 11 (SIGSEGV)" in capsys.readouterr().err
    assert not (tmp_path / "run.csv").exists()


ADVICE = {"cosimulate": "run it with --sandbox", "simulate": "it cannot be used; motofmi check shows the call"}


@pytest.mark.skipif(sys.platform not in ("linux", "darwin"), reason="handlers of the C library")
@pytest.mark.parametrize("command", ADVICE)
def test_an_fmu_that_ends_the_process_without_a_sandbox_is_reported(command, tmp_path):
    path = archive(tmp_path, "exit(0)")
    words = [command, *(["--fmu"] if command == "cosimulate" else []), str(path), "--out", str(tmp_path / "run.csv")]
    done = subprocess.run([sys.executable, "-m", "motofmi", *words], capture_output=True, text=True, cwd=ROOT)
    said = f"motofmi {command}: {path} ended the process of motofmi: {ADVICE[command]}\n"
    assert (done.returncode, done.stdout, done.stderr) == (1, "", said)


@pytest.mark.skipif(sys.platform != "linux", reason="a thread does not run while a library is being loaded")
def test_the_sandboxed_process_ends_with_the_command(tmp_path):
    path = archive(tmp_path, "hang()")
    words = [sys.executable, "-m", "motofmi", "cosimulate", "--fmu", str(path), "--sandbox"]
    with subprocess.Popen(words, cwd=ROOT) as command:
        began, found = time.monotonic(), []
        while not any(map(has_loaded_bench, found)) and time.monotonic() - began < 60:
            time.sleep(0.1)
            found = psutil.Process(command.pid).children()
        command.terminate()
    _, alive = psutil.wait_procs(found, timeout=15)
    for child in alive:
        child.kill()
    assert found and not alive


def has_loaded_bench(process):
    return any(Path(found.path).name == "bench.so" for found in process.memory_maps())
