"""Imports run one way: between the packages, between the rooms of a package, and between modules."""

import ast
import sys
import tomllib
from functools import cache
from pathlib import Path

import pytest

from tests import ROOT

# Each room may import those before it, and itself. A module directly in a package is a room of its own; a package's
# `__init__.py` stands above its rooms.
ROOMS = (
    "fmus.support", "fmus.expressions", "fmus.declaration", "fmus.equations", "fmus.effects", "fmus.composition", "fmus.interfaces",
    "fmus.mechanisms", "fmus.linear_analysis", "fmus.export", "fmus.cosimulation", "fmus.checks", "fmus",
    "rider_fmu", "vehicle_fmu",
    "motofmi.version", "motofmi.schemas", "motofmi.recordings", "motofmi.frequency_response", "motofmi.identification",
    "motofmi.gap.criteria", "motofmi.gap.experiments", "motofmi.gap.preprocessing", "motofmi.gap.models", "motofmi.gap.estimation", "motofmi.gap.validation",
    "motofmi.gap.comparison", "motofmi.gap.selection", "motofmi.gap.experiment_design", "motofmi.gap.localisation", "motofmi.gap",
    "motofmi.virtual_rig", "motofmi.studies", "motofmi.reports", "motofmi.workflows", "motofmi.cli", "motofmi", "motofmi.scenarios",
)  # fmt: skip
# The gap workflow knows components, not riders and motorcycles; riders and vehicles meet by the names of their ports.
APART = [("rider_fmu", "vehicle_fmu"), ("motofmi.recordings", "rider_fmu"), ("motofmi.gap", "rider_fmu"), ("motofmi.gap", "vehicle_fmu"),
         ("motofmi.identification", "rider_fmu"), ("motofmi.frequency_response", "rider_fmu")]  # fmt: skip
PACKAGES = {
    "motofmi": "motofmi",
    "fmus": "fmus",
    "rider_fmu": "rider_fmu",
    "vehicle_fmu": "vehicle_fmu",
    "scenarios": "motofmi.scenarios",
}
MODULES = [path for folder in PACKAGES for path in sorted((ROOT / folder).rglob("*.py"))]
OURS = {"fmus", "rider_fmu", "vehicle_fmu", "motofmi", "tests", "benchmarks"}
# Core dependencies that take long to import: functions import them, so that `import motofmi` stays fast.
ON_USE = {"control", "pandas", "xarray"}
# Modules that take 0.3 to 0.7 s to import: those that only some functions of a module need are imported by these.
SLOW_MODULES = {
    "scipy.optimize", "scipy.integrate", "scipy.signal", "scipy.stats", "fmus.equations.sympy_form", "matplotlib.figure",
    "motofmi.workflows.batch.batch",
}  # fmt: skip
# CoFMPy asks for older releases than this project needs: it is installed without its dependencies, and no extra can
# name it.
WITHOUT_EXTRA = {"cofmupy"}


def project() -> dict:
    return tomllib.loads((ROOT / "pyproject.toml").read_text("utf-8"))["project"]


def import_name(requirement: str) -> str:
    return requirement.split(">")[0].split("=")[0].split("[")[0].replace("-", "_")


def optional_packages() -> set[str]:
    extras = project()["optional-dependencies"]
    return {
        import_name(r) for extra, requirements in extras.items() if extra not in ("dev", "docs") for r in requirements
    } | WITHOUT_EXTRA


@cache
def tree(path: Path) -> ast.Module:
    return ast.parse(path.read_text("utf-8"), str(path))


def outermost(node: ast.AST) -> list[str]:
    """The packages that an import statement names, outermost names only; none for anything else."""
    if isinstance(node, ast.Import):
        return [alias.name.split(".")[0] for alias in node.names]
    if isinstance(node, ast.ImportFrom):
        return [(node.module or "").split(".")[0]]
    return []


def dotted(path: Path) -> str:
    """The name under which a module is imported."""
    folder, *rest = path.relative_to(ROOT).with_suffix("").parts
    return ".".join([PACKAGES[folder], *rest]).removesuffix(".__init__")


NAMES = {dotted(path): path for path in MODULES}


@cache
def modules_imported(path: Path) -> set[str]:
    """The project's own modules that a module imports, by their full names."""
    found = set()
    for node in ast.walk(tree(path)):
        if isinstance(node, ast.ImportFrom) and node.module:
            found |= {full if (full := f"{node.module}.{alias.name}") in NAMES else node.module for alias in node.names}
        elif isinstance(node, ast.Import):
            found |= {alias.name for alias in node.names}
    return found & NAMES.keys()


def room(name: str) -> str:
    """The innermost room of a module; a room's own `__init__.py` belongs to it."""
    return max((r for r in ROOMS if name == r or name.startswith(f"{r}.")), key=len)


def test_every_module_is_in_a_listed_package():
    assert [name for name in NAMES if not any(name == r or name.startswith(f"{r}.") for r in ROOMS)] == []


@pytest.mark.slow
def test_a_room_imports_only_rooms_before_it():
    upwards = [(name, other) for name, path in NAMES.items() for other in modules_imported(path)
               if ROOMS.index(room(other)) > ROOMS.index(room(name))]  # fmt: skip
    assert upwards == []


@pytest.mark.slow
@pytest.mark.parametrize(("one", "other"), APART)
def test_rooms_that_do_not_know_each_other(one, other):
    def inside(name, of):
        return name == of or name.startswith(f"{of}.")

    known = [(name, used) for name, path in NAMES.items() for used in modules_imported(path)
             if (inside(name, one) and inside(used, other)) or (inside(name, other) and inside(used, one))]  # fmt: skip
    assert known == []


@pytest.mark.slow
def test_no_modules_import_each_other_in_a_circle():
    left = {name: modules_imported(path) - {name} for name, path in NAMES.items()}
    while free := [name for name, used in left.items() if not used & left.keys()]:
        for name in free:
            del left[name]
    assert sorted(left) == []


@pytest.mark.slow
def test_imports_are_absolute():
    assert [str(p) for p in MODULES if any(isinstance(n, ast.ImportFrom) and n.level for n in ast.walk(tree(p)))] == []


@pytest.mark.slow
def test_a_function_imports_nothing_but_an_optional_dependency():
    allowed = optional_packages() | ON_USE
    wrong = {}
    for name, path in NAMES.items():
        functions = [
            n for n in ast.walk(tree(path)) if isinstance(n, (ast.FunctionDef, ast.AsyncFunctionDef, ast.Lambda))
        ]
        nodes = [node for function in functions for node in ast.walk(function)]
        inside = {used for node in nodes if getattr(node, "module", "") not in SLOW_MODULES for used in outermost(node)}
        if inside - allowed:
            wrong[name] = inside - allowed
    assert wrong == {}


@pytest.mark.slow
def test_what_is_imported_at_the_top_is_a_dependency():
    required = {import_name(r) for r in project()["dependencies"]}
    unknown, not_on_use = {}, {}
    for name, path in NAMES.items():
        used = {u for node in ast.walk(tree(path)) for u in outermost(node)} - OURS - set(sys.stdlib_module_names)
        at_top = {u for node in tree(path).body for u in outermost(node)}
        if used - required - optional_packages():
            unknown[name] = used
        if at_top & ((optional_packages() - required) | ON_USE):
            not_on_use[name] = at_top
    assert (unknown, not_on_use) == ({}, {})


def test_no_module_is_a_drawer_of_odds_and_ends():
    assert not [p for p in MODULES if p.stem in ("utils", "util", "helpers", "helper", "misc", "common", "tools")]


def test_no_product_file_looks_like_a_test():
    assert not [p for p in MODULES if p.stem.startswith("test_") or p.stem.endswith("_test")]
