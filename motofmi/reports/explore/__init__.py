"""The page of `motofmi explore`: one HTML file with scripts, styles and compiled components inside.

The scripts are small files with functions of their own, written into the page in the order of `SCRIPTS`.
"""

import json
from collections.abc import Mapping
from html import escape
from pathlib import Path
from typing import Any

from fmus.support.files import write_text
from motofmi.reports.charts import COLOURS
from motofmi.reports.root_locus import MODE_COLOURS

FOLDER = Path(__file__).parent
MODULES = FOLDER / "modules"  # compiled classes of components, see motofmi/workflows/explore_modules.py
SCRIPTS = (
    "vendor/ml-matrix-6.15.1.umd.js", "fmu.js", "ports.js", "linear.js", "eigen.js", "eigenvalues.js", "tracking.js",
    "mode_shapes.js", "naming.js", "flexible_naming.js", "mode_curves.js", "settings.js",
    "axes.js", "charts.js", "shape.js", "animation.js", "cosimulation.js", "live.js", "controls.js", "main.js",
)  # fmt: skip
LARGEST = 2_000_000  # bytes


def write_page(path: Path, data: Mapping[str, Any], title: str) -> None:
    """Write the page with its data. Raises InputError if it cannot be written."""
    text = (FOLDER / "page.html").read_text("utf-8")
    scripts = "\n".join((FOLDER / name).read_text("utf-8").partition("//# sourceMappingURL")[0] for name in SCRIPTS)
    parts = {
        "title": escape(title),
        "style": (FOLDER / "style.css").read_text("utf-8") + colours_of_modes(),
        "data": json.dumps(data, separators=(",", ":")).replace("</", "<\\/"),
        "scripts": scripts.replace("</script", "<\\/script"),
        "licence": escape((FOLDER / "vendor/ml-matrix-LICENSE.txt").read_text("utf-8")),
    }
    for name, content in parts.items():
        text = text.replace(f"<!-- {name} -->", content)
    write_text(path, text)


def colours_of_modes() -> str:
    """The colours of the modes, light and dark, as variables of the style sheet."""
    light, dark = (
        " ".join(f"--{mode.replace('_', '-')}: {COLOURS[colour][k]};" for mode, colour in MODE_COLOURS.items())
        for k in range(2)
    )
    return f":root {{ {light} }}\n@media screen and (prefers-color-scheme: dark) {{ :root {{ {dark} }} }}\n"
