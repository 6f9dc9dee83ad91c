"""What is in each component? Writes a page for every one of them into a folder.

    python -m scenarios.write_the_documentation            # into docs/components, and the README's picture into docs
"""

import argparse
import inspect
from functools import partial
from pathlib import Path

from fmus.documentation import page
from fmus.files import write_beside
from scenarios import does_the_rider_calm_the_wobble, names


def pages() -> dict[str, str]:
    """The pages by file name, with one that lists them."""
    shipped = [names.component(spec) for spec in names.every_name()]
    found = {f"{name}.md": page(kind, [c for c in shipped if type(c) is kind]) for name, kind in names.COMPONENTS.items()}
    lines = [f"* [{name}]({name}.md): {(inspect.getdoc(kind) or '').splitlines()[0]}" for name, kind in names.COMPONENTS.items()]
    introduction = "The pages are rendered from the components by `python -m scenarios.write_the_documentation`."
    return {**found, "README.md": "\n\n".join(["# Components", introduction, "\n".join(lines)]) + "\n"}


def main(arguments: list[str] | None = None) -> None:
    parser = argparse.ArgumentParser(description="Write a page about every component.")
    parser.add_argument("folder", nargs="?", default="docs", help="default: docs")
    folder = Path(parser.parse_args(arguments).folder)
    for name, text in pages().items():
        print(write_beside(folder / "components" / name, partial(Path.write_text, data=text, encoding="utf-8")))
    loci = does_the_rider_calm_the_wobble.figure(does_the_rider_calm_the_wobble.run(), ("reference", "rider", "damper"))
    print(write_beside(folder / "root_locus.png", lambda path: loci.savefig(path, dpi=110, metadata={"Software": None})))


if __name__ == "__main__":
    main()
