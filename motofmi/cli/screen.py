"""Printing of lines and tables, which are never truncated."""

import re
from collections.abc import Iterable, Mapping, Sequence
from typing import Any, NoReturn

import numpy as np
from rich.console import Console
from rich.table import Table

from motofmi.workflows.titles import system_title

WIDE = 100_000  # characters per line if the output is no terminal: lines and table rows are then not wrapped
# Text of a cell that starts with a number, or is a dash for a missing one
NUMBER = re.compile(r"[+-]?(\d+\.?\d*|\.\d+)(e[+-]?\d+)?([ ,%(]|$)|-?$")


class Screen(Console):
    """Standard output. Long lines and cells are wrapped on a terminal only. Text is printed without markup."""

    def __init__(self) -> None:
        super().__init__(highlight=False, markup=False, emoji=False)
        if not self.is_terminal:
            self.width = WIDE

    def on_broken_pipe(self) -> NoReturn:
        """The reader of a pipe has closed it, as in `| head`. Raises BrokenPipeError; the entry point ends the
        command."""
        raise BrokenPipeError

    def table(self, headings: Sequence[str], rows: Iterable[Sequence[str]], title: str = "") -> None:
        """Print a table; columns of numbers are aligned to the right."""
        cells = list(rows)
        table = Table(box=None, pad_edge=False)
        for k, heading in enumerate(headings):
            numeric = all(NUMBER.match(row[k]) for row in cells)
            table.add_column(heading, justify="right" if numeric else "left", overflow="fold")
        for row in cells:
            table.add_row(*row)
        if title:
            self.print(title)
        if self.is_terminal:
            self.print(table)
            return
        with self.capture() as captured:
            self.print(table)
        for line in captured.get().splitlines():  # without the blanks that fill the last column
            self.print(line.rstrip())

    def assumed(self, reasons: dict[str, str]) -> None:
        """Print the parameters with assumed values, and the reason for each value."""
        for parameter, reason in reasons.items():
            self.print(f"assumed: {parameter} ({reason})")

    def warnings(self, sentences: Iterable[str], what: str = "warning") -> None:
        """Print warnings or limitations of a result, one sentence a line."""
        for sentence in sentences:
            self.print(f"{what}: {sentence}", style="yellow")


def system(result: Mapping[str, Any]) -> str:
    """The vehicle and the device of a result, as in `sharp_1971 with mean_2011`."""
    return system_title(str(result["vehicle"]), str(result["device"]))


def grid_values(values: Sequence[float] | np.ndarray) -> list[str]:
    """The values of a grid as text, all with the fewest decimals (at most 6) that represent them exactly.

    >>> grid_values([11.25, 11.5])
    ['11.25', '11.50']
    """
    given = np.asarray(values, float)
    decimals = next((d for d in range(6) if np.allclose(np.round(given, d), given, rtol=1e-9, atol=1e-9)), 6)
    return [f"{value:.{decimals}f}" for value in given]
