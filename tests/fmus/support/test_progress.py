"""Progress in a log: nothing for short work, a line now and then for long work, nothing on standard output."""

import re
import time

from fmus.support import progress
from fmus.support.progress import track


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
    assert all(re.fullmatch(r"building: [0-3] of 4 \(\d+ %\) after [01] s", line) for line in lines)
    time.sleep(0.5)
    assert capsys.readouterr().err == ""  # the end of the work ends the lines


def test_one_long_item_without_a_total_shows_too(capsys, monkeypatch):
    monkeypatch.setattr(progress, "SECONDS", 0.1)
    for _ in track((time.sleep(0.35) for _ in range(1)), "solving"):
        pass
    assert capsys.readouterr().err.startswith("solving: 0 after 0 s\n")
