"""The reference pages that come from the code: written before the build reads its sources, into
docs/reference/rendered."""

from functools import partial
from pathlib import Path
from typing import Any

from extension import (
    accuracy,
    api,
    catalogue,
    commands,
    couplings,
    figures,
    formats,
    schemas,
    signatures,
    system_signatures,
    verdict,
)
from motofmi.scenarios.what_is_in_each_component import FIGURE, draw_root_loci

PAGES = {
    "accuracy": accuracy.accuracy,
    "api": api.page,
    "commands": commands.page,
    "costs": accuracy.costs,
    "couplings": couplings.page,
    "effects": catalogue.effects,
    "formats": formats.page,
    "schemas": schemas.page,
    "values": catalogue.values,
    "verdict": verdict.page,
}

FIGURES = {"signs.svg": figures.signs, "coupling_errors.svg": figures.coupling_errors}


def write(app: Any) -> None:
    """Write every page that differs from what is there, so that an unchanged one is not built again."""
    folder = Path(app.srcdir) / "reference" / "rendered"
    folder.mkdir(exist_ok=True)
    pictures = {
        f"signature_{family}.svg": partial(kind.picture, effects)
        for kind in (signatures, system_signatures)
        for family, effects in kind.forms().items()
    }
    pages = {f"{name}.md": page for name, page in PAGES.items()}
    for name, page in {**pages, **pictures, **FIGURES}.items():
        file, text = folder / name, page()
        if not file.exists() or file.read_text("utf-8") != text:
            file.write_text(text, "utf-8")


def draw(app: Any) -> None:
    """Draw the figure of README and paper, which stands in the repository, again where it differs."""
    drawn = Path(app.srcdir) / "reference" / "rendered" / FIGURE
    draw_root_loci(drawn)
    if (kept := Path(app.srcdir) / FIGURE).read_bytes() != drawn.read_bytes():
        kept.write_bytes(drawn.read_bytes())


def setup(app: Any) -> dict[str, bool]:
    app.connect("builder-inited", write)
    app.connect("builder-inited", draw)
    return {"parallel_read_safe": True}
