"""Scenarios by name and by report: every file of the folder `scenarios` is one.

A scenario has `run(**settings) -> answer` and `section(answer) -> Section`. One that is part of a
report says so itself:

    REPORT = InReport("tour", 20, "mode phasors")
"""

import inspect
import pkgutil
from collections.abc import Iterator
from dataclasses import dataclass
from importlib import import_module
from time import perf_counter
from types import ModuleType
from typing import Any

from fmus.support.errors import unknown
from fmus.support.progress import track
from motofmi.reports.report import Section


@dataclass(frozen=True)
class InReport:
    """The report of which a scenario is part, its place there (ascending), and its step in a few words."""

    report: str
    place: int
    step: str


@dataclass(frozen=True)
class Answered:
    """A scenario's answer as a section, and the time that it took [s]."""

    name: str
    step: str
    section: Section
    seconds: float


def scenario_names() -> list[str]:
    """The names of all scenarios, in alphabetical order."""
    folder = import_module("motofmi.scenarios")  # found by name: scenarios stand above this module
    return sorted(found.name for found in pkgutil.iter_modules(folder.__path__) if not found.ispkg)


def scenario(name: str) -> ModuleType:
    """The module of a scenario, with `run` and `section`. Raises InputError with the valid names for any other name."""
    if name not in scenario_names():
        raise unknown("scenario", name, scenario_names())
    return import_module(f"motofmi.scenarios.{name}")


def host(name: str) -> ModuleType:
    """The module of the host `name`, a simulator of others with FMUs of this package inside: `run()` returns its
    results.

    `python -m motofmi.scenarios.hosts` lists them. Raises InputError with the valid names for any other name;
    `run` raises ModuleNotFoundError where the simulator is not installed.

        >>> print(mf.host("mujoco_bar").HOST)
        MuJoCo
    """
    found: dict[str, ModuleType] = import_module("motofmi.scenarios.hosts").hosts()
    if name not in found:
        raise unknown("host", name, found)
    return found[name]


def scenarios_of(report: str) -> dict[str, ModuleType]:
    """The scenarios that are part of a report, in its order."""
    modules = {name: scenario(name) for name in scenario_names()}
    inside = {
        name: module
        for name, module in modules.items()
        if getattr(module, "REPORT", None) and module.REPORT.report == report
    }
    return dict(sorted(inside.items(), key=lambda item: item[1].REPORT.place))


def answered(report: str, **settings: Any) -> Iterator[Answered]:
    """The answers of a report's scenarios, each run with the settings that its `run` takes."""
    modules = scenarios_of(report)
    for name, module in track(modules.items(), report, len(modules)):
        start = perf_counter()
        taken = {key: value for key, value in settings.items() if key in inspect.signature(module.run).parameters}
        section = module.section(module.run(**taken))
        yield Answered(name, module.REPORT.step, section, perf_counter() - start)
