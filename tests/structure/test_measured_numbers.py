"""Measured numbers of README and docs come from the results of the benchmarks: typed ones are found."""

import ast
import inspect
import json
import re
from pathlib import Path

import pytest

from benchmarks.__main__ import RESULTS
from benchmarks._pages import DOCS, rendered
from motofmi.scenarios import does_the_passive_rider_calm_wobble_on_every_vehicle as on_every_vehicle
from tests import ROOT

# Records of past decisions keep the numbers that decided; pages of components and the glossary hold no measurements.
KEPT = {"decisions", "components", "rendered", "gallery"}
PAGES = [
    ROOT / "README.md",
    ROOT / "paper" / "paper.md",
    *(path for path in sorted((ROOT / "docs").rglob("*.md")) if not KEPT & set(path.parts)),
]
CODE = re.compile(r"^```.*?^```|`[^`\n]*`", re.MULTILINE | re.DOTALL)
# A number or a table between these marks is rendered from the results (`benchmarks/_pages.py`).
NUMBER = re.compile(r"<!-- measured .*? -->.*?<!-- end -->")
RENDERED = re.compile(r"<!-- table of .*?<!-- end of the table -->", re.DOTALL)
LINK = re.compile(r"\]\([^)]*\)")
# What only a measurement gives: rates of cases, speeds and costs.
MEASURED = re.compile(
    r"\b\d{1,3} of \d{2,3}\b|\b\d+(?:\.\d+)? ?% \[\d+, \d+\]|\b[\d.,]+ (?:MB/s|steps/s|CPU s|times (?:faster|slower|as fast)|(?:m?s|seconds) of processor time)\b"
)


def _prose(page: Path) -> str:
    return CODE.sub("", RENDERED.sub("", page.read_text("utf-8")))


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.relative_to(ROOT).as_posix())
def test_no_measured_number_is_typed(page):
    assert MEASURED.findall(NUMBER.sub("", _prose(page))) == []


# What a measurement may give: percentages, errors, powers of ten, decimals, times, ratios. Others are counts and
# settings.
MAYBE = re.compile(
    r"\+- ?\d[\d.e-]*|(?<![\w.])[+-]?\d[\d,]*(?:\.\d+)?(?: to \d[\d.]*)? ?%|(?<![\w.,])[+-]?\d+(?:\.\d+)?e[+-]?\d+"
    r"|(?<![\w.])[+-]?\d+\.\d+(?!\.?\d|\w)|\b\d[\d.,]* (?:times|ms|MB|kB|s|minutes?|seconds?)\b"
    r"|\b\d[\d,]* of (?:the )?\d[\d,]*"
)
MATH = re.compile(r"\$\$.*?\$\$|\$[^$\n]+\$", re.DOTALL)
INDENTED = re.compile(r"^    .*\n", re.MULTILINE)
VERSIONS = re.compile(
    r"\b(?:FMI|SSP|Python|[Vv]ersions?|Sect\.|CoFMPy|fmpy|pythonfmu|Plot|Python) \d+\.\d+(?:\.\d+)?(?: (?:and|or) (?:pythonfmu )?\d+\.\d+(?:\.\d+)?)?"
)
SECTIONS_OF_STANDARDS = {"check.md"}  # pages whose tables hold section numbers
# Numbers of pages that no measurement gives, and why.
GIVEN = {
    "check.md": {"60 s", "15 %", "1 %", "1e-4"},  # limits of a trial, change of a parameter, tolerance of a restored state
    "couplings.md": {"1 ms"},  # the step
    "explore.md": {"2 MB", "150 ms", "1 ms", "0.8", "1e-6", "1e-9", "99.9 %", "50 ms", "100 times", "0.01 %"},  # settings, targets
    "full_rider.md": {"1e-9", "1e-8"},  # tolerances of tests
    "gap.md": {
        *("0.1 %", "1 %", "4 %", "5 %", "85 %", "95 %", "2 %", "0.5 %", "3 %"),  # criteria, levels, prior errors, widths
        "0.4 %",  # 2^-8, of the sign test
        "0.01 %",  # narrowest transition of dry friction
        *("0.125", "0.05", "15 s", "10 s", "0.01"),  # inertia of a bar, errors of data, parts of runs, factors of a search
        *("10 %", "0.4"),  # what is a step response
        *("0.3", "8 times"),  # the range of starting values of a frequency
    },
    "glossary.md": {"0.5", "63 %", "95 %"},  # definitions
    "hosts.md": {"0.6", "1 ms", "0.5", "0.01", "0.2", "1.5", "1e-4", "1e-3"},  # settings of the hosts
    "identification.md": {"1 %", "0.4", "1.25", "4 s", "0.25", "1e-6"},  # limits, the simulated noise, a test's tolerance
    "magnetorheological_damper.md": {"0.5"},  # settings of the recordings
    "read_a_verdict.md": {"95 %", "0.01"},  # the level, the errors of the example
    "recordings.md": {"5 %"},  # the limit within which sampling intervals are the same
    "steer_by_wire_bicycle.md": {"4.7", "2.6", "0.3", "10 s", "80 %", "10 %", "9.3"},  # the recordings, criteria, the given matrix
    "sweep.md": {"0.1", "5 s", "1 ms"},  # rounding of speeds, settings of the runs
    "test_rig.md": {"0.3"},  # what the page's own simulation hides
    "vehicles.md": {"1e-11", "1e-9"},  # tolerances of tests
    "webassembly.md": {"1e-12"},  # a tolerance of a test
}
RENDERED_PAGES = {"vehicles.md": on_every_vehicle}  # from a scenario: the numbers in its own text count


def _text(page: Path) -> str:
    """What an author typed: of a page that a scenario renders, the text of the scenario."""
    module = RENDERED_PAGES.get(page.name)
    if module is None:
        return page.read_text("utf-8")
    (function,) = (
        node
        for node in ast.walk(ast.parse(inspect.getsource(module)))
        if isinstance(node, ast.FunctionDef) and node.name == "page"
    )
    return "".join(
        part.value for part in ast.walk(function) if isinstance(part, ast.Constant) and isinstance(part.value, str)
    )


def typed_numbers(text: str, sections_in_tables: bool = False) -> set[str]:
    """The numbers in the prose and the tables of a page that a measurement may give."""
    for left_out in (RENDERED, CODE, NUMBER, MATH, LINK, INDENTED, VERSIONS):
        text = left_out.sub("", text)
    if sections_in_tables:
        text = re.sub(r"^\|.*$", "", text, flags=re.MULTILINE)
    return {found.strip().rstrip(".,") for found in MAYBE.findall(text)}


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.relative_to(ROOT).as_posix())
def test_numbers_that_may_be_measured_are_rendered_or_known_to_be_given(page):
    """A new number is rendered from the results; one that is a setting or a definition is entered in GIVEN."""
    found = typed_numbers(_text(page), page.name in SECTIONS_OF_STANDARDS)
    assert found == GIVEN.get(page.name, set())


def test_typed_measurements_of_every_kind_are_found():
    text = (
        "It closes 93 % [90, 95], 0.303 +- 0.004 N.m, within 5e-5, 225 times real time, 32 ms, 28 to 33 % too low, 1 of 600 runs, "
        "1.93 to 1.75; FMI 2.0, `0.5` and <!-- measured a.b | .2f -->0.25<!-- end --> are none.\n| row | -12.03 | 470 N |\n"
    )
    assert typed_numbers(text) == {
        *("93 %", "0.303", "+- 0.004", "5e-5", "225 times", "32 ms", "28 to 33 %", "1 of 600", "1.93", "1.75", "-12.03"),
    }


def test_a_typed_rate_is_found():
    assert MEASURED.findall("named in 57 of 66 cases, 86 % [76, 93], at 36 MB/s") == [
        "57 of 66",
        "86 % [76, 93]",
        "36 MB/s",
    ]


def test_the_numbers_and_tables_of_the_pages_are_those_of_the_results():
    results = json.loads(RESULTS.read_text("utf-8"))
    pages = [path for path in PAGES if DOCS in path.parents]
    texts = "".join(path.read_text("utf-8") for path in pages)
    assert texts.count("<!-- table of") >= 4 and len(NUMBER.findall(texts)) == texts.count("<!-- measured ") > 200
    for path in pages:
        page = path.read_text("utf-8")
        assert page.count("<!-- table of benchmarks.") == page.count("<!-- end of the table -->")
        assert rendered(page, results) == page, "run python -m benchmarks --render"
    recordings = results["gap_recordings"]
    fewer = {**recordings, "recordings": dict(list(recordings["recordings"].items())[1:])}
    page = (DOCS / "gap.md").read_text("utf-8")
    assert rendered(page, {**results, "gap_recordings": fewer}) != page


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.relative_to(ROOT).as_posix())
def test_no_line_begins_with_a_mark(page):
    """Markdown takes a line that begins with a comment for a block of HTML, which ends the paragraph."""
    assert re.findall(r"^[ *-]*<!-- measured .*", page.read_text("utf-8"), re.MULTILINE) == []


@pytest.mark.parametrize(
    "mark, shown",
    [("a.rate | .1f | 100", "12.5"), ("a.list.1", "2"), ("a.rate; .0e", "1e-01"), ("a/key.with.dot | .2f", "3.00")],
)
def test_a_mark_gives_path_format_and_factor(mark, shown):
    results = {"a": {"rate": 0.125, "list": [1, 2], "key.with.dot": 3}}
    page = f"before <!-- measured {mark} -->old<!-- end --> after"
    assert rendered(page, results) == f"before <!-- measured {mark} -->{shown}<!-- end --> after"


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
