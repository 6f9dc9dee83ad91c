"""The shared libraries: named after the model identifier, complete, without Python, with the C runtime alone."""

import re
import struct
from pathlib import Path

from fmus.checks.checked_fmu import CheckedFmu
from fmus.checks.host import damaged_elf
from fmus.checks.problem import Problem

STAGE = "binary"
SECTION = ("2.3", "2.5.1.4")
PYTHON = re.compile(rb"\b(Py_Initialize\w*|PyObject_\w+|PyGILState_\w+|libpython[\w.]*)")
NEEDED = re.compile(rb"\0(lib[\w+-]+\.so[.\d]*)(?=\0)")
C_RUNTIME = {b"libc", b"libm", b"libdl", b"libpthread", b"librt", b"libgcc_s", b"libstdc++"}
SUFFIXES = (".so", ".dll", ".dylib", ".wasm")
BEGINNINGS = {
    ".so": (b"\x7fELF",),
    ".dll": (b"MZ",),
    ".wasm": (b"\0asm",),
    ".dylib": (b"\xcf\xfa\xed\xfe", b"\xca\xfe\xba\xbe", b"\xce\xfa\xed\xfe", b"\xca\xfe\xba\xbf"),
}


def check(fmu: CheckedFmu) -> list[Problem]:
    """Problems of the libraries in the unpacked folder of an archive."""
    kinds = [fmu.root.find(kind) for kind in fmu.model.kinds]
    python = any(e.get("needsExecutionTool") == "true" for e in kinds if e is not None)
    folders = sorted(p for p in (fmu.folder / "binaries").glob("*") if p.is_dir() and any(p.iterdir()))
    if not folders:
        if (fmu.folder / "sources").is_dir():
            return [fmu.warning("binary", "no binary, only source code", "binaries", *SECTION)]
        return [fmu.error("binary", "no binary for any platform, and no source code", "binaries", *SECTION)]
    found = []
    for place in folders:
        libraries = {p.stem: p for p in place.iterdir() if p.is_file() and p.suffix in SUFFIXES}
        for identifier in sorted({e.get("modelIdentifier") or "" for e in kinds if e is not None}):
            if identifier in libraries:
                found += _library(fmu, libraries[identifier], python)
            elif libraries:
                message = f"no library for modelIdentifier {identifier!r} (there is: {', '.join(sorted(libraries))})"
                found.append(fmu.error("identifier", message, f"binaries/{place.name}", *SECTION))
            elif not any(place.rglob("*.a")) and not any(place.rglob("*.lib")):
                found.append(
                    fmu.error(
                        "identifier",
                        f"no library for modelIdentifier {identifier!r} (there is: nothing)",
                        f"binaries/{place.name}",
                        *SECTION,
                    )
                )
    return found


def _library(fmu: CheckedFmu, path: Path, python: bool) -> list[Problem]:
    where, data = f"binaries/{path.parent.name}/{path.name}", path.read_bytes()
    if not data.startswith(BEGINNINGS[path.suffix]):
        what = (
            "an empty file"
            if not data
            else "text"
            if data[:200].isascii() and b"\0" not in data[:200]
            else "another file format"
        )
        return [fmu.error("binary", f"is no shared library but {what}", where, *SECTION)]
    if data[:4] == b"\x7fELF" and (what := damaged_elf(data)):
        return [fmu.error("binary", f"is no shared library but {what}", where, *SECTION)]
    if data[:5] == b"\x7fELF\x02" and _end_of_sections(data) > len(data):
        return [fmu.error("binary", f"is cut off after {len(data)} bytes", where, *SECTION)]
    found = []
    symbol = PYTHON.search(data)
    if symbol:
        severity = "warning" if python else "error"
        found.append(
            Problem(
                "python", severity, f"needs the right Python in the importer's process ({symbol[1].decode()})", where
            )
        )
    others = (
        {n.decode() for n in NEEDED.findall(data) if n.split(b".so")[0] not in C_RUNTIME}
        if data[:4] == b"\x7fELF"
        else set()
    )
    foreign = sorted(name for name in others if not (path.parent / name).is_file())
    if foreign and not symbol:
        found.append(fmu.warning("libraries", f"needs {', '.join(foreign)} besides the C runtime", where, *SECTION))
    return found


def _end_of_sections(data: bytes) -> int:
    """Where the table of sections of a 64-bit ELF file ends (System V ABI, ELF header)."""
    if len(data) < 64:
        return 64
    order = "<" if data[5] == 1 else ">"
    size, count = struct.unpack(f"{order}HH", data[58:62])
    return struct.unpack(f"{order}Q", data[40:48])[0] + size * count
