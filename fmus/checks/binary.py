"""The shared libraries: named after the model identifier, for some platform, without Python, with the C runtime alone."""

import platform
import re
from pathlib import Path
from xml.etree import ElementTree as Xml

from fmus.checks.problem import Problem

PYTHON = re.compile(rb"\b(Py_Initialize\w*|PyObject_\w+|PyGILState_\w+|libpython[\w.]*)")
NEEDED = re.compile(rb"\0(lib[\w+-]+\.so[.\d]*)(?=\0)")
PROCESSORS = {0x3E: "x86_64", 0xB7: "aarch64"}  # e_machine of an ELF header
C_RUNTIME = {b"libc", b"libm", b"libdl", b"libpthread", b"librt", b"libgcc_s", b"libstdc++"}


def host_folder(version: str) -> str:
    """The folder of this machine's binaries in an archive of FMI 2 or 3."""
    arm = platform.machine().lower() in ("arm64", "aarch64")
    system = {"Windows": ("win64", "windows"), "Darwin": ("darwin64", "darwin")}.get(platform.system(), ("linux64", "linux"))
    return system[0] if version == "2" else f"{'aarch64' if arm else 'x86_64'}-{system[1]}"


def other_processor(folder: Path) -> str:
    """The processor that the Linux libraries in a folder are for, where it is not this machine's; else an empty text.

    FMI 2 has one folder for 64-bit Linux, whatever the processor.
    """
    for library in filter(Path.is_file, folder.glob("*.so")):
        header = library.read_bytes()[:20]
        if header[:4] == b"\x7fELF":
            processor = PROCESSORS.get(int.from_bytes(header[18:20], "little" if header[5] == 1 else "big"), "another processor")
            if processor != {"arm64": "aarch64", "amd64": "x86_64"}.get(platform.machine().lower(), platform.machine().lower()):
                return processor
    return ""


def problems(folder: Path) -> list[Problem]:
    """Problems of the libraries in the unpacked folder of an archive."""
    root = Xml.parse(folder / "modelDescription.xml").getroot()
    kinds = [e for e in root if e.tag in ("ModelExchange", "CoSimulation", "ScheduledExecution")]
    python = any(e.get("needsExecutionTool") == "true" for e in kinds)
    folders = sorted(p for p in (folder / "binaries").glob("*") if p.is_dir() and any(p.iterdir()))
    if not folders:
        if (folder / "sources").is_dir():
            return [Problem("binary", "warning", "no binary, only source code", "binaries")]
        return [Problem("binary", "error", "no binary for any platform, and no source code", "binaries")]
    found = []
    for place in folders:
        libraries = {p.stem: p for p in place.iterdir() if p.is_file() and p.suffix in (".so", ".dll", ".dylib")}
        for identifier in sorted({e.get("modelIdentifier") or "" for e in kinds}):
            if identifier not in libraries:
                have = ", ".join(sorted(libraries)) or "nothing"
                found.append(Problem("identifier", "error", f"no library for modelIdentifier {identifier!r} (there is: {have})", f"binaries/{place.name}"))
        for library in libraries.values():
            found += _library(library, python)
    return found


def _library(path: Path, python: bool) -> list[Problem]:
    where, data = f"binaries/{path.parent.name}/{path.name}", path.read_bytes()
    found = []
    symbol = PYTHON.search(data)
    if symbol:
        severity = "warning" if python else "error"
        found.append(Problem("python", severity, f"needs the right Python in the importer's process ({symbol[1].decode()})", where))
    foreign = sorted({n.decode() for n in NEEDED.findall(data) if n.split(b".so")[0] not in C_RUNTIME} if data[:4] == b"\x7fELF" else ())
    if foreign and not symbol:
        found.append(Problem("libraries", "warning", f"needs {', '.join(foreign)} besides the C runtime", where))
    return found
