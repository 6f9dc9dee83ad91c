"""A million random calls on every class and FMI version, out of order and with wrong arguments, under sanitisers.

The programs are tests/c/misuse2.c and misuse3.c, compiled together with the sources of the FMU.
"""

import os
import re
import subprocess
import tempfile
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cache
from pathlib import Path

from fmus.declaration.component import Component
from fmus.effects.library import applicable_effects
from fmus.export.build import COMPILED, source_contents
from fmus.export.compilers import host_compiler
from fmus.export.interface import Interface
from motofmi.workflows import components
from rider_fmu import riders
from vehicle_fmu import motorcycles

SOURCES = Path(__file__).parent.parent / "tests" / "c"
SANITISERS = ["-fsanitize=address,undefined", "-fno-sanitize-recover=all"]
CALLS = 1_000_000
EFFECTS = 4  # at once


@dataclass(frozen=True)
class Program:
    """A compiled misuse program and the data of the model that it needs."""

    path: str
    guid: str
    variables: int


@cache
def have_sanitisers() -> bool:
    """Whether the host's compiler can make and this machine can run a sanitised program."""
    with tempfile.TemporaryDirectory() as folder:
        Path(folder, "main.c").write_text("int main(void) { return 0; }")
        command = [*(host_compiler() or ("cc",)), *SANITISERS, "main.c", "-o", "main"]
        made = subprocess.run(command, cwd=folder, capture_output=True, check=False)
        return made.returncode == 0 and subprocess.run([str(Path(folder, "main"))], check=False).returncode == 0


def compiled_misuse(component: Component, fmi: int, folder: Path, sanitised: bool) -> Program:
    """The misuse program for a component, compiled in a folder."""
    interface = Interface(component)
    contents = source_contents(interface, fmi)
    for name, data in contents.items():
        if name.startswith("sources/"):
            (folder / name.removeprefix("sources/")).write_bytes(data)
    for name in (f"misuse{fmi}.c", "random_values.h"):
        (folder / name).write_bytes((SOURCES / name).read_bytes())
    options = ["-std=c99", "-g", "-O1", *(SANITISERS if sanitised else [])]
    subprocess.run(
        [*(host_compiler() or ("cc",)), *options, "-o", "misuse", f"misuse{fmi}.c", *COMPILED[fmi], "-lm"],
        cwd=folder,
        check=True,
    )
    guid = re.search(rb'(?:guid|instantiationToken)="([^"]*)"', contents["modelDescription.xml"])
    assert guid is not None
    return Program(str(folder / "misuse"), guid[1].decode(), len(interface.variables))


def calls_under(command: Sequence[str], program: Program, calls: int, seed: int) -> dict:
    """Runs the calls; the counts by status, and what a sanitiser or valgrind reported ("" when nothing)."""
    arguments = [*command, program.guid, str(program.variables), str(calls), str(seed)]
    done = subprocess.run(
        arguments, capture_output=True, text=True, check=False, env={**os.environ, "ASAN_OPTIONS": "detect_leaks=1"}
    )
    counts = {word: int(number) for word, number in re.findall(r"(ok|discard|error|steps) (\d+)", done.stdout)}
    report = done.stderr.strip() if done.returncode or done.stderr else ""
    return {**counts, "report": report or ("" if done.returncode == 0 else f"exit status {done.returncode}")}


def one_of_each() -> dict[str, Component]:
    """A component of every class, with values that ship where there are some, and the rider and a motorcycle with
    effects."""
    shipped = {type(c).__name__: c for c in map(components.component, components.every_name())}
    found = {title: shipped.get(title) or kind() for title, kind in components.COMPONENTS.items()}
    for component in (riders.load("mean_2011"), motorcycles.load("sharp_1971")):
        effects = applicable_effects(component, components.EFFECTS[type(component).__name__])
        found[f"{component.title} with effects"] = component.with_effects(*(e() for e in effects[:EFFECTS]))
    return found


def run(progress: Callable) -> dict:
    """Counts by component and FMI version."""
    components, found = one_of_each(), {}
    for name, fmi in progress([(name, fmi) for name in components for fmi in (2, 3)], "random calls under sanitisers"):
        with tempfile.TemporaryDirectory() as folder:
            program = compiled_misuse(components[name], fmi, Path(folder), sanitised=True)
            found[f"{name}, FMI {fmi}"] = calls_under([program.path], program, CALLS, seed=fmi)
    return {"calls": CALLS, "results": found, "clean": all(r["report"] == "" for r in found.values())}
