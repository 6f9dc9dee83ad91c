"""The key of the cache: the same for the same, another for every change that could change an archive, none when in doubt."""

import importlib
import sys

import pytest

from fmus import Component, input, output, parameter
from fmus.export.build import build
from fmus.export.cache_key import cache_key
from fmus.export.compilers import host_compiler
from fmus.support.modules import load_module
from rider_fmu import riders

LAW = "def law(v):\n    print('law evaluated')\n    return {gain} * v.force\n"
SPRING = '''
from fmus import Component, input, output
from law_of_spring import law

class Spring(Component):
    """Spring."""
    force = input("N", "Force"{bound})
    answer = output("N", "Answer")
    def equations(self, v, m):
        return {{"answer": law(v)}}
'''


@pytest.fixture
def spring(tmp_path, monkeypatch):
    """spring(gain, bound): a component whose equation is a function of another file."""
    monkeypatch.syspath_prepend(tmp_path)
    monkeypatch.setattr(sys, "dont_write_bytecode", True)  # compiled files are distinguished by size and second only

    def written(gain, bound=""):
        (tmp_path / "law_of_spring.py").write_text(LAW.format(gain=gain))
        (tmp_path / "spring_of_user.py").write_text(SPRING.format(bound=bound))
        for name in ("law_of_spring", "spring_of_user"):
            sys.modules.pop(name, None)
        importlib.invalidate_caches()
        return load_module(tmp_path / "spring_of_user.py").Spring("spring")

    yield written
    for name in ("law_of_spring", "spring_of_user"):
        sys.modules.pop(name, None)


def test_equal_components_have_one_key():
    assert cache_key(riders.load("mean_2011")) == cache_key(riders.load("mean_2011")) is not None


def test_values_names_and_effects_are_in_it():
    rider = riders.load("mean_2011")
    other = riders.load("mean_2011")
    other.source += " "
    hardening = riders.load("mean_2011").with_effects(*(e() for e in riders_effects()[:1]))
    changed = [rider.with_values(arm_damping=20.0), riders.load("1_2011"), other, hardening]
    assert len({cache_key(c) for c in (rider, *changed)}) == 5 and None not in map(cache_key, changed)


def riders_effects():
    effects = importlib.import_module("rider_fmu.effects.arms")
    return [c for c in vars(effects).values() if isinstance(c, type) and c.__module__ == effects.__name__]


def test_the_text_of_every_file_that_the_equations_reach_is_in_it(spring):
    first = cache_key(spring(2))
    assert first == cache_key(spring(2)) is not None
    assert cache_key(spring(3)) != first  # another file than the component's
    assert cache_key(spring(2, ", max=5")) not in (None, first)


def test_what_cannot_be_read_from_files_has_none():
    def made_inside(gain):
        class Spring(Component):
            force = input("N", "Force")
            answer = output("N", "Answer")

            def equations(self, v, m):
                return {"answer": gain * v.force}

        return Spring("spring")

    assert cache_key(made_inside(2)) is None
    written_nowhere = {"Component": Component, "parameter": parameter, "__name__": "written_nowhere"}
    exec(
        "class Empty(Component):\n    gain = parameter('1', 'Gain')\n    def equations(self, v, m): return {}",
        written_nowhere,
    )
    assert cache_key(written_nowhere["Empty"]("empty")) is None


@pytest.mark.slow
@pytest.mark.skipif(host_compiler() is None, reason="no C compiler on this machine")
def test_a_second_build_derives_nothing_and_a_changed_equation_is_another_archive(spring, tmp_path, capsys):
    first = build(spring(2), tmp_path / "one")
    changed = build(spring(3), tmp_path / "other")
    assert changed.sha256 != first.sha256
    again = spring(2)
    assert "law evaluated" in capsys.readouterr().out
    assert build(again, tmp_path / "two").sha256 == first.sha256
    assert "law evaluated" not in capsys.readouterr().out
