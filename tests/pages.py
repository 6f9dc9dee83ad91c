"""What every report's page must be: a first screen, no request, links that exist, terms that are defined; and, in a
browser, no error, nothing wider than the screen, charts that switch and zoom."""

from collections.abc import Iterator
from contextlib import contextmanager
from html.parser import HTMLParser
from pathlib import Path
from typing import Any
from urllib.parse import unquote

from tests.accessibility import HAS_AXE, violations
from tests.browser import chromium, needs_browser

__all__ = ["Page", "assert_is_a_report", "assert_works_in_a_browser", "needs_browser", "opened"]

WIDTHS = (1280, 390)
FETCHING = {"src", "href", "srcset", "action", "data", "poster", "formaction", "background"}


class Page(HTMLParser):
    """The elements of a page: tag and attributes, in order, and the text outside scripts and styles."""

    def __init__(self, path: Path) -> None:
        super().__init__()
        self.path, self.elements, self.text, self._inside = path, [], "", ""
        self.source = path.read_text("utf-8")
        self.feed(self.source)

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.elements.append((tag, {name: value or "" for name, value in attrs}))
        self._inside = tag

    def handle_endtag(self, tag: str) -> None:
        self._inside = ""

    def handle_data(self, data: str) -> None:
        if self._inside not in ("script", "style"):
            self.text += data

    def of_class(self, name: str) -> list[int]:
        """The places of the elements with a class."""
        return [k for k, (_, attributes) in enumerate(self.elements) if name in attributes.get("class", "").split()]


def assert_is_a_report(path: Path, inputs: int = 0, command: str = "", pictures: int = 1) -> Page:
    """The structure of a report's page, with so many inputs and at least so many charts."""
    page = Page(path)
    tags = [tag for tag, _ in page.elements]
    first, nav = tags.index("h1"), tags.index("nav")
    for name in ("asked", "lead", "chart"):  # the question, the answer and a picture, before anything else
        assert any(first < k < nav for k in page.of_class(name)), name
    assert len(page.of_class("chart")) >= pictures and "img" not in tags
    for tag, attributes in page.elements:
        for address in (value for name, value in attributes.items() if name in FETCHING):
            local = unquote(address).partition("#")[0]
            assert address.startswith(("#", "data:")) or (path.parent / local).is_file(), (tag, address)
    assert "@import" not in page.source and "url(" not in page.source.partition("</style>")[0]
    defined = {attributes["id"] for _, attributes in page.elements if "popover" in attributes}
    used = {attributes["popovertarget"] for _, attributes in page.elements if "popovertarget" in attributes}
    assert used and used == defined
    made = page.text[page.text.rindex("How this report was made") :]
    assert "motofmi 0." in made and command in made and made.count("SHA-256") == inputs
    assert "not available" not in made
    return page


@contextmanager
def opened(path: Path, width: int, scheme: str = "light") -> Iterator[tuple[Any, list[str]]]:
    """The page in headless Chromium at a width [px], and what went wrong in it: errors, and requests other than its own
    file."""
    with chromium() as browser:
        yield _opened_in(browser, path, width, scheme)


def _opened_in(browser: Any, path: Path, width: int, scheme: str) -> tuple[Any, list[str]]:
    page = browser.new_context(viewport={"width": width, "height": 900}, color_scheme=scheme).new_page()
    wrong: list[str] = []
    page.on("console", lambda message: wrong.append(message.text) if message.type in ("error", "warning") else None)
    page.on("pageerror", lambda error: wrong.append(str(error)))
    page.on(
        "request",
        lambda request: (
            None if request.url.startswith(("data:", path.resolve().as_uri())) else wrong.append(request.url)
        ),
    )
    page.goto(path.resolve().as_uri())
    return page, wrong


# Elements that reach beyond the right edge, other than within a frame that scrolls.
WIDER = """() => [...document.querySelectorAll('body *')].filter((e) => e.getBoundingClientRect().right > innerWidth + 1
  && !e.closest('.wide') && e.checkVisibility()).map((e) => `${e.tagName} ${e.className}`)"""
EMPTY = "() => [...document.querySelectorAll('.panel')].filter((e) => e.checkVisibility() && e.querySelectorAll('svg path').length < 3).length"
SMALL = "() => [...document.querySelectorAll('.panel text')].filter((e) => parseFloat(getComputedStyle(e).fontSize) < 11).length"


def assert_works_in_a_browser(path: Path) -> None:
    """No error, no request, nothing wider than the screen, no empty chart and no small print, at both widths; nothing
    that axe-core finds, where it is installed."""
    with chromium() as browser:
        for width, scheme in zip(WIDTHS, ("light", "dark"), strict=True):
            page, wrong = _opened_in(browser, path, width, scheme)
            assert page.evaluate("document.documentElement.scrollWidth") <= width
            assert page.evaluate(WIDER) == [] and page.evaluate(EMPTY) == 0 and page.evaluate(SMALL) == 0
            page.evaluate("document.querySelectorAll('details').forEach((each) => { each.open = true; })")
            page.evaluate("dispatchEvent(new Event('beforeprint')); dispatchEvent(new Event('afterprint'))")
            assert wrong == []
            assert page.evaluate(WIDER) == []
            if HAS_AXE:
                assert violations(page) == []
            page.context.close()
