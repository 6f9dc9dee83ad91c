"""Files of recordings, written for a test."""

import pytest


@pytest.fixture
def write(tmp_path):
    def put(lines, name="run.csv"):
        path = tmp_path / name
        path.write_text("\n".join(lines) + "\n")
        return path

    return put
