"""A headless Chromium of the system, driven with Playwright; tests without either are skipped with the reason."""

import shutil
from collections.abc import Iterator
from contextlib import contextmanager
from importlib.util import find_spec

import pytest

NAMES = ("chromium", "chromium-browser", "google-chrome")
OPTIONS = (
    "--no-sandbox", "--disable-gpu", "--disable-quic", "--no-first-run", "--disable-background-networking",
    "--disable-component-update", "--disable-sync",
)  # fmt: skip
EXECUTABLE = next((found for name in NAMES if (found := shutil.which(name))), None)
needs_browser = pytest.mark.skipif(
    EXECUTABLE is None or find_spec("playwright") is None,
    reason="needs a Chromium on the search path and playwright (pip install motofmi[dev])",
)


@contextmanager
def chromium() -> Iterator:
    """A browser without a window and with a profile of its own."""
    from playwright.sync_api import sync_playwright  # noqa: PLC0415 - where it is installed

    with sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=EXECUTABLE, headless=True, args=list(OPTIONS))
        try:
            yield browser
        finally:
            browser.close()
