"""The terms of docs/glossary.md: their definitions, and the places of a page where they are marked.

The page is the one source. A wheel contains it as `motofmi/docs/glossary.md`.
"""

import re
from functools import cache
from pathlib import Path

from markupsafe import Markup, escape

PACKAGE = Path(__file__).parent.parent
FILES = [PACKAGE / "docs" / "glossary.md", PACKAGE.parent / "docs" / "glossary.md"]  # of a wheel, of a checkout
VERDICTS = ("named", "tied", "unknown", "none")  # ordinary words, too: terms only where a text begins with them
ORDINARY = ("base", "block", "place", "system", "port", "effect", "component", "device", "gap")  # marked once in a page


@cache
def terms() -> dict[str, str]:
    """Definition by term. A row that defines several terms, as in "fitted runs, validation run", counts for each."""
    page = next(path for path in FILES if path.is_file()).read_text("utf-8")
    rows = re.findall(
        r"^\| (?!term |-|not )(.+?) \| (.+?) \|$", page.partition("## Words that are avoided")[0], re.MULTILINE
    )
    return {term: meaning for names, meaning in rows for term in names.split(", ")}


def slug(term: str) -> str:
    """A term as part of an identifier."""
    return re.sub(r"[^a-z0-9]+", "-", term.lower()).strip("-")


@cache
def _pattern() -> re.Pattern[str]:
    ordinary = sorted((t for t in terms() if t not in VERDICTS), key=len, reverse=True)
    words = "|".join(re.escape(t) for t in ordinary)
    return re.compile(rf"(?<![\w-])({words})(?:s|es)?(?![\w-])|^({'|'.join(VERDICTS)})(?=[:;,.])", re.IGNORECASE)


class Marker:
    """Marks the first occurrence of each term in a section as a button that opens its definition."""

    def __init__(self) -> None:
        self._marked: set[str] = set()
        self._ever: set[str] = set()

    def begin(self) -> str:
        """Begin a section: every term is marked again. Returns no text."""
        self._marked = {term for term in self._ever if term in ORDINARY}
        return ""

    def marked(self, text: str) -> Markup:
        """The text as HTML with its terms marked."""
        out, last = [], 0
        for match in _pattern().finditer(text):
            term = self._term(match)
            if term in self._marked:
                continue
            self._marked.add(term)
            self._ever.add(term)
            out += [escape(text[last : match.start()]),
                    Markup(f'<button type="button" class="term" popovertarget="term-{slug(term)}">'),
                    escape(match.group()), Markup("</button>")]  # fmt: skip
            last = match.end()
        return Markup("").join([*out, escape(text[last:])])

    def explained(self) -> list[tuple[str, str]]:
        """Term and definition of all that were marked."""
        return [(term, terms()[term]) for term in sorted(self._ever)]

    @staticmethod
    def _term(match: re.Match[str]) -> str:
        word = (match.group(1) or match.group(2)).lower()
        return next(term for term in terms() if term.lower() == word)
