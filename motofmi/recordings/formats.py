"""Which formats of recordings can be read: the readers in the folder `readers`, found by suffix. Any of them may
be packed with gzip."""

import gzip
import shutil
import zlib
from collections.abc import Iterator
from contextlib import contextmanager
from importlib import import_module
from importlib.util import find_spec
from pathlib import Path
from pkgutil import iter_modules
from tempfile import TemporaryDirectory

from fmus.support.errors import InputError, MissingToolError
from motofmi.recordings import readers
from motofmi.recordings.table import Format, Table

PACKED = ".gz"
TEXT = ".csv"  # whose reader also reads files of an unknown suffix


def formats() -> dict[str, Format]:
    """The formats by suffix. A reader in a further folder of the package's `__path__` counts like those that ship."""
    modules = [import_module(f"{readers.__name__}.{found.name}") for found in iter_modules(readers.__path__)]
    return {suffix: module.FORMAT for module in modules for suffix in module.FORMAT.suffixes}


def supported() -> str:
    """The suffixes of all formats, as help texts and messages list them."""
    return f"{', '.join(sorted(formats()))}, each also packed as {PACKED}"


@contextmanager
def opened(path: Path) -> Iterator[Table]:
    """The columns of a file, while it is open. Puts its name in front of every InputError that is raised meanwhile.

    Raises InputError for a file that cannot be read, and MissingToolError where its reader needs a package
    that is not installed.
    """
    try:
        with _unpacked(path) as file:
            yield _read(file)
    except InputError as error:
        raise InputError(f"{path}: {error}") from None
    except OSError as error:
        raise InputError(f"cannot read {path}: {error.strerror or error}") from None


def run_name(path: Path) -> str:
    """The name of the run in a file: the file's name without suffixes."""
    return Path(path.stem).stem if path.suffix.lower() == PACKED else path.stem


@contextmanager
def _unpacked(path: Path) -> Iterator[Path]:
    """The file, or its content in a temporary folder where it is packed."""
    if path.suffix.lower() != PACKED:
        yield path
        return
    with TemporaryDirectory() as folder:
        plain = Path(folder) / path.stem
        try:
            with gzip.open(path) as packed, plain.open("wb") as file:
                shutil.copyfileobj(packed, file)
        except (gzip.BadGzipFile, EOFError, zlib.error) as error:
            raise InputError(f"not a valid {PACKED} file: {error}") from None
        yield plain


def _read(file: Path) -> Table:
    known = formats()
    form = known.get(file.suffix.lower(), known[TEXT])
    if form.needs and find_spec(form.needs) is None:
        raise MissingToolError(f"reading {file.name} needs {form.needs}: pip install motofmi[formats]")
    file.open("rb").close()  # raises the OSError of a file that is not there, whatever the reader's library would say
    try:
        return form.read(file)
    except (InputError, OSError):
        raise
    except Exception as error:  # of a library: each has its own
        raise InputError(f"not a valid {form.name} file: {type(error).__name__}: {error}") from None
