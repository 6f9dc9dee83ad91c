"""Outputs of commands against the schemas that ship."""

from functools import cache
from typing import Any

import pytest

from motofmi.schemas import schema


@cache
def _validator(name: str) -> Any:
    jsonschema = pytest.importorskip("jsonschema")
    jsonschema.Draft202012Validator.check_schema(schema(name))
    return jsonschema.Draft202012Validator(schema(name))


def check_against_schema(name: str, contents: Any) -> None:
    """Raises AssertionError with every violation and its place."""
    found = [
        f"{'/'.join(map(str, e.absolute_path))}: {e.message[:300]}" for e in _validator(name).iter_errors(contents)
    ]
    if found:
        raise AssertionError(f"{name}: {found}")
