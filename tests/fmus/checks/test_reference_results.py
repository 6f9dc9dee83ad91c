"""Reference results in archives: replayed without a deviation, and deviations that are found."""

import json
import zipfile
from pathlib import Path

import pytest

from fmus.checks.replay.replayed import replayed
from fmus.export.build import build
from fmus.export.reference_folder import FOLDER
from tests import sampled
from tests.importer import COMPONENTS


@pytest.fixture(scope="module")
def contents(tmp_path_factory, cache):
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("MOTOFMI_CACHE", str(cache))
        path = build(COMPONENTS["rider"](), tmp_path_factory.mktemp("rider")).path
    with zipfile.ZipFile(path) as archive:
        return {name: archive.read(name) for name in archive.namelist()}


def problems(contents, folder: Path):
    for name, data in contents.items():
        (folder / name).parent.mkdir(parents=True, exist_ok=True)
        (folder / name).write_bytes(data)
    return list(replayed(folder))


@pytest.mark.slow
@pytest.mark.parametrize("fmi", [2, 3])
@pytest.mark.parametrize("name", sampled(COMPONENTS, 6))
def test_our_archives_meet_their_references(name, fmi, tmp_path):
    with zipfile.ZipFile(build(COMPONENTS[name](), tmp_path, fmi=fmi).path) as archive:
        archive.extractall(tmp_path / "unpacked")
    assert list(replayed(tmp_path / "unpacked")) == []


@pytest.mark.slow
def test_a_result_that_differs_is_found(contents, tmp_path):
    rows = contents[f"{FOLDER}/results.csv"].decode().splitlines()
    header, last = rows[0].split(","), rows[-1].split(",")
    column = header.index("handlebar_torque [N.m]")
    last[column] = repr(1.001 * float(last[column]))
    changed = {**contents, f"{FOLDER}/results.csv": "\n".join([*rows[:-1], ",".join(last)]).encode()}
    (found,) = problems(changed, tmp_path)
    assert found.severity == "error" and found.message.startswith("handlebar_torque is ") and "at 0.2 s" in found.message


@pytest.mark.slow
def test_a_mode_that_differs_is_found(contents, tmp_path):
    modes = json.loads(contents[f"{FOLDER}/modes.json"])
    modes["modes"][0]["damping_ratio"] += 1e-4
    (found,) = problems({**contents, f"{FOLDER}/modes.json": json.dumps(modes).encode()}, tmp_path)
    assert found.severity == "error" and "the mode of" in found.message


@pytest.mark.slow
def test_what_cannot_be_replayed_is_a_warning(contents, tmp_path):
    absent = {name: data for name, data in contents.items() if not name.endswith("inputs.csv")}
    assert {p.severity for p in problems(absent, tmp_path)} == {"warning"}
    (tmp_path / "other").mkdir()
    broken = {**contents, f"{FOLDER}/experiment.json": b"{", f"{FOLDER}/modes.json": b'{"modes": 1, "tolerance": 1}'}
    assert [p.severity for p in problems(broken, tmp_path / "other")] == ["warning"]
