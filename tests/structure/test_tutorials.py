"""The tutorials, followed as a reader does: what the built pages show is copied, in its order, into a fresh
environment."""

import os
import subprocess
import sys
from importlib.util import find_spec
from pathlib import Path

import pytest

from fmus.export.compilers import host_compiler
from tests import ROOT
from tests.installation import fresh_environment

TUTORIALS = sorted(path.stem for path in (ROOT / "docs" / "tutorials").glob("*.md") if path.stem != "index")
NEEDED = ("sphinx", "myst_nb", "sphinx_gallery", "nbformat", "IPython", "build")
pytestmark = [
    pytest.mark.study,
    pytest.mark.skipif(host_compiler() is None, reason="no C compiler on this machine"),
    pytest.mark.skipif(not all(map(find_spec, NEEDED)), reason="needs pip install 'motofmi[dev,docs]'"),
]


@pytest.fixture(scope="module")
def site(tmp_path_factory):
    """The site, of the tutorials alone: built without executing the pages, since what they show is executed below."""
    copied, built = tmp_path_factory.mktemp("checkout"), tmp_path_factory.mktemp("site")
    for path in (*(ROOT / "docs").rglob("*"), ROOT / "benchmarks" / "results.json"):
        if path.is_file() and not {"rendered", "gallery", "__pycache__"} & set(path.parts):
            copy = copied / path.relative_to(ROOT)
            copy.parent.mkdir(parents=True, exist_ok=True)
            copy.write_bytes(path.read_bytes())
    done = subprocess.run(
        [
            sys.executable,
            "-m",
            "sphinx",
            "-q",
            "-D",
            "nb_execution_mode=off",
            "-D",
            "sphinx_gallery_conf.plot_gallery=False",
            str(copied / "docs"),
            str(built),
        ],
        cwd=ROOT,
        env={**os.environ, "PYTHONPATH": str(ROOT)},
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, done.stderr
    return built


@pytest.fixture(scope="module")
def python(tmp_path_factory):
    """A Python in which the project is installed from its wheel."""
    return fresh_environment(tmp_path_factory.mktemp("environment"))


def _copied(page: Path) -> list[tuple[str, str]]:
    """The code of a page in its order: ("python" or "sh", text)."""
    lxml = pytest.importorskip("lxml.html")
    document = lxml.fromstring(page.read_text("utf-8"))
    query = "//div[contains(@class, 'cell_input')]//pre | //div[contains(@class, 'highlight-sh')]//pre"
    blocks = [
        (each, "sh" if "highlight-sh" in "".join(each.xpath("ancestor::div/@class")) else "python")
        for each in document.xpath(query)
    ]
    return [(kind, each.text_content()) for each, kind in blocks]


def _notebook(blocks: list[tuple[str, str]]) -> object:
    nbformat = pytest.importorskip("nbformat")
    cells = [
        nbformat.v4.new_code_cell(text if kind == "python" else f"%%bash\nset -eu\n{text}") for kind, text in blocks
    ]
    return nbformat.v4.new_notebook(cells=[nbformat.v4.new_code_cell("%matplotlib agg"), *cells])


@pytest.mark.parametrize("name", TUTORIALS)
def test_a_reader_who_copies_the_commands_gets_through(name, site, python, tmp_path):
    blocks = _copied(site / "tutorials" / f"{name}.html")
    assert len(blocks) >= 5
    nbformat = pytest.importorskip("nbformat")
    nbformat.write(_notebook(blocks), tmp_path / "copied.ipynb")
    kept = {key: value for key, value in os.environ.items() if key != "PYTHONPATH"}
    done = subprocess.run(
        [str(python), "-m", "IPython", "--colors=NoColor", "copied.ipynb"],
        cwd=tmp_path,
        env={
            **kept,
            "PATH": f"{python.parent}{os.pathsep}{os.environ['PATH']}",
            "IPYTHONDIR": str(tmp_path / "ipython"),
        },
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0 and "Traceback" not in done.stdout + done.stderr, (
        done.stdout[-3000:] + done.stderr[-3000:]
    )
