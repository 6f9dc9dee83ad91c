"""The pictures of pages in docs/: the explore page at both widths and color schemes, the first screens of the tour's
report and of its gap report, in the system's Chromium.

python -m tests.screens
"""

import tempfile
from pathlib import Path

import motofmi as mf
from motofmi.workflows.tour import tour
from tests import ROOT
from tests.pages import opened

SCREENS = {"report.html": "tour_report.png", "gap/report.html": "gap_report.png"}
# picture: width [px], color scheme, what the page shows
EXPLORE = {
    "explore_page.png": (1280, "light", "#view=locus&speed=45&A=sharp_1971;none&B=sharp_1971;mean_2011"),
    "explore_page_narrow.png": (390, "dark", "#view=speed&speed=30&A=sharp_1971;none&B=sharp_1994;mean_2011"),
}
HEIGHT = 1480  # px, of the narrow picture: charts and readings


def main() -> None:
    """Make the pages in a temporary folder and write the pictures."""
    with tempfile.TemporaryDirectory() as folder:
        page = mf.explore(out=Path(folder) / "explore.html").path
        for picture, (width, scheme, address) in EXPLORE.items():
            write(page, ROOT / "docs" / picture, width, scheme, address)
        report = tour(Path(folder) / "tour").report
        for page_of, picture in SCREENS.items():
            write(report.parent / page_of, ROOT / "docs" / picture)


def write(page_file: Path, picture: Path, width: int = 1280, scheme: str = "light", address: str = "") -> None:
    """Write the first screen of a page; of a narrow one more than that."""
    with opened(page_file, width, scheme) as (page, _):
        if address:
            page.goto(page_file.resolve().as_uri() + address)
            page.reload()
            page.wait_for_selector("#charts svg")
        if width < HEIGHT / 2:
            page.set_viewport_size({"width": width, "height": HEIGHT})
        page.screenshot(path=picture)
    print(picture)


if __name__ == "__main__":
    main()
