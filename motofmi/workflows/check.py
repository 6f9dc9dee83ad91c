"""Compliance checks of FMUs of this and of other tools."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from fmus.checks.check import check as problems_of
from fmus.checks.problem import SEVERITIES, Problem
from fmus.support.errors import InputError, unknown
from fmus.support.notebook import html
from fmus.support.progress import track
from fmus.support.sandbox import Limits

COLUMNS = ("fmu", "check", "severity", "message", "where", "call", "status", "log", "section")


@dataclass(frozen=True, repr=False)
class CheckReport:
    """The problems that were found in FMUs, by the path of each; `check` shows an example."""

    problems: Mapping[str, Sequence[Problem]]

    @property
    def clean(self) -> bool:
        """Whether no FMU has an error; warnings and notes are allowed."""
        return not any(problem.severity == "error" for found in self.problems.values() for problem in found)

    def __getitem__(self, path: str | Path) -> Sequence[Problem]:
        if str(path) not in self.problems:
            raise unknown("FMU", path, self.problems)
        return self.problems[str(path)]

    def __repr__(self) -> str:
        return f"CheckReport({'; '.join(f'{path}: {_count(found)}' for path, found in self.problems.items())})"

    def _repr_html_(self) -> str:
        text = "; ".join(f"{path}: {_count(found)}" for path, found in self.problems.items())
        return html(
            text,
            ("FMU", "severity", "check", "message", "where", "log", "section"),
            [
                (path, p.severity, p.check, p.message, p.where, p.log, p.section)
                for path, found in self.problems.items()
                for p in found
            ],
        )

    def to_dict(self) -> dict[str, Any]:
        """The keys of `motofmi check --json`."""
        paths = list(self.problems)
        return {
            "fmu": paths[0] if len(paths) == 1 else paths,
            "problems": [{"fmu": path, **vars(p)} for path, found in self.problems.items() for p in found],
        }

    def to_dataframe(self) -> Any:
        """One row for each problem (pandas.DataFrame)."""
        import pandas as pd  # noqa: PLC0415 - imported on use

        return pd.DataFrame(self.to_dict()["problems"], columns=list(COLUMNS))


def check(
    fmus: str | Path | Sequence[str | Path], *, time_limit: float = Limits.time, memory: float = Limits.memory / 2**20
) -> CheckReport:
    """Check one FMU or several: archive, model description and binary against the FMI standard, and short trials of
    the running FMU, each in a process of its own.

    fmus is a path or several. time_limit [s] and memory [MiB] hold for each trial; calls that the standard forbids to
    importers get 15 % of the time. Raises InputError for a file that does not exist and for limits that are not
    positive.

        >>> path = mf.build("damper:7.5", "out").path
        >>> found = mf.check(path)
        >>> found.clean, [problem for problem in found[path] if problem.severity == "error"]
        (True, [])
        >>> found.to_dict()["fmu"] == str(path), list(found.to_dataframe().columns[:3])
        (True, ['fmu', 'check', 'severity'])
    """
    paths = [Path(path) for path in ([fmus] if isinstance(fmus, str | Path) else fmus)]
    for path in paths:
        if path.is_dir():
            raise InputError(f"{path} is a folder; give paths of .fmu archives, all in the folder as {path}/*.fmu")
        if not path.is_file():
            raise InputError(f"there is no file {path}; give the path of an .fmu archive")
    for name, value, unit in (("time_limit", time_limit, "s"), ("memory", memory, "MiB")):
        if not 0 < value < math.inf:
            raise InputError(f"{name} is {value:g} {unit}; give a positive number")
    limits = Limits(time=time_limit, memory=round(memory * 2**20))
    return CheckReport({str(path): problems_of(path, limits) for path in track(paths, "checking", len(paths))})


def _count(found: Sequence[Problem]) -> str:
    counts = {word: sum(problem.severity == word for problem in found) for word in SEVERITIES}
    texts = [f"{count} {word}{'s' * (count > 1)}" for word, count in counts.items() if count]
    return ", ".join(texts if counts["error"] else ["no error", *texts])
