"""The library loads, has the functions of its kind, and makes an instance."""

from collections.abc import Iterator

from fmus.checks.problem import Problem
from fmus.checks.sections import section
from fmus.checks.trial import Trial

PLACE, SEVERITY = 0, "error"
KINDS = ("ModelExchange", "CoSimulation", "ScheduledExecution")
VERSIONS = {"2": ("2.0",), "3": ("3.0",)}


def applies(trial: Trial) -> bool:
    return True


def run(trial: Trial) -> Iterator[Problem]:
    version = trial.model.version
    missing = trial.library.missing(trial.kind)
    if missing:
        yield trial.error(
            f"the library does not have {', '.join(missing[:5])}"
            + (f" and {len(missing) - 5} more" * (len(missing) > 5)),
            section=section(version, "2.1.1", "2.2.2"),
        )
    if f"fmi{version}GetVersion" not in missing:
        said = trial.library(f"fmi{version}GetVersion")
        text = "" if said == trial.library.ffi.NULL else trial.library.ffi.string(said).decode("utf-8", "replace")
        if not text.startswith(VERSIONS[version]):
            yield trial.error(
                f"fmi{version}GetVersion returns {text!r}, not {VERSIONS[version][0]!r}",
                section=section(version, "2.1.4", "2.2.5"),
            )
    if version == "2" and "fmi2GetTypesPlatform" not in missing:
        said = trial.library("fmi2GetTypesPlatform")
        text = "" if said == trial.library.ffi.NULL else trial.library.ffi.string(said).decode("utf-8", "replace")
        if text != "default":
            yield trial.error(
                f"fmi2GetTypesPlatform returns {text!r}, not 'default'", section=section(version, "2.1.4", "")
            )
    trial.instance()
