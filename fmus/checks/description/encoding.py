"""The encoding of the XML files, which has to be UTF-8: an importer may hand their texts to the FMU as they are."""

import codecs
import re

from fmus.checks.checked_fmu import CheckedFmu
from fmus.checks.description.schema import FILES
from fmus.checks.problem import Problem

STAGE = "description"
MARKS = {
    codecs.BOM_UTF32_LE: "UTF-32",
    codecs.BOM_UTF32_BE: "UTF-32",
    codecs.BOM_UTF16_LE: "UTF-16",
    codecs.BOM_UTF16_BE: "UTF-16",
}  # the longer marks first: that of UTF-32 begins with that of UTF-16
DECLARED = re.compile(rb"\s*<\?xml[^>]*?\sencoding\s*=\s*[\"']([^\"'>]*)", re.IGNORECASE)
PERMITTED = ("UTF-8", "US-ASCII", "ASCII")  # ASCII text is UTF-8


def check(fmu: CheckedFmu) -> list[Problem]:
    """Files in another encoding than UTF-8."""
    found = []
    for name, _, _, *numbers in FILES:
        path = fmu.folder / name
        if path.is_file() and (encoding := _other_encoding(path.read_bytes())):
            message = f"has the encoding {encoding}; expected UTF-8, which the standard requires"
            found.append(fmu.error("encoding", message, name, *numbers))
    return found


def _other_encoding(xml: bytes) -> str:
    """The encoding of XML that a parser reads; empty where it is UTF-8."""
    for mark, name in MARKS.items():
        if xml.startswith(mark):
            return name
    if b"\0" in xml[:4]:  # UTF-16 or UTF-32 without a mark: `<` takes two or four bytes
        return "UTF-16" if xml[:4].count(0) <= 2 else "UTF-32"
    declared = DECLARED.match(xml.removeprefix(codecs.BOM_UTF8))
    name = declared[1].decode("ascii", "replace") if declared else "UTF-8"
    return "" if name.upper() in PERMITTED else name[:40]
