"""The version of this package: what `pyproject.toml` says in a checkout, else what the installed distribution says."""

import tomllib
from importlib.metadata import version
from pathlib import Path

PROJECT = Path(__file__).parent.parent / "pyproject.toml"  # not part of a wheel


def found() -> str:
    """The version, as in `1.2.3`."""
    if PROJECT.is_file():
        project = tomllib.loads(PROJECT.read_text("utf-8")).get("project", {})
        if project.get("name") == "motofmi":
            return project["version"]
    return version("motofmi")


__version__ = found()
