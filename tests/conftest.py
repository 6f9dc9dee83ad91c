"""Fixtures: property tests that repeat, a cache of FMUs for the run of the tests, FMUs that are closed again."""

import os
import sys

if "PYTEST_XDIST_WORKER" in os.environ:  # the other processors have workers of their own; numpy reads this once
    os.environ.setdefault("OMP_NUM_THREADS", "1")

# Workers and the commands that tests start would otherwise compile the packages again, each time.
os.environ.pop("PYTHONDONTWRITEBYTECODE", None)

import pytest
from hypothesis import settings

from fmus.export.build import build
from tests.importer import Opened

# The same examples in every run, on every machine, however slow.
settings.register_profile("reproducible", derandomize=True, deadline=None)
settings.load_profile("reproducible")


def pytest_collection_modifyitems(items):
    """A study is slow: `-m "not slow"` replaces the expression of pyproject.toml, which leaves studies out."""
    for item in items:
        if "study" in item.keywords:
            item.add_marker(pytest.mark.slow)


@pytest.fixture(scope="session")
def cache(tmp_path_factory):
    """The folder of built FMUs, which all workers of a run share: archives are stored atomically."""
    run = tmp_path_factory.getbasetemp()
    folder = (run.parent if "PYTEST_XDIST_WORKER" in os.environ else run) / "cache"
    folder.mkdir(exist_ok=True)
    return folder


@pytest.fixture(autouse=True)
def private_cache(cache, monkeypatch):
    """No test reads or leaves anything in the user's own cache."""
    monkeypatch.setenv("MOTOFMI_CACHE", str(cache))


@pytest.fixture
def without_compiler(tmp_path, monkeypatch):
    """A machine without a C compiler: no $CC, nothing on the search path, and no package ziglang."""
    empty = tmp_path / "empty_search_path"
    empty.mkdir()
    monkeypatch.delenv("CC", raising=False)
    monkeypatch.setenv("PATH", str(empty))
    monkeypatch.setitem(sys.modules, "ziglang", None)


@pytest.fixture
def opened(tmp_path):
    """Opens the FMU of a component: opened(component, exchange=False, **options of build)."""
    made = []

    def open_fmu(component, exchange=False, **options):
        made.append(Opened(build(component, tmp_path, **options).path, exchange))
        return made[-1]

    yield open_fmu
    for each in made:
        each.close()
