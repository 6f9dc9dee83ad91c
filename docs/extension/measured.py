"""The results of the benchmarks as the reference pages show them."""

import json
from functools import cache
from typing import Any

from benchmarks.__main__ import RESULTS
from benchmarks._pages import entry


@cache
def results() -> dict[str, Any]:
    return json.loads(RESULTS.read_text("utf-8"))


def value(path: str) -> Any:
    """The entry at a path. Raises KeyError for a path that is not there."""
    return entry(results(), path)


def share(rate: dict[str, float]) -> str:
    """A rate with its 95 % interval: `86 % [76, 93]`."""
    low, high = (100 * rate[end] for end in ("from", "to"))
    return f"{100 * rate['rate']:.0f} % [{low:.0f}, {high:.0f}]"


def cases(rate: dict[str, float]) -> str:
    """The count behind a rate: `57 of 66`."""
    return f"{round(rate['rate'] * rate['trials'])} of {rate['trials']:.0f}"
