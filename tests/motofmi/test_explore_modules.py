"""The compiled modules that ship for the explore page: they are those of the present equations."""

import json
from importlib.util import find_spec

import pytest

from motofmi.workflows import components, explore_modules
from motofmi.workflows.explore_modules import MODULES, compiled, first, made_with, shipped, token_now, unpacked

TITLES = sorted(path.stem for path in MODULES.glob("*.json"))
LARGE = {"CompliantMotorcycle", "FullRider", "TouringMotorcycle"}  # their source code takes seconds


def recorded(title):
    return json.loads(explore_modules.path_of(title).read_text("utf-8"))


def as_recorded(title):
    """Skips where other versions of the generating packages give other bytes of the same equations."""
    if find_spec("ziglang") is None or made_with() != recorded(title)["made with"]:
        pytest.skip(f"needs the packages that the module was made with: {recorded(title)['made with']}")


@pytest.mark.slow
def test_every_module_has_the_variables_and_numbers_of_its_class():
    for title in TITLES:
        assert shipped(first(title)) is not None, f"{title}: run python -m motofmi.workflows.explore_modules"
        assert unpacked(recorded(title)).startswith(b"\0asm")


def test_a_module_of_other_equations_is_not_used(tmp_path, monkeypatch):
    damper, module = components.damper("low_2011"), recorded("LinearDamper")
    other = [{**point, "numbers": {k: 1.0001 * n for k, n in point["numbers"].items()}} for point in module["points"]]
    monkeypatch.setattr(explore_modules, "MODULES", tmp_path)
    assert shipped(damper) is None
    for change in ({}, {"outputs": ["other"]}, {"bounds": {}}, {"points": other}):
        (tmp_path / "LinearDamper.json").write_text(json.dumps({**module, **change}))
        assert (shipped(damper) is None) == bool(change)


def test_a_rider_with_an_effect_has_no_module(tmp_path):
    (tmp_path / "rider.toml").write_text('component = "PassiveRider"\neffects = ["hardening_stiffness.cubic"]\n')
    assert shipped(components.rider(str(tmp_path / "rider.toml"))) is None


@pytest.mark.slow
@pytest.mark.parametrize("title", [pytest.param(t, marks=pytest.mark.study) if t in LARGE else t for t in TITLES])
def test_a_module_is_of_the_present_source_code(title):
    as_recorded(title)
    assert recorded(title)["token"] == token_now(first(title)), "run python -m motofmi.workflows.explore_modules"


@pytest.mark.slow
@pytest.mark.parametrize("title", [t if t == "LinearDamper" else pytest.param(t, marks=pytest.mark.study) for t in TITLES])
def test_a_module_has_the_bytes_of_a_build(title, tmp_path, monkeypatch):
    as_recorded(title)
    monkeypatch.setenv("MOTOFMI_CACHE", str(tmp_path))
    assert unpacked(compiled(first(title))) == unpacked(recorded(title))
