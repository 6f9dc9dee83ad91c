"""`import motofmi`: its names, its version, and that it is fast and without side effects."""

import ast
import json
import os
import re
import subprocess
import sys
import tomllib
from pathlib import Path

import pytest

import motofmi
from tests import ROOT

# Measured 0.01 s of processor time beyond the interpreter's own start; an import of numpy costs 0.1 s, one of sympy 0.6
# s.
LONGEST_IMPORT = 0.5  # s
MEASURE = """
import json, os, sys, time
environment, start = dict(os.environ), time.process_time()
import motofmi
seconds = time.process_time() - start
print(json.dumps({"seconds": seconds, "changed": dict(os.environ) != environment, "modules": sorted(sys.modules)}))
"""


def test_every_public_name_exists_and_says_what_it_is():
    for name in motofmi.__all__:
        found = getattr(motofmi, name)
        assert name.startswith("__") or found.__doc__, name
    assert set(motofmi.__all__) <= set(dir(motofmi))


def test_type_checkers_see_the_names_that_are_there():
    tree = ast.parse((ROOT / "motofmi" / "__init__.py").read_text("utf-8"))
    block = next(node for node in tree.body if isinstance(node, ast.If) and ast.unparse(node.test) == "TYPE_CHECKING")
    seen = {
        (node.module, alias.asname) for node in block.body if isinstance(node, ast.ImportFrom) for alias in node.names
    }
    assert seen == {(module, name) for module, names in motofmi.NAMES.items() for name in names}


def test_a_wrong_name_is_an_error_with_the_nearest_one():
    with pytest.raises(AttributeError, match="has no name 'rder', did you mean 'rider'"):
        _ = motofmi.rder
    assert not hasattr(motofmi, "names_that_nobody_declared")


def test_the_import_is_fast_and_changes_nothing():
    done = subprocess.run(
        [sys.executable, "-c", MEASURE],
        cwd=ROOT,
        capture_output=True,
        text=True,
        check=True,
        env={**os.environ, "COVERAGE_PROCESS_START": ""},
    )
    found = json.loads(done.stdout)
    assert found["seconds"] < LONGEST_IMPORT
    assert not found["changed"]
    assert not {"numpy", "scipy", "sympy", "pandas", "xarray", "matplotlib", "fmpy"} & set(found["modules"])


def test_the_version_is_the_one_of_the_project():
    assert motofmi.__version__ == tomllib.loads((ROOT / "pyproject.toml").read_text("utf-8"))["project"]["version"]


def test_star_import_brings_the_public_names():
    names: dict = {}
    exec("from motofmi import *", names)
    assert set(motofmi.__all__) <= set(names)


TUTORIALS = ROOT / "docs" / "tutorials"
OF_THE_PROJECT = re.compile(r"^ *(?:from (?:motofmi[.\w]*|fmus|rider_fmu|vehicle_fmu)\b|import (?:motofmi\.|fmus|rider_fmu|vehicle_fmu)).*", re.M)


def _code(page: Path) -> str:
    """The code of a tutorial, a page or a notebook."""
    text = page.read_text("utf-8")
    if page.suffix == ".ipynb":
        return "\n".join("".join(c["source"]) for c in json.loads(text)["cells"] if c["cell_type"] == "code")
    return "\n".join(re.findall(r"^```\{code-cell\}\n(.*?)^```", text, re.M | re.S))


@pytest.mark.parametrize("page", sorted([*TUTORIALS.glob("*.md"), *TUTORIALS.rglob("*.ipynb")]), ids=lambda page: page.stem)
def test_a_tutorial_needs_the_public_names_alone(page):
    assert OF_THE_PROJECT.findall(_code(page)) == []


def test_an_inner_import_is_found():
    assert OF_THE_PROJECT.findall("import motofmi as mf\nimport fmus.export\nfrom motofmi.gap import x\n    from fmus import y") == [
        "import fmus.export",
        "from motofmi.gap import x",
        "    from fmus import y",
    ]
