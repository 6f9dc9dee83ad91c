"""The formats of recordings that are read."""

from extension.tables import table
from motofmi.recordings.formats import PACKED, formats

INTRODUCTION = f"# Formats of recordings\n\nEvery file may be packed (`{PACKED}`). A package that is needed comes with `pip install 'motofmi[formats]'`.\n\n"


def page() -> str:
    found = {id(each): each for each in formats().values()}.values()
    return INTRODUCTION + table(
        ("format", "suffix", "package"),
        [(f.name, ", ".join(f"`{s}`" for s in f.suffixes), f.needs or "") for f in found],
    )
