"""The effects and the published values that ship."""

from collections import defaultdict

import motofmi
from extension.tables import table

EFFECTS = """# Effects

The library of the gap workflow on riders, vehicles and measuring channels. A family is a phenomenon, a form its equation. Laws of
mechanics act on any component that is given with `--component`.

"""
VALUES = """# Riders, motorcycles, dampers

Every entry is a name for `--vehicle`, `--device` and `mf.component`; `motofmi list --json -` has all values.
"""


def effects() -> str:
    families = defaultdict(list)
    for entry in motofmi.catalogue().to_dict()["effects"]:
        families[entry["name"]].append(entry)
    rows = [
        (f"`{family}`", f"`{e['form']}`", e["element"] or "", e["description"],
         ", ".join(f"`{n}` [{row['unit']}]" for n, row in e["parameters"].items()))
        for family, forms in sorted(families.items()) for e in forms
    ]  # fmt: skip
    return EFFECTS + table(("family", "form", "place", "meaning", "parameters"), rows)


def values() -> str:
    found = motofmi.catalogue().to_dict()
    sections = [VALUES]
    for kind in ("motorcycles", "riders", "dampers", "mechanisms"):
        rows = [(f"`{e['name']}`", e["component"], e["description"], e["source"]) for e in found[kind]]
        sections.append(f"## {kind.capitalize()}\n\n{table(('name', 'component', 'description', 'source'), rows)}")
    return "\n".join(sections)
