"""How commands end: with the names of the files that they wrote, when interrupted, and when nobody reads on."""

import os
import re
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

from motofmi.cli.main import main
from tests import ROOT

PATIENCE = 60.0  # s
# A shell that runs tests in the background has them ignore interrupts, and their children with them.
PROGRAM = "import signal; signal.signal(signal.SIGINT, signal.default_int_handler); from motofmi.__main__ import main; raise SystemExit(main())"

# An import of scipy that lasts until it is interrupted, and a file that says when it began.
LOADING = """
import pathlib, sys, time
class Slow:
    def find_spec(name, path=None, target=None):
        if name == "scipy":
            pathlib.Path({reached!r}).touch()
            time.sleep(60)
sys.meta_path.insert(0, Slow)
"""


def started(*arguments, program=PROGRAM, **options):
    options = {"stdout": subprocess.PIPE, "stderr": subprocess.PIPE, "text": True, **options}
    return subprocess.Popen(
        [sys.executable, "-c", program, *map(str, arguments)], cwd=ROOT, start_new_session=True, **options
    )


def interrupted(process, when):
    """Status, standard output and standard error after Ctrl-C in a terminal, which reaches the whole group of
    processes."""
    began = time.monotonic()
    while not when() and process.poll() is None:
        assert time.monotonic() - began < PATIENCE
        time.sleep(0.02)
    os.killpg(process.pid, signal.SIGINT)
    out, err = process.communicate(timeout=PATIENCE)
    return process.returncode, out, err


@pytest.mark.slow
@pytest.mark.skipif(not hasattr(os, "killpg"), reason="groups of processes")
def test_an_interrupted_simulation_says_that_its_rows_are_written(tmp_path):
    rows = tmp_path / "run.csv"
    process = started("cosimulate", "--speed", "30", "--duration", "100000", "--out", rows)
    status, out, err = interrupted(process, lambda: rows.exists() and rows.stat().st_size > 10000)
    assert (status, out) == (130, "")
    assert err == f"motofmi cosimulate: interrupted; written: {rows}\n"


@pytest.mark.slow
@pytest.mark.skipif(not hasattr(os, "killpg"), reason="groups of processes")
def test_an_interrupted_tour_ends_in_one_line(tmp_path):
    process = started("tour", "--out", tmp_path / "tour")
    # "*.fmu" would find the temporary file that an archive is written to, which is hidden and not yet one of the results.
    status, out, err = interrupted(process, lambda: list(tmp_path.glob("tour/[!.]*.fmu")))
    assert (status, out) == (130, "")
    *progress, last = err.splitlines()
    lines = re.compile(r"tour(: (\d of 6 \(\d+ %\)|\w[\w ]*: .*))? after \d+ s(, about \d+ s left|, ended)?")
    assert [line for line in progress if not lines.fullmatch(line)] == []  # now and then, on a slow machine
    assert last.startswith("motofmi tour: interrupted; written: ") and ".fmu" in last


@pytest.mark.slow
@pytest.mark.skipif(not hasattr(os, "killpg"), reason="groups of processes")
def test_an_interrupt_while_the_libraries_are_loaded_ends_in_one_line(tmp_path):
    reached = tmp_path / "reached"
    process = started("modes", program=LOADING.format(reached=str(reached)) + PROGRAM)
    status, out, err = interrupted(process, reached.exists)
    assert (status, out) == (130, "")
    assert err in ("motofmi: interrupted; written: nothing\n", "motofmi modes: interrupted; written: nothing\n")


@pytest.mark.slow
@pytest.mark.skipif(os.name != "posix", reason="signals of pipes")
@pytest.mark.parametrize("arguments", [("modes", "--json", "-"), ("modes",), ("list",), ("help",)])
def test_a_reader_that_stops_ends_the_command_quietly(arguments):
    reading, writing = os.pipe()
    process = started(*arguments, stdout=writing)
    os.close(writing)
    os.close(reading)  # as `| head` does once it has seen enough
    assert process.communicate(timeout=PATIENCE)[1] == ""
    assert process.returncode == 141  # 128 + SIGPIPE, as other programs end


FULL = Path("/dev/full")


@pytest.mark.slow
@pytest.mark.skipif(not FULL.exists(), reason="a device that is full")
@pytest.mark.parametrize(
    ("arguments", "program"),
    [(("modes",), "motofmi modes"), (("modes", "--json", "-"), "motofmi modes"), (("help",), "motofmi")],
)
def test_an_output_that_is_full_is_named(arguments, program):
    with FULL.open("w") as full:
        process = started(*arguments, stdout=full)
        err = process.communicate(timeout=PATIENCE)[1]
    assert (process.returncode, err) == (2, f"{program}: standard output: No space left on device\n")


@pytest.mark.slow
def test_characters_that_the_output_cannot_encode_are_replaced(tmp_path):
    ascii_only = {**os.environ, "PYTHONIOENCODING": "ascii"}
    process = started("modes", "--speed", "5", "--csv", tmp_path / "\xfc.csv", env=ascii_only)
    out, err = process.communicate(timeout=PATIENCE)
    assert (process.returncode, err) == (0, "")
    assert out.endswith("\\xfc.csv\n")


def lines_of(capsys):
    return [line for line in capsys.readouterr().out.splitlines() if line.startswith("written: ")]


@pytest.mark.study
def test_every_file_is_named_at_the_end(tmp_path, capsys, monkeypatch):
    monkeypatch.chdir(tmp_path)
    assert main(["cosimulate", "--duration", "0.1", "--json", "run.json"]) == 0
    assert lines_of(capsys) == [
        "written: cosimulation.csv",
        "written: run.json",
    ]  # and none of the cache or of a temporary folder
    assert main(["build", "damper:7.5", "rider:mean_2011", "--out", "fmus"]) == 0
    assert lines_of(capsys) == ["written: fmus/damper_7_5.fmu", "written: fmus/rider_mean_2011.fmu"]
    assert main(["identify", "--population", "20", "--out", "riders"]) == 0
    assert lines_of(capsys) == ["written: 20 files in riders"]
    assert main(["gap", "--plan", "--duration", "20", "--sweep", "1:4", "--out", "plan"]) == 0
    assert lines_of(capsys) == ["written: plan/plan.json", "written: plan/plan.png"]
    assert main(["build", "damper:7.5", "--json", "-"]) == 0
    assert lines_of(capsys) == []
