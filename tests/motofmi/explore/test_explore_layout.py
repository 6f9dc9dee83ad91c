"""The layout of the explore page: wide and narrow, light, dark and printed, and with a screen reader."""

import pytest

from tests.accessibility import needs_axe, violations
from tests.explore_page import Opened, in_browser


@in_browser
@pytest.mark.parametrize("width", [1280, 390])
@pytest.mark.parametrize("view", ["locus", "speed"])
def test_nothing_is_cut_or_wider_than_the_window(browser, written, width, view):
    opened = Opened(browser, written.path, f"#view={view}", width)
    wide = opened.window.evaluate(
        """() => [...document.querySelectorAll('main *')].filter(e => !e.closest('svg') && e.getBoundingClientRect().right > innerWidth + 1)
                 .map(e => e.tagName + '#' + e.id + '.' + e.className)"""
    )
    assert wide == [] and opened.window.evaluate("document.documentElement.scrollWidth <= innerWidth")
    cut = opened.window.evaluate(
        "[...document.querySelectorAll('.table')].filter(t => t.scrollWidth > t.clientWidth + 1).length"
    )
    assert cut == 0 and opened.complaints == []
    opened.window.close()


@in_browser
def test_dark_and_light_follow_the_system(browser, written):
    papers = set()
    for scheme in ("light", "dark"):
        opened = Opened(browser, written.path, color_scheme=scheme)
        papers.add(opened.window.evaluate("getComputedStyle(document.body).backgroundColor"))
        opened.window.emulate_media(media="print")  # of a dark page, too, on white paper
        assert opened.window.evaluate("getComputedStyle(document.body).backgroundColor") == "rgb(255, 255, 255)"
        opened.window.close()
    assert len(papers) == 2


@in_browser
@needs_axe
@pytest.mark.parametrize(("width", "scheme"), [(1280, "light"), (390, "dark")])
def test_axe_finds_nothing(browser, written, width, scheme):
    opened = Opened(browser, written.path, "#B=tum_2020;mean_2011", width, color_scheme=scheme)
    opened.window.evaluate("document.querySelectorAll('details').forEach(each => { each.open = true; })")
    assert violations(opened.window) == []
    opened.window.close()


@in_browser
def test_every_control_has_a_name(page):
    unnamed = page.window.evaluate(
        """() => [...document.querySelectorAll('input, select, button, svg[role], canvas')].filter(e =>
             !(e.labels?.length || e.getAttribute('aria-label') || e.textContent.trim())).map(e => e.outerHTML.slice(0, 80))"""
    )
    assert unnamed == []
