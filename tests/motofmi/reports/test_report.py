"""The page of a report: its first screen, terms, tables, links, provenance; and its behaviour in a browser."""

import hashlib
import re

import numpy as np
import pytest

from motofmi.reports.charts import Axis, Cells, Chart, Choice, Curve, Panel, Shade
from motofmi.reports.glossary import Marker, terms
from motofmi.reports.mode_animation import mode_animation
from motofmi.reports.provenance import Command, command_line
from motofmi.reports.report import Report, Section, Table
from motofmi.reports.shown import Interactive
from motofmi.reports.sketch import motorcycle_sketch
from tests import ROOT
from tests.pages import Page, assert_is_a_report, assert_works_in_a_browser, needs_browser, opened

X = np.linspace(0.5, 12, 40)
WIDE = Table(
    [f"heading {k} [N.m]" for k in range(14)],
    [[str(v + k) for k in range(14)] for v in (3, 1, 2)],
    "a caption",
    ["met", "near", "missed"],
)
CHART = Chart(
    [
        Panel(
            Axis("frequency", "Hz"),
            Axis("torque", "N.m"),
            [Curve("base", X, X, "base", band=(X - 1, X + 1)), Curve("found", X, X**2, "found", "both")],
            shades=[Shade(1, 2, "range")],
        ),
        Panel(
            Axis("frequency", "Hz", log=True),
            Axis("bars", "", names=["one", "two"]),
            [Curve("found", [1, 2], [0, 1], "found", "bars")],
            hover="point",
        ),
        Panel(
            Axis("real part", "1"),
            Axis("imaginary part", "1"),
            [Curve("base", X, -X, "base", "circles"), Curve("found", X, X, "found", "needles")],
            square=True,
            hover="point",
        ),
        Panel(
            Axis("time", "s"),
            Axis("frequency", "Hz"),
            [Curve("found", X, X, "found", "errors", band=(X - 1, X + 1))],
            cells=Cells([0], [6], [0], [6], [3.0], "excess [1]", 1, 10),
            hover="point",
        ),
    ],
    columns=2,
    choices=[Choice("base only", ["base"]), Choice("both", ["base", "found"])],
)


@pytest.fixture(scope="module")
def written(tmp_path_factory):
    folder = tmp_path_factory.mktemp("report")
    (folder / "input.csv").write_text("time [s]\n0\n")
    (folder / "beside it.csv").write_text("")
    weave = mode_animation(
        "weave, 50 m/s", 0.2 + 20j, {"steer": 1, "torso": 0.5j, "roll": -1, "yaw": 0.2, "lateral": 0.1}
    )
    sections = [
        Section(
            "Weave & <wobble>",
            ["The weave is unstable; wobble is not. </script>"],
            [(motorcycle_sketch(), ""), (weave, "Weave."), (CHART, "More.")],
            [WIDE],
        ),
        Section("Details", ["The reduced chi-square."], [(CHART, "Folded.")], [Table(("a",), [])], folded=True),
    ]
    report = Report(
        "A title",
        "The answer about the wobble.",
        sections,
        ["force = 2"],
        [(CHART, "A caption.")],
        "What was asked?",
        ["A warning."],
        [folder / "input.csv"],
        [(folder / "beside it.csv", "rows")],
    )
    with command_line(Command(["motofmi frf", "my file.csv"], [folder / "beside it.csv"])):
        report.write(folder / "report.html")
    return folder / "report.html"


def test_the_first_screen_and_the_provenance(written):
    page = assert_is_a_report(written, inputs=1, command="motofmi frf 'my file.csv'", pictures=3)
    assert hashlib.sha256((written.parent / "input.csv").read_bytes()).hexdigest() in page.text
    assert page.source.count('href="beside%20it.csv"') == 1
    assert "Weave & <wobble>" in page.text  # escaped in the source
    assert page.source.count("<table>") == 1  # the empty one is left out


def test_terms_are_marked_once_in_a_section(written):
    page = Page(written)
    targets = [attributes["popovertarget"] for _, attributes in page.elements if "popovertarget" in attributes]
    assert targets.count("term-wobble") == 2 and targets.count("term-reduced-chi-square") == 1  # lead and section


def test_every_term_of_the_glossary_is_found():
    source = (ROOT / "docs" / "glossary.md").read_text("utf-8").partition("## Words that are avoided")[0]
    rows = [line for line in source.splitlines() if re.match(r"\| (?!term|-)", line)]
    assert len(terms()) >= len(rows) > 60 and "weave" in terms() and "input, output, state" not in terms().values()
    for term in terms():
        assert Marker().marked(f"{term}: it is"), term
        marker = Marker()
        marker.marked(f"{term}: it is")
        assert marker.explained()[0][0] == term


def test_numbers_are_aligned_and_cells_coloured():
    table = Table(("a", "b"), [("1.5", "x"), ("-2e-3", "y")], shades=True)
    assert table.numbers == [True, False] and "rgb" in table.shade("0.5") and not table.shade("x")


def test_a_chart_by_itself(tmp_path):
    shown = Interactive(CHART, "a <title>")
    assert "<iframe" in shown._repr_html_() and "a &lt;title&gt;" in shown._repr_html_() and "torque" in repr(shown)
    page = Page(shown.save(tmp_path / "chart.html"))
    assert len(page.of_class("chart")) == 1 and not [a for _, a in page.elements if "src" in a]


@pytest.mark.slow
@needs_browser
def test_the_page_works_in_a_browser(written, tmp_path):
    assert_works_in_a_browser(written)
    assert_works_in_a_browser(Interactive(CHART).save(tmp_path / "chart.html"))


@pytest.mark.slow
@needs_browser
def test_legend_zoom_tables_terms_and_animation(written):
    with opened(written, 1280) as (page, wrong):
        chart = page.locator(".chart").first
        drawn = "[document.querySelectorAll('.panel path').length, document.querySelector('.panel').innerText]"
        before = page.evaluate(drawn)
        chart.get_by_role("button", name="base", exact=True).click()
        assert chart.get_by_role("button", name="base", exact=True).get_attribute("aria-pressed") == "false"
        assert page.evaluate(drawn) != before
        chart.get_by_role("button", name="both").click()
        assert (
            page.evaluate(drawn) == before
            and chart.get_by_role("button", name="both").get_attribute("aria-pressed") == "true"
        )
        chart.get_by_role("button", name="+").click()
        assert page.evaluate(drawn) != before
        chart.get_by_role("button", name="reset").click()
        assert page.evaluate(drawn) == before
        chart.locator(".panel").first.hover()
        assert "N.m" in chart.inner_text() and "frequency [Hz]" in chart.inner_text()
        first = page.locator("tbody tr td:first-child")
        page.get_by_role("button", name="sort by heading 0").click()
        assert first.all_inner_texts() == ["1", "2", "3"]
        page.get_by_role("button", name="sort by heading 0").click()
        assert first.all_inner_texts() == ["3", "2", "1"]
        page.locator(".lead .term").first.click()
        assert page.locator("#term-wobble").is_visible()
        page.locator(".animation").scroll_into_view_if_needed()
        turned = "document.querySelector('.animation .yaw').getAttribute('transform')"
        start = page.evaluate(turned)
        page.wait_for_function(f"{turned} !== {start!r}")
        page.get_by_role("button", name="pause").click()
        assert wrong == []
    with opened(written, 390) as (page, _):
        assert page.locator(".scrolls .hint").first.is_visible()  # says that the table scrolls
