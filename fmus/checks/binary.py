"""The shared libraries: named after the model identifier, for some platform, without Python, with
the C runtime alone."""

import re
from pathlib import Path

from fmus.checks.checked_fmu import CheckedFmu
from fmus.checks.problem import Problem

STAGE = "binary"
SUFFIXES = (".so", ".dll", ".dylib", ".wasm")
PYTHON = re.compile(rb"\b(Py_Initialize\w*|PyObject_\w+|PyGILState_\w+|libpython[\w.]*)")
NEEDED = re.compile(rb"\0(lib[\w+-]+\.so[.\d]*)(?=\0)")
C_RUNTIME = {b"libc", b"libm", b"libdl", b"libpthread", b"librt", b"libgcc_s", b"libstdc++"}


def check(fmu: CheckedFmu) -> list[Problem]:
    """Problems of the libraries in the unpacked folder of an archive."""
    kinds = [e for e in fmu.root if e.tag in ("ModelExchange", "CoSimulation", "ScheduledExecution")]
    python = any(e.get("needsExecutionTool") == "true" for e in kinds)
    folders = sorted(p for p in (fmu.folder / "binaries").glob("*") if p.is_dir() and any(p.iterdir()))
    if not folders:
        if (fmu.folder / "sources").is_dir():
            return [Problem("binary", "warning", "no binary, only source code", "binaries")]
        return [Problem("binary", "error", "no binary for any platform, and no source code", "binaries")]
    found = []
    for place in folders:
        libraries = {p.stem: p for p in place.iterdir() if p.is_file() and p.suffix in SUFFIXES}
        for identifier in sorted({e.get("modelIdentifier") or "" for e in kinds}):
            if identifier not in libraries:
                have = ", ".join(sorted(libraries)) or "nothing"
                found.append(
                    Problem(
                        "identifier",
                        "error",
                        f"no library for modelIdentifier {identifier!r} (there is: {have})",
                        f"binaries/{place.name}",
                    )
                )
        for library in libraries.values():
            found += _library(library, python)
    return found


def _library(path: Path, python: bool) -> list[Problem]:
    where, data = f"binaries/{path.parent.name}/{path.name}", path.read_bytes()
    found = []
    symbol = PYTHON.search(data)
    if symbol:
        severity = "warning" if python else "error"
        found.append(
            Problem(
                "python", severity, f"needs the right Python in the importer's process ({symbol[1].decode()})", where
            )
        )
    foreign = sorted(
        {n.decode() for n in NEEDED.findall(data) if n.split(b".so")[0] not in C_RUNTIME}
        if data[:4] == b"\x7fELF"
        else ()
    )
    if foreign and not symbol:
        found.append(Problem("libraries", "warning", f"needs {', '.join(foreign)} besides the C runtime", where))
    return found
