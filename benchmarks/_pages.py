"""Tables of pages that are rendered from results.json: those between the marks

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


def rendered(page: str, results: Mapping[str, Any]) -> str:
    """The page with the tables of the results between its marks; one without results stays."""

    def table(found: re.Match[str]) -> str:
        begin, name, end = found.groups()
        if name not in results:
            return found[0]
        text: str = import_module(f"benchmarks.{name}").table(results[name])
        return begin + text.rstrip("\n") + end

    return TABLE.sub(table, page)


def render(results: Mapping[str, Any]) -> list[Path]:
    """Write every page whose tables have changed; its paths."""
    changed = []
    for path in sorted(DOCS.rglob("*.md")):
        page = path.read_text("utf-8")
        if (text := rendered(page, results)) != page:
            path.write_text(text, "utf-8")
            changed.append(path)
    return changed
