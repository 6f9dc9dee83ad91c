"""The couplings with their order, stability and source."""

from extension import figures
from extension.tables import table

INTRODUCTION = """# Couplings

A coupling continues the inputs of the FMUs over a communication step. `motofmi cosimulate` predicts its error in
frequency and damping of each mode, and without `--coupling` takes the least costly one that meets the tolerance. The
list begins with the cheapest.

![Relative error of the damping ratio over the communication step, for every coupling](coupling_errors.svg)

The error in the damping ratio of the least damped mode of Sharp's motorcycle with the mean rider at 30 m/s. The
largest stable step in the table is that of the same system.

"""


def page() -> str:
    rows = [
        (
            f"`{c.name}`",
            c.summary,
            c.order,
            f"{1e3 * step:.3g} ms" if step < figures.LARGEST else f"from {step:g} s",
            c.source,
        )
        for c, step in figures.largest_stable_steps()
    ]
    return INTRODUCTION + table(("name", "inputs over a step", "order", "largest stable step", "source"), rows)
