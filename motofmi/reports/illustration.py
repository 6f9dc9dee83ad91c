"""A drawing that is no chart: SVG as text, with the script of `page/` that moves it."""

from dataclasses import dataclass


@dataclass(frozen=True)
class Illustration:
    """Markup of the project's own (no text of a user's file), and the name of its script, if it has one."""

    markup: str
    script: str = ""
