"""Progress in a log: nothing for short work, a line now and then for long work, nothing on standard output."""

import gc
import re
import time

import pytest

from fmus.support import progress
from fmus.support.deadline import deadline, time_is_up
from fmus.support.progress import track


@pytest.fixture(autouse=True)
def no_display_is_open():
    """Items whose loop ended with an error keep the display until the garbage collector finds their generator."""
    gc.collect()


def read_line(begin, line):
    """The number of finished items of four, the seconds that passed and those that are left, if they are known."""
    found = re.fullmatch(re.escape(begin) + r"(\d) of 4 \(\d+ %\) after (\d+) s(?:, about (\d+) s left)?", line)
    assert found, line
    return int(found[1]), int(found[2]), None if found[3] is None else int(found[3])


def test_short_work_is_silent_and_every_item_comes_through(capsys):
    assert list(track(range(5), "counting")) == [0, 1, 2, 3, 4]
    assert capsys.readouterr() == ("", "")


def test_long_work_writes_a_line_now_and_then(capsys, monkeypatch):
    monkeypatch.setattr(progress, "SECONDS", 0.2)
    began = time.monotonic()
    for _ in track(range(4), "building"):
        time.sleep(0.35)
    took = time.monotonic() - began
    shown = capsys.readouterr()
    lines = shown.err.splitlines()
    assert shown.out == "" and 1 <= len(lines) <= took / 0.2
    for line in lines:
        of_all, after, left = read_line("building: ", line)
        assert after <= took + 0.5  # a whole number of seconds
        assert left == pytest.approx(4 * after / of_all - after, abs=0.501 * 4 / of_all) if of_all else left is None
    time.sleep(0.5)
    assert capsys.readouterr().err == ""  # the end of the work ends the lines


def test_one_long_item_without_a_total_shows_too(capsys, monkeypatch):
    monkeypatch.setattr(progress, "SECONDS", 0.1)
    for _ in track((time.sleep(0.35) for _ in range(1)), "solving"):
        pass
    assert capsys.readouterr().err.startswith("solving: 0 after 0 s\n")


def test_items_of_a_stage_are_shown_under_its_name(capsys, monkeypatch):
    monkeypatch.setattr(progress, "SECONDS", 0.2)
    with progress.stage("single effects"):
        time.sleep(0.3)
        for _ in track(range(4), "fitting"):
            time.sleep(0.3)
    lines = capsys.readouterr().err.splitlines()
    assert re.fullmatch(r"single effects after \d+ s", lines[0])
    counted = [line for line in lines if line.startswith("single effects: fitting: ")]
    assert counted and any(read_line("single effects: fitting: ", line)[2] is not None for line in counted)
    assert re.fullmatch(r"single effects after \d+ s, ended", lines[-1])


def test_a_sentence_is_written_at_once_under_the_name_of_the_stage(capsys):
    progress.say("nothing runs")
    with progress.stage("gap"):
        progress.say("25000 samples may take minutes.")
        assert capsys.readouterr().err == "gap: 25000 samples may take minutes.\n"


def test_no_more_time_is_left_than_a_deadline_leaves(capsys, monkeypatch):
    monkeypatch.setattr(progress, "SECONDS", 0.3)
    with deadline(1.2):
        for _ in track(range(100), "fitting"):  # 20 s in all
            time.sleep(0.2)
            if time_is_up():
                break
    left = [int(found[1]) for found in re.finditer(r"about (\d+) s left", capsys.readouterr().err)]
    assert left and max(left) <= 1
