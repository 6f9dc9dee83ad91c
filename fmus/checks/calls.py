"""FMI calls of one instance: those with a status that is looked at, and those that read and set variables."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from fmus.checks.fmi_library import PLAIN, FmiLibrary
from fmus.checks.model import Model, Variable
from fmus.checks.sections import of_call

OK, WARNING, DISCARD, ERROR, FATAL = range(5)
DTYPES = {
    "Real": np.float64, "Integer": np.int32, "Enumeration": np.int32, "Float64": np.float64, "Float32": np.float32,
    "Boolean": np.int32,
    **{f"{sign}Int{bits}": np.dtype(f"{sign.lower()}int{bits}").type for sign in ("", "U") for bits in (8, 16, 32, 64)},
}  # fmt: skip
CANARIES = 16  # numbers behind a buffer that a call must not change
UNTOUCHED = float.fromhex("0x1.23456789abcdep-1000")  # a number that no call writes by chance


@dataclass
class FmiCall:
    """A call that was made: its name, the name of its status and what the FMU logged."""

    name: str
    status: str
    log: str

    @property
    def about(self) -> dict[str, str]:
        """The fields of a Problem that a call shows."""
        return {"call": self.name, "status": self.status, "log": self.log, "section": of_call(self.name)}


class CallFailedError(Exception):
    """A call did not succeed where the standard demands that it does."""

    def __init__(self, call: FmiCall, message: str):
        super().__init__(message)
        self.call, self.message = call, message


class EndedError(Exception):
    """The FMU has asked to end the simulation."""


class Calls:
    """What is common to all calls of an instance. time is the time that it has reached [s]; phase its state."""

    def __init__(self, library: FmiLibrary, model: Model):
        self.library, self.model, self.version = library, model, model.version
        self.ffi, self.prefix = PLAIN, f"fmi{model.version}"
        self.handle: Any = PLAIN.NULL
        self.time, self.phase, self.last = 0.0, "none", FmiCall("", "", "")
        self.warned: FmiCall | None = None  # the first call with the status warning

    # Calls -------------------------------------------------------------------------------------------------

    def _log(self) -> str:
        return " | ".join(self.library.messages)

    def attempt(self, name: str, *arguments: Any) -> int:
        """Call a function, named without prefix, whatever its status."""
        status = int(self.library(self.prefix + name, self.handle, *arguments))
        self.last = FmiCall(self.prefix + name, self.library.status(status), self._log())
        if status == ERROR:
            self.phase = "error"
        elif status == FATAL:
            self.phase = "fatal"
        elif status == WARNING and self.warned is None:
            self.warned = self.last
        return status

    def call(self, name: str, *arguments: Any) -> int:
        """Call a function that has to succeed. Raises CallFailedError."""
        status = self.attempt(name, *arguments)
        if status not in (OK, WARNING):
            raise CallFailedError(self.last, f"{self.last.name} returns {self.last.status} at {self.time:g} s")
        return status

    def filled(self, name: str, count: int, what: str) -> np.ndarray:
        """An array (count,) that a call fills. Raises CallFailedError if the call writes fewer or more numbers."""
        buffer = np.full(count + CANARIES, UNTOUCHED)
        if count or self.version == "2":
            self.call(name, self.ffi.from_buffer("double[]", buffer), count)
        written = int(np.count_nonzero(buffer[:count] != UNTOUCHED))
        if (buffer[count:] != UNTOUCHED).any():
            raise CallFailedError(
                self.last, f"{self.last.name} writes more than {count} {what}, the number in the description"
            )
        if written < count:
            raise CallFailedError(
                self.last, f"{self.last.name} writes {written} of the {count} {what} of the description"
            )
        return buffer[:count]

    # Values ------------------------------------------------------------------------------------------------

    def get(self, variables: Sequence[Variable]) -> np.ndarray:
        """Values (n,) of numeric variables of one type, arrays element by element. Raises CallFailedError."""
        if not variables:
            return np.zeros(0)
        kind = variables[0].type
        count = sum(self.model.size(v) for v in variables)
        values = np.zeros(count, self._dtype(kind))
        self.call(f"Get{self._type(kind)}", self.references(variables), len(variables),
                  *self._array(kind, values), *self.count(count))  # fmt: skip
        return values

    def set(self, variables: Sequence[Variable], values: Sequence[float] | np.ndarray, must: bool = True) -> int:
        """Set numeric variables of one type; the status. Raises CallFailedError if it must succeed and does not."""
        kind = variables[0].type
        given = np.array(values, self._dtype(kind))
        return (self.call if must else self.attempt)(
            f"Set{self._type(kind)}", self.references(variables), len(variables), *self._array(kind, given),
            *self.count(len(given)),
        )  # fmt: skip

    def set_texts(self, variables: Sequence[Variable], texts: Sequence[bytes]) -> None:
        """Set string variables, arrays element by element. Raises CallFailedError."""
        keep = [self.ffi.new("char[]", text) for text in texts]
        values = self.ffi.new("const char *[]", keep)
        self.call("SetString", self.references(variables), len(variables), values, *self.count(len(texts)))

    def set_binaries(self, variables: Sequence[Variable], data: Sequence[bytes]) -> None:
        """Set binary variables, arrays element by element. Raises CallFailedError."""
        keep = [self.ffi.new("uint8_t[]", one or b"\0") for one in data]
        sizes, values = self.ffi.new("size_t[]", [len(one) for one in data]), self.ffi.new("const uint8_t *[]", keep)
        self.call("SetBinary", self.references(variables), len(variables), sizes, values, len(data))

    def texts(self, variables: Sequence[Variable]) -> list[bytes]:
        """Values of string variables, arrays element by element. Raises CallFailedError, also for a null pointer."""
        count = sum(self.model.size(v) for v in variables)
        values = self.ffi.new("const char *[]", count)
        self.call("GetString", self.references(variables), len(variables), values, *self.count(count))
        self._no_null(variables, [value == self.ffi.NULL for value in values], "string")
        return [self.ffi.string(value) for value in values]

    def binaries(self, variables: Sequence[Variable]) -> list[bytes]:
        """Values of binary variables, arrays element by element. Raises CallFailedError."""
        count = sum(self.model.size(v) for v in variables)
        sizes, values = self.ffi.new("size_t[]", count), self.ffi.new("const uint8_t *[]", count)
        self.call("GetBinary", self.references(variables), len(variables), sizes, values, count)
        missing = [bool(size) and value == self.ffi.NULL for size, value in zip(sizes, values, strict=True)]
        self._no_null(variables, missing, "binary value")
        return [bytes(self.ffi.buffer(v, n)) if n else b"" for n, v in zip(sizes, values, strict=True)]

    def _no_null(self, variables: Sequence[Variable], missing: Sequence[bool], what: str) -> None:
        if any(missing):
            names = [v.name for v in variables for _ in range(self.model.size(v))]
            name = names[list(missing).index(True)]
            raise CallFailedError(self.last, f"{self.last.name} gives a null pointer for the {what} {name}")

    def floats(self, variables: Sequence[Variable]) -> np.ndarray:
        """Values (n,) of real variables of any precision, in their order."""
        if len({v.type for v in variables}) <= 1:
            return self.get(variables).astype(float)
        return np.concatenate([self.get([v]) for v in variables]).astype(float)

    def _type(self, kind: str) -> str:
        return ("Integer" if self.version == "2" else "Int64") if kind == "Enumeration" else kind

    def _dtype(self, kind: str) -> Any:
        if self.version == "3":
            return {"Enumeration": np.int64, "Boolean": np.bool_, "Clock": np.bool_}.get(kind, DTYPES.get(kind))
        return DTYPES[kind]

    def _array(self, kind: str, values: np.ndarray) -> tuple[Any, ...]:
        types = {"Real": "double", "Float64": "double", "Float32": "float", "Boolean": "bool", "Clock": "bool"}
        name = types.get(kind) or f"{values.dtype.name}_t"
        if self.version == "2" and kind != "Real":
            name = "int"
        return (self.ffi.from_buffer(f"{name}[]", values),)

    def count(self, count: int) -> tuple[int, ...]:
        return (count,) if self.version == "3" else ()

    def references(self, variables: Sequence[Variable]) -> Any:
        return self.ffi.new("unsigned int[]" if self.version == "2" else "uint32_t[]", [v.reference for v in variables])
