"""JSON schemas (2020-12) of everything that the commands write as JSON, one file each."""

import json
from pathlib import Path
from typing import Any

from fmus.support.errors import unknown

FOLDER = Path(__file__).parent


def names() -> list[str]:
    """The names of the schemas."""
    return sorted(path.stem for path in FOLDER.glob("*.json"))


def schema(name: str) -> dict[str, Any]:
    """The JSON schema of the output of that name: of `verdict.json` by `verdict`, of a command's --json by the command.

    Quantities are in SI units or in the unit that a key's description states. Raises InputError for an unknown name.

        >>> mf.schema("verdict")["properties"]["verdict"]["enum"]
        ['named', 'tied', 'unknown', 'none']
    """
    if name not in names():
        raise unknown("schema", name, names())
    return json.loads((FOLDER / f"{name}.json").read_text("utf-8"))
