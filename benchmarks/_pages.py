"""Numbers and tables of pages that are rendered from results.json.

A number stands between the marks `<!-- measured PATH | FORMAT | FACTOR -->` and `<!-- end -->`. The path is of keys,
joined by dots, or by slashes where a key has a dot; format and factor are optional. In tables, whose cells a bar would
split, semicolons separate them. A table stands between the marks

    <!-- table of benchmarks.NAME -->
    <!-- end of the table -->

where `benchmarks.NAME` has `table(results)`, the Markdown of what results.json holds under NAME.
"""

import re
from collections.abc import Mapping
from importlib import import_module
from pathlib import Path
from typing import Any

DOCS = Path(__file__).parents[1] / "docs"
TABLE = re.compile(r"(<!-- table of benchmarks\.(\w+) -->\n\n).*?(\n\n<!-- end of the table -->)", re.DOTALL)
NUMBER = re.compile(r"(<!-- measured (.*?) -->).*?(<!-- end -->)")


def entry(results: Mapping[str, Any], path: str) -> Any:
    """The entry of the results at a path. Raises KeyError for a path that is not there."""
    found: Any = results
    for key in path.split("/" if "/" in path else "."):
        found = found[int(key) if isinstance(found, list) else key]
    return found


def number(results: Mapping[str, Any], mark: str) -> str:
    """The number of a mark `PATH | FORMAT | FACTOR`."""
    path, kind, factor = [*(part.strip() for part in re.split("[|;]", mark)), "", ""][:3]
    return format(entry(results, path) * float(factor or 1), kind or ".3g")


def rendered(page: str, results: Mapping[str, Any]) -> str:
    """The page with the numbers and tables of the results between its marks; a table without results stays."""

    def table(found: re.Match[str]) -> str:
        begin, name, end = found.groups()
        if name not in results:
            return found[0]
        text: str = import_module(f"benchmarks.{name}").table(results[name])
        return begin + text.rstrip("\n") + end

    page = NUMBER.sub(lambda found: f"{found[1]}{number(results, found[2])}{found[3]}", page)
    return TABLE.sub(table, page)


def render(results: Mapping[str, Any]) -> list[Path]:
    """Write every page whose numbers or tables have changed; its paths."""
    changed = []
    for path in sorted(DOCS.rglob("*.md")):
        page = path.read_text("utf-8")
        if (text := rendered(page, results)) != page:
            path.write_text(text, "utf-8")
            changed.append(path)
    return changed
