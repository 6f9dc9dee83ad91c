"""Fixtures: the small FMUs of `bench`, compiled once per session."""

import os

import pytest

from fmus.export.compilers import host_compiler
from tests.fmus.checks import bench


@pytest.fixture(scope="session")
def libraries(tmp_path_factory):
    """The library of a source with flags: libraries("fmu2.c", "-DBALL")."""
    if host_compiler() is None or os.name == "nt":
        pytest.skip("needs a C compiler and POSIX")
    folder, made = tmp_path_factory.mktemp("bench"), {}

    def library(source, *flags):
        key = (source, flags)
        if key not in made:
            made[key] = bench.compiled(source, folder / f"{len(made)}.so", *flags)
        return made[key]

    return library
