"""The words of the field: in documentation, help, messages, docstrings and comments, and in identifiers."""

import ast
import io
import re
import tokenize
from pathlib import Path

import pytest

from tests import ROOT

# Word or phrase -> what to write instead. Patterns ignore case.
INSTEAD = {
    r"\b(un|fore)?told\b": "input; predicted",
    r"\b(it|they|(fmu|unit|component|device|rider|model)s?) answers?\b|\banswers (with|a port|the torques?)\b": "output",
    r"\btest ?stands?\b|\bstands? of the test\b": "experiment",
    r"\bas good as (the )?noise\b": "consistent with the noise",
    r"\b(data|runs|tests?|recordings?) (can ?not|do(es)? not|can hardly) tell\b|\bcannot tell\b": "is not identifiable from these data",
    r"\bbears? (it|them) out\b|\bborne out\b|\btakes? (it|them|a name|names|the name) back\b|\btaken back\b": "the validation run confirms or rejects",
    r"\bhums?\b": "mains interference",
    r"\bloud(er|est)?\b": "large, by its measure",
    r"\b(law|effect)s? (without|with no|that ha(s|ve) no) name\b|\bno name explains\b": "effect outside the library, unspecified form",
    r"\bopen[- ]forms?\b": "unspecified form",
    r"\brefut\w*\b": "rejected by the validation run",
    r"\bled in\b|\blead(s|ing)? in\b": "continuation in the effect's magnitude",
    r"\blightened\b": "rider mass removed",
    r"\bmade linear for motion\b|\bin motion\b": "describing-function linearisation",
    r"\brebuilt\b": "reconstructed",
    r"\bsensor('s)? (that |zero )?is off\b|\bzero is off\b": "sensor offset",
    r"\bastray\b|\bfeign(s|ed)?\b|\bwanders?\b|\bspoil(s|t|ed)?\b|\bowns? not to\b|\bgives? up\b|\bjets?\b": "the technical word",
    r"\bready[- _]made\b": "prebuilt",
}
# Words that no identifier has, in whole or between underscores, except within the terms of TERMS.
IDENTIFIERS = {"told", "untold", "answers", "carries", "stand", "stands", "hum", "loud", "lightened", "moved", "jets", "tape", "traced", "bonds", "origin", "ready", "resisted",
               "realisation", "unlisted", "joining", "competing", "deciding", "naming", "foretold", "astray", "feigned", "refuted", "louder"}  # fmt: skip
TERMS = re.compile("power_bonds")
PAGES = [ROOT / "README.md", ROOT / "CONTRIBUTING.md", ROOT / "CHANGELOG.md", *sorted((ROOT / "docs").rglob("*.md"))]

C_SUFFIXES = ("*.c", "*.h", "*.in", "*.html")


def files(folders: str, *patterns: str) -> list[Path]:
    return [path for pattern in patterns for folder in folders.split() for path in sorted((ROOT / folder).rglob(pattern))]


SOURCES = files("motofmi fmus rider_fmu vehicle_fmu scenarios", "*.py")
TESTS = [path for path in files("tests benchmarks", "*.py", *C_SUFFIXES) if path != Path(__file__).resolve()]
C_SOURCES = files("fmus motofmi scenarios examples", *C_SUFFIXES)
# Where the quoted word is meant: a glossary that defines it, a title, another tool's term.
ALLOWED = {"docs/glossary.md"}


def prose_of(path: Path) -> str:
    """Comments and strings of a Python file; the whole text of any other."""
    text = path.read_text("utf-8")
    if path.suffix != ".py":
        return text
    kept = (tokenize.COMMENT, tokenize.STRING, *((tokenize.FSTRING_MIDDLE,) if hasattr(tokenize, "FSTRING_MIDDLE") else ()))
    return "\n".join(token.string for token in tokenize.generate_tokens(io.StringIO(text).readline) if token.type in kept)


def found_in(path: Path) -> list[str]:
    text = " ".join(prose_of(path).split())
    return [f"{path.relative_to(ROOT)}: ...{text[max(m.start() - 40, 0) : m.end() + 30]}... (write: {instead})"
            for pattern, instead in INSTEAD.items() for m in re.finditer(pattern, text, re.IGNORECASE)]  # fmt: skip


@pytest.mark.slow
@pytest.mark.parametrize("kind", ["pages", "sources", "tests", "c_sources"])
def test_prose_uses_the_words_of_the_field(kind):
    paths = {"pages": PAGES, "sources": SOURCES, "tests": TESTS, "c_sources": C_SOURCES}[kind]
    assert [line for path in paths if str(path.relative_to(ROOT)) not in ALLOWED for line in found_in(path)] == []


def names_in(path: Path) -> set[str]:
    """The names that a module defines: modules, classes, functions, arguments, variables."""
    found = {path.stem}
    for node in ast.walk(ast.parse(path.read_text("utf-8"))):
        if isinstance(node, (ast.FunctionDef, ast.AsyncFunctionDef, ast.ClassDef)):
            found.add(node.name)
        elif isinstance(node, ast.arg):
            found.add(node.arg)
        elif isinstance(node, ast.Name) and isinstance(node.ctx, ast.Store):
            found.add(node.id)
    return found


@pytest.mark.slow
def test_identifiers_use_the_words_of_the_field():
    wrong = {str(path.relative_to(ROOT)): sorted(bad) for path in [*SOURCES, *TESTS] if path.suffix == ".py"
             if (bad := {n for n in names_in(path) if set(re.split(r"_+", re.sub(r"(?<=[a-z])(?=[A-Z])", "_", TERMS.sub("", n)).lower())) & IDENTIFIERS})}  # fmt: skip
    assert wrong == {}


def test_the_word_list_finds_what_it_is_for(tmp_path):
    page = ROOT / "docs" / "glossary.md"
    assert found_in(page), "the glossary quotes words of the list"
