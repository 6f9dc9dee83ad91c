"""The files of an SSP archive. An archive is untrusted: its files are read one by one, with a limit on their size, and
stored under names of our own, so that no path in it can lead elsewhere; XML with a document type is refused, because
that can name entities."""

import zipfile
import zlib
from pathlib import Path, PurePosixPath
from typing import Self
from urllib.parse import unquote, urlsplit
from xml.etree import ElementTree as Xml

from fmus.support.errors import InputError
from fmus.support.untrusted_archive import unsafe_xml

SSD = "http://ssp-standard.org/SSP1/SystemStructureDescription"
SSC = "http://ssp-standard.org/SSP1/SystemStructureCommon"
SSV = "http://ssp-standard.org/SSP1/SystemStructureParameterValues"
SSM = "http://ssp-standard.org/SSP1/SystemStructureParameterMapping"
SPACES = {"ssd": SSD, "ssc": SSC, "ssv": SSV, "ssm": SSM}
STRUCTURE = "SystemStructure.ssd"
VERSIONS = ("1.0", "2.0")
FMU = "application/x-fmu-sharedlibrary"
LARGEST_XML, LARGEST_FMU = 64 * 2**20, 512 * 2**20  # bytes


class Package:
    """An open SSP archive; a context manager. FMUs are copied into `folder`."""

    def __init__(self, path: str | Path, folder: str | Path):
        self.path, self.folder = Path(path), Path(folder)
        self._fmus: dict[str, Path] = {}
        try:
            self._archive = zipfile.ZipFile(self.path)
        except (OSError, zipfile.BadZipFile) as error:
            reason = getattr(error, "strerror", None) or error
            raise InputError(f"{path} is not an SSP archive that can be read: {reason}") from None

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *error: object) -> None:
        self._archive.close()

    def refused(self, element: str, reason: str) -> InputError:
        """The error for an element of this archive that cannot be used."""
        return InputError(f"{self.path}: {element}: {reason}")

    def xml(self, source: str, root: str, element: str) -> Xml.Element:
        """The root of an XML file, which must have the tag `root` and a version that is known."""
        return self.checked(self._parsed(self._archive, self._member(source, element), element), root, element)

    def xml_in_fmu(self, fmu: Path, source: str, root: str, element: str) -> Xml.Element:
        """The same for a file inside an FMU of the archive."""
        try:
            with zipfile.ZipFile(fmu) as archive:
                return self.checked(self._parsed(archive, self._member(source, element), element), root, element)
        except zipfile.BadZipFile as error:
            raise self.refused(element, f"its FMU is no archive that can be read: {error}") from None

    def checked(self, found: Xml.Element, root: str, element: str) -> Xml.Element:
        """An element, after a check of its tag and version."""
        if found.tag != root:
            raise self.refused(element, f"has the root element {local(found.tag)}, not {local(root)}")
        if found.get("version") not in VERSIONS:
            raise self.refused(
                element, f"is of version {found.get('version')} of the standard (valid: {', '.join(VERSIONS)})"
            )
        return found

    def fmu(self, source: str, element: str) -> Path:
        """The path of a copy of an FMU."""
        member = self._member(source, element)
        if member not in self._fmus:
            copy = self.folder / f"{len(self._fmus) + 1}.fmu"
            copy.write_bytes(self._bytes(self._archive, member, LARGEST_FMU, element))
            self._fmus[member] = copy
        return self._fmus[member]

    def _member(self, source: str, element: str) -> str:
        """The path in an archive that a relative URI names."""
        parts = urlsplit(source)
        if parts.scheme or parts.netloc or parts.query or parts.fragment:
            raise self.refused(element, f"the source {source!r} is no path inside the archive; only such are supported")
        path = PurePosixPath(unquote(parts.path))
        if path.is_absolute() or ".." in path.parts or not path.parts:
            raise self.refused(element, f"the source {source!r} leaves the archive")
        return str(path)

    def _parsed(self, archive: zipfile.ZipFile, member: str, element: str) -> Xml.Element:
        data = self._bytes(archive, member, LARGEST_XML, element)
        if reason := unsafe_xml(data):
            raise self.refused(element, f"{member} {reason}")
        try:
            return Xml.fromstring(data)
        except (Xml.ParseError, ValueError, LookupError) as error:  # the last two for encodings
            raise self.refused(element, f"{member} is no XML: {error}") from None

    def _bytes(self, archive: zipfile.ZipFile, member: str, limit: int, element: str) -> bytes:
        try:
            with archive.open(member) as file:
                data = file.read(limit + 1)
        except KeyError:
            raise self.refused(element, f"there is no {member} in the archive") from None
        except (zipfile.BadZipFile, zlib.error, NotImplementedError, RuntimeError, EOFError, OSError) as error:
            raise self.refused(element, f"{member} cannot be read: {error}") from None
        if len(data) > limit:
            raise self.refused(element, f"{member} has more than {limit} bytes")
        return data


def local(tag: str) -> str:
    """A tag without its namespace."""
    return tag.rpartition("}")[2]


def truth(text: str | None) -> bool | None:
    """An XML Boolean; None for any other text."""
    return {"true": True, "1": True, "false": False, "0": False}.get((text or "").strip())
