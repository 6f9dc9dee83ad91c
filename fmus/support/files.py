"""Files written atomically: to a temporary file in the same folder, which is then renamed."""

import os
import tempfile
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path

from fmus.support.errors import InputError

_RECORDS: list[list[Path]] = []  # of the contexts of `files_written` that are open


@contextmanager
def files_written() -> Iterator[list[Path]]:
    """The paths of the files that are written within the context, in order; those of a cache are left out."""
    record: list[Path] = []
    _RECORDS.append(record)
    try:
        yield record
    finally:
        _RECORDS.pop()


def note_written(path: str | Path) -> None:
    """Record a file that was written by other means than this module's, or by another process."""
    for record in _RECORDS:
        record.append(Path(path))


def write_atomically(path: str | Path, write: Callable[[Path], object], cache: bool = False) -> Path:
    """Call `write` with the path of a temporary file in the same folder, then rename that file; the final path.

    Folders are created. After a failure neither the file nor the temporary one exists. Raises InputError when the place
    cannot be written. With cache=True `files_written` does not record the file.
    """
    path = Path(path)
    beside = None
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        handle, name = tempfile.mkstemp(prefix=f".{path.stem}-", suffix=path.suffix, dir=path.parent)
        os.close(handle)
        beside = Path(name)
        write(beside)
        beside.chmod(0o644)
        if not cache:
            note_written(path)  # first, so that an interrupt between the two leaves no file that is not recorded
        os.replace(beside, path)
    except BaseException as error:
        if beside is not None:
            beside.unlink(missing_ok=True)
        if isinstance(error, OSError):
            raise InputError(f"cannot write {path}: {error.strerror}; choose another place") from None
        raise
    return path


def write_text(path: Path, text: str) -> None:
    """Write a UTF-8 text file atomically. Raises InputError when the file cannot be written."""
    write_atomically(path, lambda beside: beside.write_text(text, "utf-8"))


def writable(path: str | Path) -> Path:
    """The path, after a check that a file can be written there, for use before a long computation. Nothing is created.

    Raises InputError where the folder cannot be created or written, or where the path is a folder.
    """
    path = Path(path)
    nearest = next(folder for folder in path.absolute().parents if folder.exists())
    if not nearest.is_dir():
        reason = f"{nearest} is not a folder"
    elif path.is_dir():
        reason = "it is a folder"
    elif not os.access(nearest, os.W_OK | os.X_OK) or (path.exists() and not os.access(path, os.W_OK)):
        reason = "no permission"
    else:
        return path
    raise InputError(f"cannot write {path}: {reason}; choose another place")


def writable_folder(folder: str | Path) -> Path:
    """The folder, created if it does not exist. Raises InputError when nothing can be written there."""
    path = Path(folder)
    try:
        path.mkdir(parents=True, exist_ok=True)
        tempfile.TemporaryFile(dir=path).close()
    except OSError as error:
        raise InputError(
            f"cannot write to folder {path}: {error.strerror}; choose another (--out, or MOTOFMI_CACHE for the cache)"
        ) from None
    return path
