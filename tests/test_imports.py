"""Imports run one way: fmus <- rider_fmu, vehicle_fmu, identification <- scenarios."""

import ast
import sys
import tomllib
from pathlib import Path

import pytest

ROOT = Path(__file__).parent.parent
MAY_IMPORT = {
    "fmus": {"fmus"},
    "rider_fmu": {"fmus", "rider_fmu"},
    "vehicle_fmu": {"fmus", "vehicle_fmu"},
    "identification": {"fmus", "identification"},
    "scenarios": {"fmus", "rider_fmu", "vehicle_fmu", "identification", "scenarios"},
}
# In the gap workflow data flow one way too: each of these may import those before it.
GAP = ("stands", "data", "models", "naming", "proposing", "reporting")
OURS = set(MAY_IMPORT) | {"tests", "benchmarks"}
MODULES = [path for package in MAY_IMPORT for path in sorted((ROOT / package).rglob("*.py"))]
# The import names of the packages that are optional, by the names under which they are installed.
IMPORT_NAMES = {"ziglang": "ziglang", "asammdf": "asammdf", "pyarrow": "pyarrow", "pandas": "pandas", "pyuff": "pyuff"}

# CoFMPy asks for older releases than this project needs: it is installed without its dependencies, and no extra can name it.
WITHOUT_EXTRA = {"cofmupy"}


def optional_packages() -> set[str]:
    extras = tomllib.loads((ROOT / "pyproject.toml").read_text("utf-8"))["project"]["optional-dependencies"]
    names = {requirement.split(">")[0].split("=")[0].split("[")[0] for extra, list_ in extras.items() if extra != "dev" for requirement in list_}
    return {IMPORT_NAMES.get(name, name.replace("-", "_")) for name in names} | WITHOUT_EXTRA


def imported(node: ast.AST) -> list[str]:
    """The packages that an import statement names, outermost names only; none for anything else."""
    if isinstance(node, ast.Import):
        return [alias.name.split(".")[0] for alias in node.names]
    if isinstance(node, ast.ImportFrom):
        return [(node.module or "").split(".")[0]]
    return []


def tree(path: Path) -> ast.Module:
    return ast.parse(path.read_text("utf-8"), str(path))


@pytest.mark.parametrize("path", MODULES, ids=lambda p: str(p.relative_to(ROOT)))
def test_a_module_imports_only_what_lies_below_it(path):
    package = path.relative_to(ROOT).parts[0]
    used = {name for node in ast.walk(tree(path)) for name in imported(node)}
    assert used & OURS <= MAY_IMPORT[package]
    assert not any(node.level for node in ast.walk(tree(path)) if isinstance(node, ast.ImportFrom)), "absolute imports only"


@pytest.mark.parametrize("path", [p for p in MODULES if p.parent.name in GAP], ids=lambda p: str(p.relative_to(ROOT)))
def test_a_stage_of_the_gap_workflow_imports_only_earlier_ones(path):
    names = [node.module.split(".") for node in ast.walk(tree(path)) if isinstance(node, ast.ImportFrom) and node.module]
    used = {name[2] for name in names if name[:2] == ["identification", "gap"]}
    assert used <= set(GAP[: GAP.index(path.parent.name) + 1])


@pytest.mark.parametrize("path", MODULES, ids=lambda p: str(p.relative_to(ROOT)))
def test_a_function_imports_nothing_but_an_optional_dependency(path):
    functions = [n for n in ast.walk(tree(path)) if isinstance(n, (ast.FunctionDef, ast.AsyncFunctionDef, ast.Lambda))]
    inside = {name for function in functions for node in ast.walk(function) for name in imported(node)}
    assert inside <= optional_packages()


@pytest.mark.parametrize("path", MODULES, ids=lambda p: str(p.relative_to(ROOT)))
def test_what_is_imported_at_the_top_is_a_dependency(path):
    project = tomllib.loads((ROOT / "pyproject.toml").read_text("utf-8"))["project"]
    required = {r.split(">")[0].replace("-", "_") for r in project["dependencies"]}
    used = {name for node in ast.walk(tree(path)) for name in imported(node)}
    assert used - OURS - set(sys.stdlib_module_names) <= required | optional_packages()
    at_top = {name for node in tree(path).body for name in imported(node)}
    assert not at_top & optional_packages(), "an optional dependency is imported where it is used"


def test_no_module_is_a_drawer_of_odds_and_ends():
    assert not [p for p in MODULES if p.stem in ("utils", "util", "helpers", "helper", "misc", "common", "tools")]
