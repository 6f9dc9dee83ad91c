"""The pages about the components: committed as rendered, and equations that are those that run."""


import pytest
import sympy

from fmus.equations.sympy_form import symbolic
from fmus.export.component_page import page, read
from motofmi.scenarios.what_is_in_each_component import main
from rider_fmu import PassiveRider
from tests import ROOT, as_study
from tests.fmus.declaration.test_component import Pendulum
from vehicle_fmu import DAMPERS, VEHICLES

FOLDER = ROOT / "docs" / "components"


@pytest.mark.slow
def test_the_committed_pages_are_those_that_are_written(tmp_path, capsys):
    """One test, so that the pages are rendered once, however the tests are spread over workers."""
    main([str(tmp_path)])
    written, committed = (
        {p.name: p.read_text("utf-8") for p in folder.iterdir()} for folder in (tmp_path / "components", FOLDER)
    )
    assert set(written) == set(committed), "run python -m motofmi.scenarios.what_is_in_each_component"
    for name, text in written.items():
        assert text == committed[name], "run python -m motofmi.scenarios.what_is_in_each_component"
    assert (tmp_path / "root_locus.png").read_bytes().startswith(b"\x89PNG")
    assert capsys.readouterr().out.count("\n") == len(written) + 1


@pytest.mark.slow
@pytest.mark.parametrize("kind", [PassiveRider, *(as_study(k) if "Compliant" in k.__name__ else k for k in VEHICLES.values()), *DAMPERS.values()],
                         ids=lambda k: k.__name__)
def test_the_steps_put_together_are_the_equations_that_run(kind):
    reading, form = read(kind()), symbolic(kind())
    steps = {sympy.Symbol(n, real=True): e for n, e in reading.definitions.items()}

    def whole(expression):
        while expression.free_symbols & steps.keys():
            expression = expression.xreplace(steps)
        return expression

    for n, expected in zip(kind().states, form.rates, strict=True):
        assert sympy.expand(whole(reading.results[f"der({n})"]) - expected) == 0
    for n, expected in zip(kind().outputs, form.outputs, strict=True):
        if n in reading.results:
            assert sympy.expand(whole(reading.results[n]) - expected) == 0
    for (row, column), entry in reading.mass.items():
        expected = form.mass[kind().states.index(row), kind().states.index(column)]
        assert sympy.expand(whole(entry) - expected) == 0


def test_a_page_has_the_equations_in_steps():
    text = page(Pendulum, [Pendulum("mine", "Somebody's table", stiffness=3.0)])
    assert r"T_s &= - q k" in text  # the local variable ...
    assert r"f_{\dot q} &= T_s + T" in text  # ... and not what it stands for
    assert r"M_{\dot q,\dot q} &= J" in text
    assert r"E &= \frac{q^{2} k}{2} + \frac{J \dot q^{2}}{2}" in text
    assert "| `stiffness` | $k$ | N.m/rad | 8 | 0 | 100 | Stiffness |" in text
    assert "* mine: Somebody's table" in text and "| $k$ [N.m/rad] | 3 |" in text
