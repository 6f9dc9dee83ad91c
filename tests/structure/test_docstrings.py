"""Docstrings of the public interface: parameters, units, errors, and examples that run."""

import doctest
import inspect
import re
from collections.abc import Sequence
from importlib.util import find_spec
from typing import Any, get_type_hints

import matplotlib.pyplot as plt
import numpy as np
import pytest

import motofmi
from fmus.export.compilers import host_compiler
from fmus.support.errors import MissingToolError

PACKAGES = {"motofmi", "fmus", "rider_fmu", "vehicle_fmu"}
PUBLIC = {name: getattr(motofmi, name) for name in sorted(motofmi.__all__) if not name.startswith("__")}
FUNCTIONS = {name: found for name, found in PUBLIC.items() if inspect.isfunction(found)}
# Measured processor time of the examples: over 0.25 s slow, over 5 s a study.
QUICK = {
    "Component",
    "Effect",
    "Element",
    "HandlebarDevice",
    "InputError",
    "adds_to",
    "calculated",
    "component",
    "damper",
    "input",
    "local",
    "mechanism",
    "Variable",
    "output",
    "parameter",
    "rider",
    "schema",
    "state",
    "transfer_functions",
    "vehicle",
}
STUDIES = {"explore", "find_gap", "tour", "plan_experiment"}
SCALE = {"batch", "open_study", "sweep"}
FLAGS = doctest.NORMALIZE_WHITESPACE | doctest.ELLIPSIS | doctest.IGNORE_EXCEPTION_DETAIL


def _result(function: Any) -> Any:
    """The class that a function of the project returns, or None."""
    found = get_type_hints(function).get("return")
    return found if inspect.isclass(found) and found.__module__.split(".")[0] in PACKAGES else None


RESULTS = {found.__name__: (found, function) for function in FUNCTIONS.values() if (found := _result(function))}
CLASSES = {**RESULTS, **{n: (found, None) for n, found in PUBLIC.items() if inspect.isclass(found)}}
EXAMPLES = {**PUBLIC, **{n: found for n, (found, _) in RESULTS.items() if ">>>" in (inspect.getdoc(found) or "")}}


def _members(owner: type) -> dict[str, Any]:
    """The public methods and properties that the project defines."""
    return {
        name: found
        for name in dir(owner)
        if not name.startswith("_")
        and (
            inspect.isfunction(found := inspect.getattr_static(owner, name))
            or hasattr(found, "fget")
            or hasattr(found, "func")
        )
        and _module(found).split(".")[0] in PACKAGES
    }


def _module(member: Any) -> str:
    return (getattr(member, "fget", None) or getattr(member, "func", None) or member).__module__ or ""


def _marks(name: str) -> Sequence[Any]:
    return () if name in QUICK else [pytest.mark.study if name in STUDIES else pytest.mark.slow]


def _runs(example: str) -> doctest.DocTest:
    return doctest.DocTestParser().get_doctest(example, {"mf": motofmi, "np": np}, "example", None, 0)


@pytest.mark.parametrize("name", [pytest.param(name, marks=_marks(name)) for name in sorted(EXAMPLES)])
def test_the_example_of_a_public_name_runs(name, tmp_path, monkeypatch):
    if host_compiler() is None and name not in QUICK:
        pytest.skip("no C compiler on this machine")
    if name in SCALE and (find_spec("zarr") is None or find_spec("pyarrow") is None):
        pytest.skip("needs pip install 'motofmi[scale]'")
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("MPLBACKEND", "Agg")
    example = _runs(inspect.getdoc(EXAMPLES[name]) or "")
    messages: list[str] = []
    runner = doctest.DocTestRunner(optionflags=FLAGS)
    runner.run(example, out=messages.append)
    plt.close("all")
    if name == "explore" and MissingToolError.__name__ in "".join(messages):
        pytest.skip("no WebAssembly compiler on this machine (pip install 'motofmi[platforms]')")
    assert runner.failures == 0, "".join(messages)


@pytest.mark.parametrize("name", sorted(PUBLIC))
def test_every_public_name_has_an_example(name):
    assert _runs(inspect.getdoc(PUBLIC[name]) or "").examples, f"{name} has no example of the form >>> ..."


@pytest.mark.parametrize("name", sorted(FUNCTIONS))
def test_a_public_function_states_parameters_units_and_errors(name):
    text = inspect.getdoc(FUNCTIONS[name]) or ""
    prose = "\n".join(line for line in text.splitlines() if not line.lstrip().startswith((">>>", "...")))
    parameters = inspect.signature(FUNCTIONS[name]).parameters
    named = [p for p in parameters if p not in ("given", "si_unit", "description")]
    missing = [p for p in named if not re.search(rf"\b{p}\b", prose)]
    assert missing == [], f"{name} does not say what they are"
    if parameters:
        assert "Raises" in prose or "raises" in prose, f"{name} does not say which errors it raises"
    assert re.search(r"\[[^\]]+\]|\bin Hz\b|\bin s\b|\bin m/s\b|\bSI\b", text) or name in WITHOUT_QUANTITIES, name


# They take and return names, files and results that carry their units themselves.
WITHOUT_QUANTITIES = {"batch", "estimate_roll_frf", "explore", "host", "open_study", "tour"}


@pytest.mark.parametrize("name", sorted(CLASSES))
def test_every_public_member_of_a_class_is_described_and_shown(name):
    owner, function = CLASSES[name]
    members = _members(owner)
    assert [n for n in members if not inspect.getdoc(getattr(owner, n))] == []
    if function is not None:  # a result: the examples of the class or of the function show every member
        shown = "".join(inspect.getdoc(each) or "" for each in (function, *owner.__mro__[:-1]))
        assert [n for n in members if not re.search(rf"[.`]{n}\b", shown)] == []
