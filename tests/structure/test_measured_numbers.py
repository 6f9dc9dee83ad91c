"""Measured numbers of README and docs come from the results of the benchmarks: typed ones are found."""

import json
import re
from pathlib import Path

import pytest

from benchmarks.__main__ import RESULTS
from tests import ROOT

# Records of past decisions keep the numbers that decided; pages of components and the glossary hold no measurements.
KEPT = {"decisions", "components", "rendered", "gallery"}
PAGES = [
    ROOT / "README.md",
    ROOT / "paper" / "paper.md",
    *(path for path in sorted((ROOT / "docs").rglob("*.md")) if not KEPT & set(path.parts)),
]
CODE = re.compile(r"^```.*?^```|(?<!\{measured\})`[^`\n]*`", re.MULTILINE | re.DOTALL)
# A table between these lines is rendered by its benchmark, whose test compares it with the results.
RENDERED = re.compile(r"<!-- table of .*?<!-- end of the table -->", re.DOTALL)
ROLE = re.compile(r"\{measured\}`([^`]+)`")
# What only a measurement gives: rates of cases, speeds and costs.
MEASURED = re.compile(
    r"\b\d{1,3} of \d{2,3}\b|\b\d+(?:\.\d+)? ?% \[\d+, \d+\]|\b[\d.,]+ (?:MB/s|steps/s|CPU s|times (?:faster|slower|as fast)|(?:m?s|seconds) of processor time)\b"
)


def _prose(page: Path) -> str:
    return CODE.sub("", RENDERED.sub("", page.read_text("utf-8")))


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.relative_to(ROOT).as_posix())
def test_no_measured_number_is_typed(page):
    assert MEASURED.findall(ROLE.sub("", _prose(page))) == []


# Pages of which every number with an error, as a percentage or in the unit of a result is a measured one.
ALL_MEASURED = {"magnetorheological_damper.md": re.compile(r"\+- ?\d|\d ?%|\d N\b|\d mm/s|\d ms\b")}


@pytest.mark.parametrize("name", ALL_MEASURED)
def test_no_result_is_typed(name):
    assert ALL_MEASURED[name].findall(ROLE.sub("", _prose(ROOT / "docs" / name))) == []


@pytest.mark.slow
def test_every_measured_role_names_a_number_that_was_measured(monkeypatch):
    monkeypatch.syspath_prepend(str(ROOT / "docs"))
    from extension.measured import shown  # noqa: PLC0415 - a module of the documentation

    roles = [role for page in PAGES for role in ROLE.findall(page.read_text("utf-8"))]
    assert len(roles) >= 5
    for role in roles:
        float(shown(role))


def test_a_typed_rate_is_found():
    assert MEASURED.findall("named in 57 of 66 cases, 86 % [76, 93], at 36 MB/s") == [
        "57 of 66",
        "86 % [76, 93]",
        "36 MB/s",
    ]


@pytest.mark.slow
def test_the_rates_of_the_page_of_accuracy_are_in_the_results(monkeypatch):
    monkeypatch.syspath_prepend(str(ROOT / "docs"))
    from extension.accuracy import STUDIES, accuracy  # noqa: PLC0415 - a module of the documentation

    page, kept = accuracy(), json.loads(RESULTS.read_text("utf-8"))
    assert set(STUDIES) <= set(kept)
    rate = kept["gap_blind"]["rates"]["false alarms"]
    assert f"{round(rate['rate'] * rate['trials'])} of {rate['trials']} | {100 * rate['rate']:.0f} % [" in page


@pytest.mark.slow
def test_the_tables_of_the_paper_are_rendered_from_the_results(monkeypatch):
    monkeypatch.syspath_prepend(str(ROOT / "docs"))
    from extension.accuracy import coupling_comparison, method_comparison  # noqa: PLC0415 - a module of the documentation

    paper = (ROOT / "paper" / "paper.md").read_text("utf-8")
    assert coupling_comparison() in paper and method_comparison() in paper
