"""FMUs from components: reproducible to the byte, validated and run before they are stored, written atomically.

Archives are cached under a key of everything that determines them (`fmus.export.cache_key`), so that a second build is
a copy. The cache is the user's cache folder of the platform, or the folder in the environment variable MOTOFMI_CACHE.
"""

import hashlib
import io
import os
import tempfile
import uuid
import zipfile
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import cached_property
from importlib.resources import files
from pathlib import Path

import fmpy
import pythonfmu
from fmpy.validation import validate_fmu

from fmus.declaration.component import Component
from fmus.export import accompanying, compilers, model_description3, prebuilt, python_backend, wasm_component
from fmus.export.c_code import model_code, variables_code
from fmus.export.cache import cache_folder, content_key
from fmus.export.cache_key import cache_key
from fmus.export.compilers import Platform
from fmus.export.interface import Interface, identifier
from fmus.export.model_description2 import compiled, model_description
from fmus.support.errors import InputError, MissingToolError, unknown
from fmus.support.files import writable_folder, write_atomically

RUNTIME = (
    "call.c",
    "derivatives.c",
    "exact_step.c",
    "instance.c",
    "linear_algebra.c",
    "rosenbrock.c",
    "runtime.c",
    "snapshot.c",
    "step.c",
)
API = {
    2: ("fmi2_fmu.c", "fmi2.c"),
    3: ("fmi3_fmu.c", "fmi3.c", "fmi3_absent.c", "fmi3_step.c", "fmi3_host.h", "fmi3_wasm.c", "fmi3_component.c"),
}
# What is compiled. Only the second depends on the values of parameters.
COMPILED = {2: ("fmi2_fmu.c", "variables.c"), 3: ("fmi3_fmu.c", "variables.c")}
COMPILED_FOR_WASM = {2: COMPILED[2], 3: ("fmi3_wasm.c", "variables.c")}
HEADERS = ("call.h", "instance.h", "linear_algebra.h", "model.h", "snapshot.h", "step.h")
FMI_HEADERS = {  # supplied by the importer, so that an archive does not hold them (FMI 2.0.4, 2.3; FMI 3.0, 2.5.1)
    2: ("fmi2FunctionTypes.h", "fmi2Functions.h", "fmi2TypesPlatform.h"),
    3: ("fmi3FunctionTypes.h", "fmi3Functions.h", "fmi3PlatformTypes.h"),
}
GUID = "{placeholder of the GUID}"
BACKENDS = ("compiled", "python")


@dataclass(frozen=True)
class BuiltFmu:
    """An archive on disk: name of the model, path, SHA-256, and the platforms that it has binaries for."""

    name: str
    path: Path
    sha256: str
    platforms: tuple[str, ...]


def build(
    component: Component, out_dir: str | Path = ".", fmi: int = 2, backend: str = "compiled", platforms: str = "host"
) -> BuiltFmu:
    """Write the component's FMU into a folder, which is created if it does not exist.

    fmi is 2 or 3, backend `compiled` or `python` (FMI 2 only, its own platforms), platforms `host`, `all` or a
    comma list of names (`build_all` where one archive cannot hold them). Raises InputError for a wrong choice or a
    folder that cannot be written, MissingToolError when no compiler is there.
    """
    if backend not in BACKENDS:
        raise unknown("back end", backend, BACKENDS)
    if backend == "python" and fmi != 2:
        raise InputError("the python back end makes FMI 2 only; choose --fmi 2 or --backend compiled")
    if fmi not in FMI_HEADERS:
        raise unknown("FMI version", fmi, map(str, FMI_HEADERS))
    folder = writable_folder(out_dir)
    name, data, made_for = _python(component) if backend == "python" else _compiled(component, fmi, platforms)
    path = folder / f"{name}.fmu"
    write_atomically(path, lambda beside: beside.write_bytes(data))
    return BuiltFmu(identifier(component), path, hashlib.sha256(data).hexdigest(), made_for)


def _python(component: Component) -> tuple[str, bytes, tuple[str, ...]]:
    """File name without suffix, bytes and platforms of the archive of the python back end."""
    name, made_for = f"{identifier(component)}_python", python_backend.PLATFORMS
    found = CachedArchive(
        name, component, lambda: python_backend.sources(Interface(component)), ["python", pythonfmu.__version__]
    )
    return name, found.archive(python_backend.packed, compilers.host().name in made_for), made_for


def _compiled(component: Component, fmi: int, platforms: str) -> tuple[str, bytes, tuple[str, ...]]:
    """The same of the compiled back end; without a compiler a prebuilt archive, if it matches."""
    wanted, suffix = archive_platforms(fmi, platforms)
    name, targets = identifier(component) + suffix, tuple(p.name for p in wanted)
    try:
        tools = compiler_versions(wanted, platforms)
    except MissingToolError:
        shipped = prebuilt.find(f"{name}.fmu", source_contents(Interface(component), fmi)["modelDescription.xml"])
        if shipped is None or not set(targets) <= set(shipped[1]):
            raise
        return name, *shipped

    def packed(sources: Mapping[str, bytes]) -> dict[str, bytes]:
        carried = {n: data for n, data in sources.items() if Path(n).name not in FMI_HEADERS[fmi]}
        return {**carried, **binaries(identifier(component), sources, fmi, wanted, native=platforms == "host")}

    found = CachedArchive(name, component, lambda: source_contents(Interface(component), fmi), [f"FMI {fmi}", *tools])
    return name, found.archive(packed, compilers.host().name in targets), targets


@dataclass
class CachedArchive:
    """An archive in the cache. Its sources are generated only when they are needed."""

    name: str
    component: Component
    make_sources: Callable[[], dict[str, bytes]]
    tools: list[str]

    @cached_property
    def sources(self) -> dict[str, bytes]:
        return self.make_sources()

    def archive(self, packed: Callable[[Mapping[str, bytes]], dict[str, bytes]], load: bool) -> bytes:
        """The archive's bytes; if it is not in the cache, it is made of `packed(sources)` and stored there first."""
        known = cache_key(self.component)
        key = content_key(self.sources, *self.tools) if known is None else content_key({}, known, *self.tools)
        path = cache_folder() / f"{self.name}-{key[:32]}.fmu"
        if not path.is_file():
            store(archive(packed(self.sources)), path, load)
        return path.read_bytes()


def build_all(
    component: Component, out_dir: str | Path = ".", fmi: int = 2, backend: str = "compiled", platforms: str = "host"
) -> list[BuiltFmu]:
    """The same as `build`, in as many archives as the platforms need.

    FMI 2 has one folder for Linux, which its two kinds of processor cannot share: `linux-arm64` gets an archive of
    its own there.
    """
    names = [p.name for p in compilers.chosen(platforms)]
    apart = fmi == 2 and backend == "compiled" and {"linux-arm64", "linux-x86_64"} <= set(names)
    lists = [",".join(n for n in names if n != "linux-arm64"), "linux-arm64"] if apart else [platforms]
    return [build(component, out_dir, fmi, backend, each) for each in lists]


def archive_platforms(fmi: int, platforms: str) -> tuple[list[Platform], str]:
    """The platforms of one archive and what they add to its name."""
    wanted = compilers.chosen(platforms)
    if fmi == 3:
        return wanted, "_fmi3"
    if len({p.folder for p in wanted}) < len(wanted):
        raise InputError(
            "linux-x86_64 and linux-arm64 share one folder in FMI 2: build them apart (build_all), or use --fmi 3"
        )
    return wanted, "_arm64" if [p.name for p in wanted] == [
        "linux-arm64"
    ] and compilers.host().name != "linux-arm64" else ""


def source_contents(interface: Interface, fmi: int) -> dict[str, bytes]:
    """Model description, C source and what accompanies them, by their path in the archive. The GUID follows from the
    first two."""
    name = interface.identifier
    runtime = files("fmus.export").joinpath("runtime")
    code = {n: runtime.joinpath(n).read_bytes() for n in (*RUNTIME, *HEADERS, *API[fmi], "LICENSE.txt")}
    code.update({n: (Path(fmpy.__file__).parent / "c-code" / n).read_bytes() for n in FMI_HEADERS[fmi]})
    code["model.c"] = model_code(interface).encode()
    code["variables.c"] = variables_code(interface, GUID).encode()
    listed = COMPILED[fmi]
    contents = {f"sources/{n}": data for n, data in code.items()}
    if fmi == 2:
        contents["modelDescription.xml"] = model_description(interface, name, GUID, compiled(interface, listed))
    else:
        contents["modelDescription.xml"] = model_description3.model_description(interface, name, GUID)
        contents["sources/buildDescription.xml"] = model_description3.build_description(name, listed)
    guid = guid_of(content_key(contents)).encode()
    identified = {name: data.replace(GUID.encode(), guid) for name, data in contents.items()}
    return {**identified, **accompanying.files(interface, fmi)}


def guid_of(key: str) -> str:
    """A GUID in the form of FMI 2 from a key of the content."""
    return f"{{{uuid.UUID(key[:32])}}}"


def compiler_versions(wanted: list[Platform], platforms: str) -> list[str]:
    """The compiler of each platform with its version, for the cache key."""
    return [" ".join(c) + compilers.version(c) for p in wanted for c in compilers.commands(p, platforms == "host")]


def binaries(
    name: str, contents: Mapping[str, bytes], fmi: int, wanted: list[Platform], native: bool
) -> dict[str, bytes]:
    """The shared libraries of that name, and what belongs to them, by their path in the archive."""
    sources = {name.removeprefix("sources/"): data for name, data in contents.items() if name.startswith("sources/")}
    made = {}
    for target in wanted:
        with tempfile.TemporaryDirectory() as folder:
            for file, data in sources.items():
                Path(folder, file).write_bytes(data)
            compiled_files = (COMPILED_FOR_WASM if target.name == "wasm" else COMPILED)[fmi]
            libraries = compilers.compile_library(target, native, Path(folder), compiled_files, name)
        library = f"{name}{target.suffix}"
        if fmi == 2:
            made[f"binaries/{target.folder}/{library}"] = (
                libraries[0] if len(libraries) == 1 else compilers.universal(libraries)
            )
        else:
            made.update({f"binaries/{t}/{library}": b for t, b in zip(target.tuples, libraries, strict=False)})
            made.update(wasm_component.additions(library, libraries[0]) if target.name == "wasm" else {})
    return made


def archive(contents: Mapping[str, bytes]) -> bytes:
    """The zip archive: sorted, deflated, every entry with the same date and rights."""
    buffer = io.BytesIO()
    with zipfile.ZipFile(buffer, "w") as made:
        for name, data in sorted(contents.items()):
            entry = zipfile.ZipInfo(name, date_time=(1980, 1, 1, 0, 0, 0))
            entry.create_system, entry.external_attr = 3, 0o644 << 16
            made.writestr(entry, data, zipfile.ZIP_DEFLATED, 9)
    return buffer.getvalue()


def store(data: bytes, path: Path, load: bool) -> None:
    """Write the archive after it has been validated and, with `load`, simulated for two steps on this machine.

    Raises RuntimeError with the first problem found; nothing is written then.
    """
    with tempfile.TemporaryDirectory(dir=path.parent) as folder:
        draft = Path(folder, path.name)
        draft.write_bytes(data)
        problems = validate_fmu(str(draft))
        if problems:
            raise RuntimeError(f"{path.name} is not valid: {problems[0]}")
        if load:
            fmpy.simulate_fmu(str(draft), start_time=0.0, stop_time=0.002, output_interval=0.001)
        os.replace(draft, path)
