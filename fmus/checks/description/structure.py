"""The model structure: entries that name variables, complete lists of outputs, derivatives and initial unknowns."""

from collections import Counter
from collections.abc import Iterable

from fmus.checks.checked_fmu import CheckedFmu
from fmus.checks.model import Unknown, Variable, whole
from fmus.checks.problem import Problem

STAGE = "description"
SECTION = ("2.2.8", "2.4.8")
SHOWN = 5  # names that a message lists


def check(fmu: CheckedFmu) -> list[Problem]:
    """Entries and lists that are wrong."""
    found = [problem for entries in fmu.model.unknowns.values() for problem in _entries(fmu, entries)]
    if any(problem.severity == "error" for problem in found):
        return found  # lists with wrong entries are not compared
    return [*_outputs(fmu), *_derivatives(fmu), *_initial(fmu)]


def _where(unknown: Unknown) -> str:
    return f"ModelStructure, {unknown.where} {unknown.number}"


def _entries(fmu: CheckedFmu, entries: list[Unknown]) -> Iterable[Problem]:
    """Every index (FMI 2) or value reference (FMI 3) names a variable, once; dependencies have as many kinds."""
    count = len(fmu.model.variables)
    meaning = f"variable (valid: 1 to {count})" if fmu.version == "2" else "value reference of a variable"
    repeated = {number for number, times in Counter(u.number for u in entries).items() if times > 1}
    for unknown in entries:
        unnamed = [d for d in unknown.dependencies or [] if fmu.model.find(d) is None]
        for number in [unknown.number] * (unknown.variable is None) + unnamed:
            yield fmu.error("structure", f"{number} is no {meaning}", _where(unknown), *SECTION)
        if unknown.number in repeated:
            repeated.discard(unknown.number)
            yield fmu.error("structure", f"{unknown.number} is listed more than once", _where(unknown), *SECTION)
        if unknown.kinds is not None and len(unknown.kinds) != len(unknown.dependencies or ()):
            has = "no dependencies" if unknown.dependencies is None else f"{len(unknown.dependencies)} dependencies"
            yield fmu.error(
                "structure", f"has {len(unknown.kinds)} kinds of dependencies but {has}", _where(unknown), *SECTION
            )


def _names(variables: Iterable[Variable]) -> str:
    names = [v.name for v in variables]
    return ", ".join(names[:SHOWN]) + (f" and {len(names) - SHOWN} more" if len(names) > SHOWN else "")


def _compare(
    fmu: CheckedFmu, what: str, expected: list[Variable], listed: list[Variable], optional: list[Variable]
) -> Iterable[Problem]:
    present, wanted, admitted = {id(v) for v in listed}, {id(v) for v in expected}, {id(v) for v in optional}
    missing = [v for v in expected if id(v) not in present]
    extra = [v for v in listed if id(v) not in wanted | admitted]
    if missing:
        yield fmu.error("structure", f"{what} does not list {_names(missing)}", "ModelStructure", *SECTION)
    if extra:
        yield fmu.error("structure", f"{what} lists {_names(extra)}, which it may not", "ModelStructure", *SECTION)


def _outputs(fmu: CheckedFmu) -> Iterable[Problem]:
    expected = [v for v in fmu.model.variables if v.causality == "output"]
    listed = [u.variable for u in fmu.model.outputs if u.variable is not None]
    return _compare(fmu, "Outputs" if fmu.version == "2" else "Output", expected, listed, [])


def _derivatives(fmu: CheckedFmu) -> Iterable[Problem]:
    for unknown in fmu.model.derivatives:
        rate = unknown.variable
        if rate is None:
            continue
        state = fmu.model.find(rate.derivative)
        if rate.derivative is None:
            yield fmu.error(
                "structure",
                f"{rate.name} is a derivative of a state, but has no attribute derivative",
                _where(unknown),
                *SECTION,
            )
        elif state is None:
            yield fmu.error(
                "structure", f"the attribute derivative of {rate.name} names no variable", rate.name, "2.2.7", "2.4.7.5"
            )
        elif not state.real or state.variability != "continuous":
            yield fmu.error(
                "structure", f"{state.name} is a state, but no continuous real variable", state.name, *SECTION
            )
        elif state.causality not in ("local", "output"):
            yield fmu.error(
                "structure", f"{state.name} is a state with causality {state.causality}", state.name, "2.2.7", "2.4.7.4"
            )


def _initial(fmu: CheckedFmu) -> Iterable[Problem]:
    model = fmu.model
    solved = [
        v
        for v in (*model.states, *(u.variable for u in model.derivatives))
        if v is not None and v.initial in ("approx", "calculated")
    ]
    expected = [
        v
        for v in model.variables
        if (v.causality == "output" and v.initial in ("approx", "calculated") and not v.clocks and v.type != "Clock")
        or v.causality == "calculatedParameter"
    ]
    known = {id(v) for v in expected}
    expected += [v for v in {id(v): v for v in solved}.values() if id(v) not in known]
    optional = [v for v in model.variables if v.clocks]  # clocked variables may be initialised
    listed = [u.variable for u in model.initial_unknowns if u.variable is not None]
    # "This list consists of all variables" (FMI 2.0.4, 2.2.8; FMI 3.0, 2.4.8): an absent list violates the standard
    # too.
    yield from _compare(fmu, "InitialUnknowns" if fmu.version == "2" else "InitialUnknown", expected, listed, optional)
    if fmu.version == "2":
        numbers = [whole(u.number) or 0 for u in model.initial_unknowns]
        if numbers != sorted(numbers):
            message = "InitialUnknowns is not in the order of the indices"
            yield fmu.error("structure", message, "ModelStructure", *SECTION)
