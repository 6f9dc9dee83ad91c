"""The keys of every JSON output, from the schemas that ship."""

import json
from collections.abc import Iterator
from typing import Any

from extension.tables import table
from motofmi.schemas import names, schema

FIRST = "verdict"
INTRODUCTION = """# JSON outputs

`--json FILE` writes what a command shows; `motofmi gap` also writes verdict.json. JSON never holds NaN: null stands
for what does not exist. A complex number is `[re, im]`, a parameter `{value, standard_error, unit}`. The schemas
(JSON Schema 2020-12) ship with the package: `mf.schema("verdict")`, or the files in `motofmi/schemas`. In the tables
`.` is a key inside an object, `[]` an entry of a list, `*` any name; keys in *italics* may be absent.

"""


def page() -> str:
    ordered = sorted(names(), key=lambda name: (name != FIRST, name))
    return INTRODUCTION + "\n".join(_section(name, schema(name)) for name in ordered)


def _section(name: str, found: dict[str, Any]) -> str:
    variants = found.get("oneOf", [found])
    tables = [
        f"{v['description'].capitalize()}:\n\n{_table(v, found)}" if "description" in v else _table(v, found)
        for v in variants
    ]
    return "\n".join([f"## {name}\n\n{found['title']}.\n", *tables])


def _table(part: dict[str, Any], whole: dict[str, Any]) -> str:
    rows = [(f"*`{key}`*" if optional else f"`{key}`", kind, text) for key, kind, text, optional in _rows(part, whole)]
    return table(("key", "type", "meaning"), rows)


def _rows(
    part: dict[str, Any], whole: dict[str, Any], prefix: str = "", depth: int = 0
) -> Iterator[tuple[str, str, str, bool]]:
    """Key, type, meaning, and whether it may be absent, of everything below a part of a schema."""
    part = _resolved(part, whole)
    for variant in part.get("oneOf", ()):
        yield from _rows(variant, whole, prefix, depth)
    for key, value in part.get("properties", {}).items():
        inner = _resolved(value, whole)
        yield (
            prefix + key,
            _kind(inner),
            value.get("description") or inner.get("description", ""),
            key not in part.get("required", ()),
        )
        if depth < 3 and key != "units":
            yield from _rows(inner, whole, f"{prefix}{key}.", depth + 1)
    if isinstance(part.get("additionalProperties"), dict):
        yield from _rows(part["additionalProperties"], whole, f"{prefix}*.", depth + 1)
    if "items" in part and depth < 4:
        yield from _rows(part["items"], whole, f"{prefix.removesuffix('.')}[].", depth + 1)


def _resolved(part: dict[str, Any], whole: dict[str, Any]) -> dict[str, Any]:
    """What a reference, or one that may be null, stands for."""
    described = {"description": part["description"]} if "description" in part else {}
    if "anyOf" in part:
        return {**_resolved(part["anyOf"][0], whole), **described, "nullable": True}
    if "$ref" in part:
        return {**_resolved(whole["$defs"][part["$ref"].rpartition("/")[2]], whole), **described}
    return part


def _kind(part: dict[str, Any]) -> str:
    if "enum" in part:
        return ", ".join(f"`{json.dumps(value)}`" for value in part["enum"])
    given = part.get("type", "any")
    names_ = [given] if isinstance(given, str) else given
    kind = " or ".join(names_) + (" or null" if part.get("nullable") else "")
    if "array" in names_ and "items" in part:
        inner = part["items"].get("type")
        kind = kind.replace(
            "array", f"array of {inner if isinstance(inner, str) else ' or '.join(inner)}" if inner else "array"
        )
    return kind
