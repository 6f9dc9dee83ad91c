"""Results as a notebook shows them: axes to draw on, and HTML of a sentence, a table and a small figure.

matplotlib is imported when something is drawn, because the import takes longer than most commands run.
"""

import base64
import io
from collections.abc import Callable, Sequence
from html import escape
from importlib import import_module
from typing import Any

SIZE = (5.0, 3.2)  # in, of a figure beside a table


def new_axes(rows: int = 1, columns: int = 1, **options: Any) -> Any:
    """The axes of a new figure of pyplot, which a notebook shows: one, or an array of them. options as of
    `pyplot.subplots`.
    """
    _, axes = import_module("matplotlib.pyplot").subplots(rows, columns, **{"layout": "constrained", **options})
    return axes


def html(
    text: str,
    headings: Sequence[str] = (),
    rows: Sequence[Sequence[object]] = (),
    draw: Callable[[Any], object] | None = None,
) -> str:
    """HTML of a sentence, of rows under headings, and of the figure that `draw` makes on the axes which it is given."""
    head = "".join(f"<th>{escape(heading)}</th>" for heading in headings)
    body = "".join("<tr>" + "".join(f"<td>{escape(str(cell))}</td>" for cell in row) + "</tr>" for row in rows)
    table = f"<table><tr>{head}</tr>{body}</table>" if rows else ""
    return f"<p>{escape(text)}</p>{table}{_image(draw, text) if draw else ''}"


def _image(draw: Callable[[Any], object], words: str) -> str:
    figure = import_module("matplotlib.figure").Figure(figsize=SIZE, layout="constrained")
    draw(figure.subplots())
    buffer = io.BytesIO()
    figure.savefig(buffer, format="png", dpi=100)
    return f'<img alt="{escape(words)}" src="data:image/png;base64,{base64.b64encode(buffer.getvalue()).decode()}">'
