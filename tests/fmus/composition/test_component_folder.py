"""A component is added by one file in a folder: it is registered, loads from a value file, and needs no edit
elsewhere.
"""

import sys

import pytest

from fmus import InputError
from fmus.composition.component_folder import components_in
from fmus.composition.value_files import Library

GEARBOX = '''
from fmus import Component, input, output, parameter


class Ratio(Component):
    """Base without equations."""

    ratio = parameter("1", "Ratio", start=2.0)


class _Hidden(Ratio):
    """Private."""

    def equations(self, v, m):
        return {}


class Gearbox(Ratio):
    """Gearbox without inertia."""

    torque = input("N.m", "Torque")
    driven_torque = output("N.m", "Torque times ratio")

    def equations(self, v, m):
        return {"driven_torque": v.ratio * v.torque}
'''


@pytest.fixture
def package(tmp_path, monkeypatch):
    """The name of a package with one component file, and the way to add another."""
    name = f"drives_{tmp_path.name}".replace("-", "_")
    folder = tmp_path / name
    folder.mkdir()
    (folder / "__init__.py").write_text("")
    (folder / "gearbox.py").write_text(GEARBOX)
    monkeypatch.syspath_prepend(str(tmp_path))
    yield name, folder
    for module in [m for m in sys.modules if m.partition(".")[0] == name]:
        del sys.modules[module]


def test_a_file_in_the_folder_is_a_component_of_the_registry(package, tmp_path):
    name, _ = package
    found = components_in(name)
    assert list(found) == ["Gearbox"]  # not the base without equations, nor the private class
    (tmp_path / "two.toml").write_text('component = "Gearbox"\nsource = "a test"\n[parameters]\nratio = 3.0\n')
    loaded = Library("drive", tmp_path, found).load("two")
    assert loaded.values == {"ratio": 3.0}


def test_a_name_that_two_files_define_is_an_error_that_names_both(package):
    name, folder = package
    (folder / "other.py").write_text(GEARBOX)
    with pytest.raises(InputError, match=rf"Gearbox is defined in {name}.gearbox and in {name}.other"):
        components_in(name)
