"""What axe-core finds wrong with a page in the browser (WCAG 2.1 and axe's best practices)."""

from importlib.resources import files
from importlib.util import find_spec

import pytest

HAS_AXE = find_spec("axe_playwright_python") is not None
needs_axe = pytest.mark.skipif(not HAS_AXE, reason="needs axe-playwright-python (pip install motofmi[dev])")
RUN = """async () => (await axe.run({resultTypes: ["violations"]})).violations.flatMap(v => v.nodes.map(n =>
  `${v.id} (${v.impact}): ${n.target.join(" ")}: ${n.failureSummary.split("\\n").slice(1, 2).join("").trim()}`))"""


def violations(window) -> list[str]:
    """Rule, severity, element and reason of every violation in an opened page."""
    window.evaluate(files("axe_playwright_python").joinpath("axe.min.js").read_text("utf-8"))
    return window.evaluate(RUN)
