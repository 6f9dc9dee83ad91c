"""An FMU archive of unknown origin before it is unpacked: no path out of its folder, no links, no archive bombs, no XML
that loads files.

Whatever unpacks an FMU that this project has not built calls `refuse_unsafe`; `fmus.checks` reports the same faults.
"""

import re
import stat
import zipfile
import zlib
from dataclasses import dataclass
from pathlib import Path, PurePosixPath

from fmus.support.errors import InputError

DESCRIPTION = "modelDescription.xml"
SYSTEM = "SystemStructure.ssd"
LARGEST_MEMBER = 512 * 2**20
LARGEST_ARCHIVE = 2 * 2**30
LARGEST_RATIO = 1000  # of a member of some size; deflate reaches 1032 with nothing but zeros
XML_LIMIT = 64 * 2**20
LONGEST_NAME = 255  # of a file in most file systems
LONGEST_PATH = 1000
ENCODING = re.compile(rb"[^<]*<\?XML[^>]*?ENCODING\s*=\s*[\"']([^\"'>]*)")  # of an XML declaration in upper case
LIKE_ASCII = re.compile(rb"UTF-?(8|16|32)(LE|BE)?|(US-)?ASCII|ISO-8859-\d+|WINDOWS-125\d")  # encodings of ASCII text


@dataclass(frozen=True)
class Fault:
    """What is wrong, and the member of the archive or its file. harmless: it does not forbid unpacking."""

    message: str
    where: str
    harmless: bool = False


def refuse_unsafe(path: str | Path) -> None:
    """Raises InputError with the first fault of an archive that must not be unpacked."""
    found = [fault for fault in faults(path) if not fault.harmless]
    if not found:
        return
    first, others = found[0], len(found) - 1
    where = f"{first.where}: " if first.where and first.where != Path(path).name else ""
    more = f", and {others} more fault{'s' if others > 1 else ''}" if others else ""
    raise InputError(f"{path} is not an FMU that can be read: {where}{first.message}{more}; nothing was unpacked "
                     "(motofmi check lists all faults)")  # fmt: skip


def faults(path: str | Path) -> list[Fault]:
    """The faults of an FMU archive; nothing is unpacked."""
    try:
        with zipfile.ZipFile(path) as archive:
            found = _members(archive)
            return found if any(not fault.harmless for fault in found) else found + _xml(archive)
    except (zipfile.BadZipFile, zlib.error, NotImplementedError, RuntimeError, EOFError, OSError) as error:
        return [Fault(f"is no readable zip archive: {error}", Path(path).name)]


def unsafe_xml(xml: bytes) -> str:
    """Why XML must not be parsed; an empty text where it may be.

    A reader expands entities, or fetches them from disk or the net. In an encoding such as UTF-7 their declaration does
    not read like ASCII.
    """
    text = xml.replace(b"\0", b"").upper()  # without its zero bytes, UTF-16 and UTF-32 of ASCII text read like ASCII
    if b"<!DOCTYPE" in text or b"<!ENTITY" in text:
        return "declares a document type or entities, which the standard does not use"
    declared = ENCODING.match(text)
    if declared and not LIKE_ASCII.fullmatch(declared[1]):
        return f"has the encoding {declared[1].decode('ascii', 'replace')[:40]}; expected UTF-8"
    return ""


def _members(archive: zipfile.ZipFile) -> list[Fault]:
    found: list[Fault] = []
    seen: dict[str, tuple[int, int]] = {}
    total = 0
    for member in archive.infolist():
        name, where = member.orig_filename, member.filename
        total += member.file_size
        if _leaves_folder(name):
            found.append(Fault("the path leaves the folder of the archive", where))
        if len(name.encode()) > LONGEST_PATH or any(len(part.encode()) > LONGEST_NAME for part in name.split("/")):
            found.append(Fault(f"the path is too long for a file ({len(name)} characters)", f"{where[:60]}..."))
        if stat.S_ISLNK(member.external_attr >> 16):
            found.append(Fault("is a symbolic link", where))
        if member.flag_bits & 1:
            found.append(Fault("is encrypted", where))
        ratio = member.file_size / max(member.compress_size, 1)
        if member.file_size > LARGEST_MEMBER:
            found.append(Fault(f"unpacks to {member.file_size} bytes, more than {LARGEST_MEMBER}", where))
        elif member.file_size > 2**20 and ratio > LARGEST_RATIO:
            found.append(Fault(f"unpacks to {ratio:.0f} times its size", where))
        content = member.CRC, member.file_size
        if name in seen and seen[name] != content:
            found.append(Fault("is there twice, with different contents", where))
        elif name in seen and not name.endswith("/"):
            found.append(Fault("is there twice, with the same contents", where, harmless=True))
        seen[name] = content
    found += _not_together(set(seen))
    if total > LARGEST_ARCHIVE:
        found.append(Fault(f"unpacks to {total} bytes, more than {LARGEST_ARCHIVE}", ""))
    if DESCRIPTION not in seen:
        found.append(Fault(f"has no {DESCRIPTION} at its top{_in_its_place(set(seen))}", ""))
    return found


def _in_its_place(names: set[str]) -> str:
    """What an archive without a description is instead, where that is known."""
    if SYSTEM in names:
        return ": it is a system of FMUs, which motofmi cosimulate --ssp runs"
    within = sorted(n.rpartition("/")[0] for n in names if n.endswith(f"/{DESCRIPTION}"))
    return f": it is in the folder {within[0]!r}, whose contents belong at the top" if within else ""


def _not_together(names: set[str]) -> list[Fault]:
    """Paths that are file and folder in one, and paths that some file systems take for each other."""
    files = {n for n in names if not n.endswith("/")}
    found = [
        Fault("is a file and a folder", str(p))
        for p in sorted({str(p) for n in names for p in PurePosixPath(n).parents} & files)
    ]
    spellings: dict[str, str] = {}
    for name in sorted(names):
        other = spellings.setdefault(name.casefold(), name)
        if other != name:
            found.append(Fault(f"differs from {other} by upper and lower case alone", name))
    return found


def _leaves_folder(name: str) -> bool:
    parts = PurePosixPath(name.replace("\\", "/")).parts
    return "\\" in name or name.startswith("/") or ".." in parts or ":" in name.partition("/")[0] or "\0" in name


def _xml(archive: zipfile.ZipFile) -> list[Fault]:
    found = []
    for member in archive.infolist():
        if not member.filename.lower().endswith(".xml"):
            continue
        if member.file_size > XML_LIMIT:
            found.append(Fault(f"is XML of {member.file_size} bytes, more than {XML_LIMIT}", member.filename))
        elif reason := unsafe_xml(archive.read(member)):
            found.append(Fault(reason, member.filename))
    return found
