"""The shared library of an FMU: its functions as the headers of the standard declare them, and what it logs.

fmpy brings the headers; cffi parses them, so that no prototype is written twice.
"""

import ctypes
import os
import re
from functools import cache
from pathlib import Path
from typing import Any

import fmpy
from cffi import FFI
from fmpy.logging import addLoggerProxy

from fmus.checks.current_call import CurrentCall

# For types without a name of the standard: an interface with all declarations takes 0.05 s to read the name of a type.
PLAIN = FFI()
STATUS = {"2": ("fmi2OK", "fmi2Warning", "fmi2Discard", "fmi2Error", "fmi2Fatal", "fmi2Pending"),
          "3": ("fmi3OK", "fmi3Warning", "fmi3Discard", "fmi3Error", "fmi3Fatal")}  # fmt: skip
HEADERS = {"2": ("fmi2TypesPlatform.h", "fmi2FunctionTypes.h"), "3": ("fmi3PlatformTypes.h", "fmi3FunctionTypes.h")}
LOGGERS = {
    "2": "void(void *, const char *, int, const char *, const char *)",
    "3": "void(void *, int, const char *, const char *)",
}
# Functions that an FMU of one kind alone needs: all others are required of every kind.
ONLY = {
    "ModelExchange": re.compile(r"EnterContinuousTimeMode|CompletedIntegratorStep|SetTime|ContinuousState|"
                                r"EventIndicators|"
                                r"GetDerivatives|NewDiscreteStates|fmi2EnterEventMode|InstantiateModelExchange"),
    "CoSimulation": re.compile(r"DoStep|CancelStep|Status$|InputDerivatives|OutputDerivatives|EnterStepMode|"
                               r"InstantiateCoSimulation"),
    "ScheduledExecution": re.compile(r"ActivateModelPartition|InstantiateScheduledExecution"),
}  # fmt: skip


@cache
def declarations(version: str) -> str:
    """The C declarations of the headers of FMI 2 or 3, without the preprocessor's lines."""
    folder = Path(fmpy.__file__).parent / "c-code"
    text = "\n".join((folder / name).read_text("utf-8") for name in HEADERS[version])
    text = re.sub(r"/\*.*?\*/|//[^\n]*", "", text, flags=re.DOTALL)
    text = re.sub(r"#ifdef __cplusplus.*?#endif", "", text, flags=re.DOTALL)
    return re.sub(r"^\s*#.*$", "", text, flags=re.MULTILINE)


@cache
def functions(version: str) -> tuple[str, ...]:
    """The names of the functions of FMI 2 or 3."""
    return tuple(re.findall(r"\b(fmi\d\w+)TYPE\s*\(", declarations(version)))


@cache
def interface(version: str) -> tuple[FFI, dict[str, Any]]:
    """The declarations of FMI 2 or 3, parsed, and the type of each function."""
    ffi = FFI()
    ffi.cdef(declarations(version) + "\n".join(f"{name}TYPE {name};" for name in functions(version)))
    members = "".join(f"{name}TYPE *{name};" for name in functions(version))
    ffi.cdef(f"struct functions {{ {members} }};")
    return ffi, {name: field.type for name, field in ffi.typeof("struct functions").fields}


def required(version: str, kind: str) -> list[str]:
    """The functions that the library of an FMU of one kind must have."""
    others = [pattern for other, pattern in ONLY.items() if other != kind]
    return [name for name in functions(version) if not any(pattern.search(name) for pattern in others)]


class FmiLibrary:
    """The loaded library of one model identifier. Raises OSError with the loader's reason when it cannot be loaded."""

    def __init__(self, version: str, path: Path, current: CurrentCall):
        self.version, self.current, self.messages = version, current, []  # type: ignore[var-annotated]
        self.ffi, self.types = interface(version)
        current.enter("loading the library")
        if os.name == "nt":
            os.add_dll_directory(str(path.parent))  # type: ignore[attr-defined]
        self._lib = self.ffi.dlopen(str(path), self.ffi.RTLD_NOW)
        current.leave()
        self._logger = PLAIN.callback(LOGGERS[version], self._log2 if version == "2" else self._log3)
        self.callbacks = self._callbacks() if version == "2" else None
        if version == "3":
            self.logger = PLAIN.cast(self.types["fmi3InstantiateModelExchange"].args[6], self._logger)

    def missing(self, kind: str) -> list[str]:
        """Functions that an FMU of this kind must have and this library has not."""
        return [name for name in required(self.version, kind) if not self.has(name)]

    def has(self, name: str) -> bool:
        try:
            return getattr(self._lib, name) is not None
        except AttributeError:
            return False

    def __call__(self, name: str, *arguments: Any) -> Any:
        """Call a function; its messages are in `messages` afterwards."""
        self.messages.clear()
        function = getattr(self._lib, name)
        self.current.enter(name)
        result = function(*arguments)
        self.current.leave()
        return result

    def status(self, code: int) -> str:
        """The name of a status, or the number of one that the standard does not have."""
        names = STATUS[self.version]
        return names[code] if 0 <= code < len(names) else f"status {code}"

    # Callbacks ---------------------------------------------------------------------------------------------

    def _callbacks(self) -> Any:
        # An FMU formats its messages with arguments in printf's style; fmpy's proxy does that in C.
        kind = self.types["fmi2Instantiate"].args[4]
        made, fields = PLAIN.new(kind), dict(kind.item.fields)
        memory = (ctypes.cast(f, ctypes.c_void_p).value for f in (fmpy.calloc, fmpy.free))
        addresses = (PLAIN.cast("uintptr_t", self._logger), *memory)
        for name, address in zip(("logger", "allocateMemory", "freeMemory"), addresses, strict=True):
            setattr(made, name, PLAIN.cast(fields[name].type, address))
        addLoggerProxy(ctypes.c_void_p(int(PLAIN.cast("uintptr_t", made))))
        return made

    def _log2(self, environment: Any, instance: Any, status: int, category: Any, message: Any) -> None:
        self._log(message)

    def _log3(self, environment: Any, status: int, category: Any, message: Any) -> None:
        self._log(message)

    def _log(self, message: Any) -> None:
        if message != self.ffi.NULL and len(self.messages) < 100:
            text = self.ffi.string(message, 2000).decode("utf-8", "replace").strip()
            self.messages.append(text)
            self.current.log(text)
