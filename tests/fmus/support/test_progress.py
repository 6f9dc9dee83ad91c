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


def test_short_work_is_silent_and_every_item_comes_through(capsys):
    assert list(track(range(5), "counting")) == [0, 1, 2, 3, 4]
    assert capsys.readouterr() == ("", "")


def test_long_work_writes_a_line_now_and_then(capsys, monkeypatch):
    monkeypatch.setattr(progress, "SECONDS", 0.2)
    for _ in track(range(4), "building"):
        time.sleep(0.35)
    shown = capsys.readouterr()
    lines = shown.err.splitlines()
    assert shown.out == "" and 3 <= len(lines) <= 7  # 1.4 s in intervals of at least 0.2 s, on a busy machine
    assert all(re.fullmatch(r"building: (0 of 4 \(0 %\) after 0 s|[1-3] of 4 \(\d+ %\) after [01] s, about [0-4] s left)", line) for line in lines)
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
    assert re.fullmatch(r"single effects after \d s", lines[0])
    counted = [line for line in lines if line.startswith("single effects: fitting: ")]
    assert counted and any(re.search(r": [1-3] of 4 \(\d+ %\) after \d s, about [01] s left$", line) for line in counted)
    assert re.fullmatch(r"single effects after [12] s, ended", lines[-1])


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
