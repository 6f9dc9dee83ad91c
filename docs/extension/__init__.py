"""The reference pages that come from the code: written before the build reads its sources, into docs/reference/rendered."""

from pathlib import Path
from typing import Any

from extension import api, catalogue, commands, couplings, formats, schemas, verdict

PAGES = {"api": api.page, "commands": commands.page, "couplings": couplings.page, "effects": catalogue.effects,
         "formats": formats.page, "schemas": schemas.page, "values": catalogue.values, "verdict": verdict.page}  # fmt: skip


def write(app: Any) -> None:
    """Write every page that differs from what is there, so that an unchanged one is not built again."""
    folder = Path(app.srcdir) / "reference" / "rendered"
    folder.mkdir(exist_ok=True)
    for name, page in PAGES.items():
        file, text = folder / f"{name}.md", page()
        if not file.exists() or file.read_text("utf-8") != text:
            file.write_text(text, "utf-8")


def setup(app: Any) -> dict[str, bool]:
    app.connect("builder-inited", write)
    return {"parallel_read_safe": True}
