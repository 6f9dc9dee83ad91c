"""The pages: links lead somewhere, commands exist, spelling is right."""

import re
import shlex
import shutil
import subprocess
import sys
from importlib.util import find_spec
from pathlib import Path
from urllib.parse import unquote

import pytest

from motofmi.cli.listing import commands
from motofmi.cli.parser import Parser, fill
from motofmi.cli.run import imported
from tests import ROOT

FOLDERS = ("docs", ".github", "paper")
RENDERED = ROOT / "docs" / "reference" / "rendered"
GALLERY = ROOT / "docs" / "how_to" / "gallery"
PAGES = [
    *sorted(ROOT.glob("*.md")),
    *(
        path
        for folder in FOLDERS
        for path in sorted((ROOT / folder).rglob("*.md"))
        if RENDERED not in path.parents and GALLERY not in path.parents
    ),
]
LINK = re.compile(r"\]\(([^)\s]+)\)|\{download\}`([^`<]+)`")
CODE = re.compile(r"^(```|~~~).*?^\1\s*$|`[^`\n]*`", re.MULTILINE | re.DOTALL)
FENCED = re.compile(r"^```sh\n(.*?)^```", re.MULTILINE | re.DOTALL)


def _links(page: Path) -> list[str]:
    """The targets of a page's links that are no addresses of the web."""
    text = page.read_text("utf-8")
    found = [a for a, _ in LINK.findall(CODE.sub("", text))] + [b for _, b in LINK.findall(text) if b]
    return [unquote(target) for target in found if not re.match(r"[a-z]+:", target)]


def _anchors(page: Path) -> set[str]:
    """The anchors of a page's headings, as the site and the forges make them."""
    headings = re.findall(r"^#+ (.+)$", CODE.sub("", page.read_text("utf-8")), re.MULTILINE)
    return {re.sub(r"[^\w\- ]", "", heading.lower()).strip().replace(" ", "-") for heading in headings}


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.relative_to(ROOT).as_posix())
def test_links_lead_to_files_and_headings_that_exist(page):
    for link in _links(page):
        target, _, anchor = link.partition("#")
        file = (page.parent / target).resolve() if target else page
        assert file.exists() or RENDERED in file.parents, f"{page.name} links to {link}"
        if anchor and file.suffix == ".md" and file.exists():
            assert anchor in _anchors(file), f"{page.name} links to {link}"


def test_links_to_rendered_pages_are_those_that_the_extension_renders():
    source = (ROOT / "docs" / "extension" / "__init__.py").read_text("utf-8")
    rendered = set(re.findall(r'"(\w+)(?:\.svg)?": \w+\.\w+', source))
    linked = {Path(link.partition("#")[0]).stem for page in PAGES for link in _links(page) if "rendered/" in link}
    assert linked <= rendered


def _command_lines() -> list[tuple[str, str]]:
    found = []
    for page in PAGES:
        text = page.read_text("utf-8")
        blocks = [
            *FENCED.findall(text),
            *re.findall(r"^    (motofmi .*)$", re.sub(r"^```.*?^```", "", text, flags=re.M | re.S), re.MULTILINE),
        ]
        for line in "\n".join(blocks).replace("\\\n", " ").splitlines():
            found += [(page.name, part.strip()) for part in line.split("&&") if part.strip().startswith("motofmi ")]
    return found


@pytest.mark.slow
def test_every_command_of_the_pages_is_understood(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    lines = _command_lines()
    assert len(lines) > 50
    for page, line in lines:
        _, name, *words = shlex.split(re.split(r"\s[|>]\s", line)[0], comments=True)
        if name in ("help", "--version") or any(word in ("...", "[...]") for word in words):
            continue
        assert name in commands(), f"{page}: {line}"
        command = imported(commands()[name].module)
        assert fill(Parser(prog=name), command).options(words), f"{page}: {line}"


@pytest.mark.skipif(
    find_spec("codespell_lib") is None or shutil.which("git") is None,
    reason="needs codespell (pip install motofmi[dev]) and git",
)
@pytest.mark.slow
def test_spelling():
    listed = subprocess.run(["git", "ls-files"], cwd=ROOT, capture_output=True, text=True, check=False).stdout.split()
    if not listed:
        pytest.skip("not in a checkout")
    done = subprocess.run(
        [sys.executable, "-m", "codespell_lib", *listed], cwd=ROOT, capture_output=True, text=True, check=False
    )
    assert done.returncode == 0, done.stdout
