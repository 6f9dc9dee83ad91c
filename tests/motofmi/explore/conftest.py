"""The explore page, written once, in a browser."""

import pytest

import motofmi as mf
from tests.browser import chromium
from tests.explore_page import Opened


@pytest.fixture(scope="module")
def browser():
    with chromium() as opened:
        yield opened


@pytest.fixture(scope="session")
def written(tmp_path_factory):
    return mf.explore(out=tmp_path_factory.mktemp("page") / "explore.html")


@pytest.fixture
def page(browser, written):
    opened = Opened(browser, written.path)
    yield opened
    opened.window.close()
    assert opened.complaints == []
