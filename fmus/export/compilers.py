"""C compilers and platforms: compiles source files to the shared library of one platform.

The host's compiler is the first found of $CC, cc, gcc and clang, else zig. Every other platform is compiled with zig
(package ziglang), which needs no network and no further tools.

A compiled file is cached under its preprocessed text and the compiler's options: components with the same equations and
other values are linked, not compiled again.
"""

import importlib.metadata
import os
import platform
import shlex
import shutil
import struct
import subprocess
import sys
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cache
from importlib.util import find_spec
from pathlib import Path

from fmus.export.cache import cache_folder, content_key
from fmus.support.errors import InputError, MissingToolError, unknown
from fmus.support.files import write_atomically

# -s: symbol tables contain the names of temporary files, which would make builds differ
FLAGS = ("-std=c99", "-O3", "-g0", "-s", "-Wall", "-Wextra", "-Wpedantic", "-ffp-contract=off", "-fvisibility=hidden",
         "-shared",
         "-ffunction-sections")  # fmt: skip
LINKING = ("-shared", "-s")  # the flags that belong to the linker
# A library for a host of WebAssembly: no program, no imports, memory and callbacks that the host can use.
WASM_LINKING = ("-s", "-mexec-model=reactor", "-nostartfiles", "-Wl,--no-entry", "-Wl,--gc-sections",
                "-Wl,--export-dynamic", "-Wl,--export=malloc", "-Wl,--export=free",
                "-Wl,--export-table", "-Wl,--growable-table")  # fmt: skip


@dataclass(frozen=True)
class Platform:
    """A platform for which FMUs are built: its folders in an archive of FMI 2 and FMI 3, its zig targets."""

    name: str
    folder: str
    tuples: tuple[str, ...]
    suffix: str
    targets: tuple[str, ...]


PLATFORMS = {
    p.name: p
    for p in (
        Platform("linux-x86_64", "linux64", ("x86_64-linux",), ".so", ("x86_64-linux-gnu.2.17",)),
        Platform("linux-arm64", "linux64", ("aarch64-linux",), ".so", ("aarch64-linux-gnu.2.17",)),
        Platform("windows-x86_64", "win64", ("x86_64-windows",), ".dll", ("x86_64-windows-gnu",)),
        Platform(
            "macos",
            "darwin64",
            ("x86_64-darwin", "aarch64-darwin"),
            ".dylib",
            ("x86_64-macos.11.0", "aarch64-macos.11.0"),
        ),
        # zig's C library for WASI has functions without imports for all that the runtime calls
        Platform("wasm", "wasm32", ("wasm32-unknown-unknown",), ".wasm", ("wasm32-wasi",)),
    )
}


def host() -> Platform:
    """The platform of this machine. Raises InputError when it is none of the known ones."""
    arm = platform.machine().lower() in ("arm64", "aarch64")
    name = {"Linux": "linux-arm64" if arm else "linux-x86_64", "Windows": "windows-x86_64", "Darwin": "macos"}.get(
        platform.system()
    )
    if name is None:
        raise unknown("platform", platform.system(), PLATFORMS)
    return PLATFORMS[name]


def chosen(platforms: str) -> list[Platform]:
    """The platforms that `host`, `all` or a comma list of names stands for. Raises InputError for another name."""
    if platforms == "host":
        return [host()]
    names = list(PLATFORMS) if platforms == "all" else [n.strip() for n in platforms.split(",")]
    for name in names:
        if name not in PLATFORMS:
            raise unknown("platform", name, [*PLATFORMS, "host", "all"])
    return [p for n, p in PLATFORMS.items() if n in names]


def host_compiler() -> tuple[str, ...] | None:
    """The command of the host's own C compiler; None where none is installed. Raises InputError for a wrong $CC."""
    given = os.environ.get("CC")
    if given:
        command = tuple(shlex.split(given))
        if shutil.which(command[0]) is None:
            raise InputError(f"CC = {given!r} is not a program on this machine; unset CC or set it to a C compiler")
        return command
    found = next((name for name in ("cc", "gcc", "clang") if shutil.which(name)), None)
    return (found,) if found else None


def zig() -> tuple[str, ...]:
    """The command of zig's C compiler. Raises MissingToolError when ziglang is not installed."""
    if find_spec("ziglang") is None:
        raise MissingToolError(
            "no C compiler for this: install gcc or clang (for this machine only), or `pip install motofmi[platforms]`"
        )
    return (sys.executable, "-m", "ziglang", "cc")


def commands(wanted: Platform, native: bool) -> list[tuple[str, ...]]:
    """One compiler command for each architecture of the platform; `native` prefers the host's own compiler."""
    own = host_compiler() if native and wanted == host() else None
    if own is not None:
        return [own]
    return [(*zig(), "-target", target) for target in wanted.targets]


@cache
def version(command: Sequence[str]) -> str:
    """The first line of the compiler's `--version`; of zig the version of its package, which is faster."""
    if "ziglang" in command:
        return f"zig {importlib.metadata.version('ziglang')}"
    return subprocess.run([*command, "--version"], capture_output=True, text=True, check=False).stdout.partition("\n")[
        0
    ]


def compile_library(wanted: Platform, native: bool, folder: Path, files: Sequence[str], name: str) -> list[bytes]:
    """The shared libraries of a platform, one for each of its architectures.

    `files` are in `folder` and `name` is the file name without suffix. Raises MissingToolError when there is
    no compiler or when it fails, with its first error.
    """
    return [_compile(command, wanted, folder, files, f"{name}{wanted.suffix}") for command in commands(wanted, native)]


def _compile(command: Sequence[str], wanted: Platform, folder: Path, files: Sequence[str], library: str) -> bytes:
    compiling, linking = [f for f in FLAGS if f not in LINKING], [*LINKING]
    if wanted.suffix == ".wasm":  # 15 % smaller and 10 to 25 % slower than -O3, at 6 to 19 million steps a second
        compiling, linking = [*compiling, "-Os"], [*WASM_LINKING]
    elif wanted.suffix != ".dll":
        compiling += ["-fPIC", "-fno-unwind-tables", "-fno-asynchronous-unwind-tables"]  # no exception passes through C
    if wanted.suffix == ".dylib":
        linking += [f"-Wl,-install_name,@rpath/{library}", "-Wl,-dead_strip"]
    elif wanted.suffix != ".wasm":
        linking += ["-Wl,--gc-sections"]  # functions that were inlined everywhere
    objects = [str(_object(command, compiling, wanted, folder, file)) for file in files]
    # -Os selects the small form of what zig adds to a library
    _run(command, [*linking, "-Os", "-o", library, *objects, "-lm"], wanted, folder)
    return (folder / library).read_bytes()


def _object(command: Sequence[str], options: Sequence[str], wanted: Platform, folder: Path, file: str) -> Path:
    """The compiled file in the cache."""
    text = _run(command, [*options, "-E", file], wanted, folder)
    key = content_key({file: text.encode()}, *command, *options, version(tuple(command)))
    path = (cache_folder() / f"{Path(file).stem}-{key[:32]}.o").absolute()
    if not path.is_file():
        compiling = [*options, "-c", file, "-o"]
        write_atomically(path, lambda beside: _run(command, [*compiling, str(beside)], wanted, folder), cache=True)
    return path


def _run(command: Sequence[str], options: Sequence[str], wanted: Platform, folder: Path) -> str:
    """What a compiler prints. Raises MissingToolError where it fails."""
    done = subprocess.run([*command, *options], cwd=folder, capture_output=True, text=True, check=False)
    if done.returncode:
        error = next(
            (line for line in done.stderr.splitlines() if "error" in line), done.stderr.strip() or "no message"
        )
        raise MissingToolError(f"{' '.join(command)} cannot compile for {wanted.name}: {error}")
    return done.stdout


def universal(libraries: Sequence[bytes]) -> bytes:
    """One fat Mach-O file of 64-bit Mach-O files for different processors (FMI 2 has one folder for macOS).

    The format is Apple's mach-o/fat.h: big-endian header, then (cputype, cpusubtype, offset, size, align).
    """
    alignment = 14
    offset = 1 << alignment
    header, body = struct.pack(">II", 0xCAFEBABE, len(libraries)), b""
    for library in libraries:
        cpu, subtype = struct.unpack("<II", library[4:12])
        start = offset + len(body)
        header += struct.pack(">5I", cpu, subtype, start, len(library), alignment)
        body += library + bytes(-len(library) % offset)
    return header + bytes(offset - len(header)) + body
