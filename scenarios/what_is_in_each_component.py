"""What is in each component? Writes a page for every one of them into a folder.

    python -m motofmi.scenarios.what_is_in_each_component

By default the pages are written into docs/components, and the figure of the README into docs.
"""

import argparse
import inspect
from functools import partial
from pathlib import Path

from fmus.export.component_page import page
from fmus.support.files import write_atomically
from motofmi.reports.chart_figures import figure
from motofmi.scenarios.does_the_rider_calm_the_wobble import chart, run
from motofmi.workflows import components

FIGURE = "root_locus.png"


def pages() -> dict[str, str]:
    """The pages by file name, with one that lists them."""
    shipped = [components.component(spec) for spec in components.every_name()]
    found = {
        f"{name}.md": page(kind, [c for c in shipped if type(c) is kind])
        for name, kind in components.COMPONENTS.items()
    }
    lines = [
        f"* [{name}]({name}.md): {(inspect.getdoc(kind) or '').splitlines()[0]}"
        for name, kind in components.COMPONENTS.items()
    ]
    introduction = (
        "The pages are rendered from the components by `python -m motofmi.scenarios.what_is_in_each_component`."
    )
    return {**found, "README.md": "\n\n".join(["# Components", introduction, "\n".join(lines)]) + "\n"}


def main(arguments: list[str] | None = None) -> None:
    parser = argparse.ArgumentParser(description="Write a page about every component.")
    parser.add_argument("folder", nargs="?", default="docs", help="default: docs")
    folder = Path(parser.parse_args(arguments).folder)
    for name, text in pages().items():
        print(write_atomically(folder / "components" / name, partial(Path.write_text, data=text, encoding="utf-8")))
    print(write_atomically(folder / FIGURE, draw_root_loci))


def draw_root_loci(path: Path) -> None:
    """Draw the figure of the README and the paper: the same bytes for the same numbers."""
    figure(chart(run())).savefig(path, dpi=110, metadata={"Software": None})


if __name__ == "__main__":
    main()
