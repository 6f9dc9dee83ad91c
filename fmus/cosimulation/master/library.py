"""The loop over the steps as a small C library (fmus/cosimulation/master/*.c), compiled once for a machine
and kept in the cache.

Its structures and functions are declared once, in structures.h: the compiler includes that file and cffi parses it.
"""

import tempfile
from functools import cache
from importlib.resources import files
from pathlib import Path
from typing import Any

import numpy as np
from cffi import FFI

from fmus.export import compilers
from fmus.export.cache import cache_folder, content_key
from fmus.support.files import write_atomically

SOURCES = ("master.c", "subsystem.c", "structures.h")  # the first one includes the others


def source(name: str) -> bytes:
    """The text of one of SOURCES."""
    return files("fmus.cosimulation.master").joinpath(name).read_bytes()


@cache
def structures() -> FFI:
    """The structures, constants and functions of structures.h."""
    ffi = FFI()
    ffi.cdef(source("structures.h").decode().replace("EXPORT ", ""))
    return ffi


@cache
def library() -> Any:
    """The compiled loop, with the functions of structures.h. Raises MissingToolError when there is no C compiler."""
    sources = {name: source(name) for name in SOURCES}
    host = compilers.host()
    command = compilers.commands(host, native=True)[0]
    path = (
        cache_folder()
        / f"master-{content_key(sources, ' '.join(command), compilers.version(command))[:32]}{host.suffix}"
    )
    if not path.is_file():
        with tempfile.TemporaryDirectory() as folder:
            for name, text in sources.items():
                Path(folder, name).write_bytes(text)
            binary = compilers.compile_library(host, True, Path(folder), SOURCES[:1], "master")[0]
        write_atomically(path, lambda beside: beside.write_bytes(binary), cache=True)
    return structures().dlopen(str(path))


def array(kind: str, values: np.ndarray) -> Any:
    """The memory of a contiguous array as a C array of `kind`, which keeps the array alive."""
    return structures().from_buffer(f"{kind}[]", values)


def pointer(kind: str, address: int | None) -> Any:
    """An address as a pointer to `kind`."""
    return structures().cast(f"{kind} *", address or 0)


def address(cdata: Any) -> int:
    """The address of a structure or function."""
    return int(structures().cast("uintptr_t", cdata))
