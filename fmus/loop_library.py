"""The loop over the steps as a small C library (fmus/master/*.c), compiled once for a machine and kept in the cache."""

import tempfile
from ctypes import CDLL, Structure, c_double, c_size_t, c_void_p
from functools import cache
from importlib.resources import files
from pathlib import Path

from fmus import compilers
from fmus.build import cache_folder, content_key
from fmus.files import write_beside

SOURCES = ("master.c", "unit.c", "unit.h")  # the first one includes the others


class InputPath(Structure):
    """How the inputs of an FMU of FMI 3.0 move within a step: see unit.h."""

    _fields_ = [("instance", c_void_p), ("set", c_void_p), ("references", c_void_p), ("n", c_size_t), ("coefficients", c_void_p), ("begin", c_double), ("step", c_double)]


@cache
def library() -> CDLL:
    """The compiled loop. Raises MissingToolError when there is no C compiler."""
    sources = {name: files("fmus").joinpath("master", name).read_bytes() for name in SOURCES}
    host = compilers.host()
    command = compilers.commands(host, native=True)[0]
    path = cache_folder() / f"master-{content_key(sources, ' '.join(command), compilers.version(command))[:32]}{host.suffix}"
    if not path.is_file():
        with tempfile.TemporaryDirectory() as folder:
            for name, text in sources.items():
                Path(folder, name).write_bytes(text)
            binary = compilers.compile_library(host, True, Path(folder), SOURCES[:1], "master")[0]
        write_beside(path, lambda beside: beside.write_bytes(binary))
    found = CDLL(str(path))
    found.master_run.restype = c_size_t
    found.master_run.argtypes = [c_void_p, c_size_t, c_void_p, c_void_p, c_size_t, c_void_p]
    return found
