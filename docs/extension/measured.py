"""Numbers of pages from `benchmarks/results.json`: the role {measured}`path | format | factor`.

The path is of keys, joined by dots, or by slashes where a key has a dot; format and factor are optional:
{measured}`sweep.overhead | .1f | 100`. In tables, whose cells a bar would split, they are separated by semicolons.
"""

import json
import re
from functools import cache
from pathlib import Path
from typing import Any

RESULTS = Path(__file__).parents[2] / "benchmarks" / "results.json"


@cache
def results() -> dict[str, Any]:
    return json.loads(RESULTS.read_text("utf-8"))


def value(path: str) -> Any:
    """The entry at a path. Raises KeyError for a path that is not there."""
    found: Any = results()
    for key in path.split("/" if "/" in path else "."):
        found = found[int(key) if isinstance(found, list) else key]
    return found


def shown(text: str) -> str:
    """The number that the text of a role stands for."""
    path, kind, factor = [*(part.strip() for part in re.split("[|;]", text)), "", ""][:3]
    return format(value(path) * float(factor or 1), kind or ".3g")


def share(rate: dict[str, float]) -> str:
    """A rate with its 95 % interval: `86 % [76, 93]`."""
    low, high = (100 * rate[end] for end in ("from", "to"))
    return f"{100 * rate['rate']:.0f} % [{low:.0f}, {high:.0f}]"


def cases(rate: dict[str, float]) -> str:
    """The count behind a rate: `57 of 66`."""
    return f"{round(rate['rate'] * rate['trials'])} of {rate['trials']:.0f}"


def role(
    name: str, raw: str, text: str, line: int, inliner: Any, options: Any = None, content: Any = ()
) -> tuple[list[Any], list[Any]]:
    """The docutils role."""
    from docutils import nodes  # noqa: PLC0415 - the tests read numbers without it

    return [nodes.Text(shown(text))], []
