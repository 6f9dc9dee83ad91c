"""The archive before it is unpacked: no path out of its folder, no links, no archive bombs, no XML that loads files."""

import stat
import zipfile
import zlib
from pathlib import PurePosixPath

from fmus.checks.checked_fmu import CheckedFmu
from fmus.checks.problem import Problem

STAGE = "archive"
SECTION = "FMI 2.0.4, 2.3; FMI 3.0, 2.5.1"  # the version is not known yet
LARGEST_MEMBER = 512 * 2**20
LARGEST_ARCHIVE = 2 * 2**30
LARGEST_RATIO = 1000  # of a member of some size; deflate reaches 1032 with nothing but zeros
XML_LIMIT = 64 * 2**20
LONGEST_NAME = 255  # of a file in most file systems
LONGEST_PATH = 1000


def _error(message: str, where: str) -> Problem:
    return Problem("archive", "error", message, where, section=SECTION)


def check(fmu: CheckedFmu) -> list[Problem]:
    """Problems of the archive; errors forbid unpacking."""
    try:
        with zipfile.ZipFile(fmu.path) as archive:
            found = _members(archive)
            return found if any(p.severity == "error" for p in found) else found + _xml(archive)
    except (zipfile.BadZipFile, zlib.error, NotImplementedError, RuntimeError, EOFError, OSError) as error:
        return [_error(f"is no readable zip archive: {error}", fmu.path.name)]


def _members(archive: zipfile.ZipFile) -> list[Problem]:
    found: list[Problem] = []
    seen: dict[str, tuple[int, int]] = {}
    total = 0
    for member in archive.infolist():
        name, where = member.orig_filename, member.filename
        total += member.file_size
        if _leaves_folder(name):
            found.append(_error("the path leaves the folder of the archive", where))
        if len(name.encode()) > LONGEST_PATH or any(len(part.encode()) > LONGEST_NAME for part in name.split("/")):
            found.append(_error(f"the path is too long for a file ({len(name)} characters)", f"{where[:60]}..."))
        if stat.S_ISLNK(member.external_attr >> 16):
            found.append(_error("is a symbolic link", where))
        if member.flag_bits & 1:
            found.append(_error("is encrypted", where))
        if member.file_size > LARGEST_MEMBER:
            found.append(_error(f"unpacks to {member.file_size} bytes, more than {LARGEST_MEMBER}", where))
        elif member.file_size > 2**20 and member.file_size > LARGEST_RATIO * max(member.compress_size, 1):
            found.append(
                _error(f"unpacks to {member.file_size / max(member.compress_size, 1):.0f} times its size", where)
            )
        content = member.CRC, member.file_size
        if name in seen and seen[name] != content:
            found.append(_error("is there twice, with different contents", where))
        elif name in seen and not name.endswith("/"):
            found.append(
                Problem("archive", "warning", "is there twice, with the same contents", where, section=SECTION)
            )
        seen[name] = content
    found += _not_together(set(seen))
    if total > LARGEST_ARCHIVE:
        found.append(_error(f"unpacks to {total} bytes, more than {LARGEST_ARCHIVE}", ""))
    if "modelDescription.xml" not in seen:
        found.append(_error("has no modelDescription.xml at its top", ""))
    return found


def _not_together(names: set[str]) -> list[Problem]:
    """Paths that are file and folder in one, and paths that some file systems take for each other."""
    files = {n for n in names if not n.endswith("/")}
    found = [
        _error("is a file and a folder", str(p))
        for p in sorted({str(p) for n in names for p in PurePosixPath(n).parents} & files)
    ]
    spellings: dict[str, str] = {}
    for name in sorted(names):
        other = spellings.setdefault(name.casefold(), name)
        if other != name:
            found.append(_error(f"differs from {other} by upper and lower case alone", name))
    return found


def _leaves_folder(name: str) -> bool:
    parts = PurePosixPath(name.replace("\\", "/")).parts
    return "\\" in name or name.startswith("/") or ".." in parts or ":" in name.partition("/")[0] or "\0" in name


def _xml(archive: zipfile.ZipFile) -> list[Problem]:
    """XML that declares a document type could name entities, which a reader fetches from disk or the net."""
    found = []
    for member in archive.infolist():
        if not member.filename.lower().endswith(".xml"):
            continue
        if member.file_size > XML_LIMIT:
            found.append(_error(f"is XML of {member.file_size} bytes, more than {XML_LIMIT}", member.filename))
            continue
        # Without its zero bytes, UTF-16 and UTF-32 of ASCII text read like ASCII.
        text = archive.read(member).replace(b"\0", b"").upper()
        if b"<!DOCTYPE" in text or b"<!ENTITY" in text:
            found.append(_error("declares a document type or entities, which FMI does not use", member.filename))
    return found
