"""The couplings with their order and source."""

from extension.tables import table
from fmus.cosimulation.coupling import COUPLINGS

INTRODUCTION = """# Couplings

A coupling continues the inputs of the FMUs over a communication step. `motofmi cosimulate` predicts its error in frequency and damping
of each mode, and without `--coupling` takes the least costly one that meets the tolerance. The list begins with the cheapest.

"""


def page() -> str:
    rows = [(f"`{c.name}`", c.summary, c.order, c.source) for c in COUPLINGS.values()]
    return INTRODUCTION + table(("name", "inputs over a step", "order", "source"), rows)
