"""The pictures of reports in docs/: the first screens of the tour's report and of its gap report, in the system's
Chromium.

python -m tests.screens
"""

import tempfile
from pathlib import Path

from motofmi.workflows.tour import tour
from tests import ROOT
from tests.pages import opened

SCREENS = {"report.html": "tour_report.png", "gap/report.html": "gap_report.png"}


def main() -> None:
    """Run the tour in a temporary folder and write the pictures."""
    with tempfile.TemporaryDirectory() as folder:
        report = tour(Path(folder) / "tour").report
        for page_of, picture in SCREENS.items():
            write(report.parent / page_of, ROOT / "docs" / picture)


def write(page_file: Path, picture: Path) -> None:
    """Write the first screen of a page."""
    with opened(page_file, 1280) as (page, _):
        page.screenshot(path=picture)
    print(picture)


if __name__ == "__main__":
    main()
