"""The pages about the components: committed as rendered, and equations that are those that run."""

from pathlib import Path

import pytest
import sympy
from test_component import Pendulum

from fmus.documentation import page, read
from fmus.symbolic import symbolic
from rider_fmu import PassiveRider
from scenarios.write_the_documentation import main, pages
from vehicle_fmu import DAMPERS, VEHICLES

FOLDER = Path(__file__).parent.parent / "docs" / "components"
PAGES = pages()


@pytest.mark.parametrize("name", PAGES)
def test_the_committed_page_is_the_rendered_one(name):
    assert (FOLDER / name).is_file(), "run python -m scenarios.write_the_documentation"
    assert (FOLDER / name).read_text("utf-8") == PAGES[name], "run python -m scenarios.write_the_documentation"


def test_no_page_is_left_over():
    assert {p.name for p in FOLDER.iterdir()} == set(PAGES)


@pytest.mark.parametrize("kind", [PassiveRider, *VEHICLES.values(), *DAMPERS.values()], ids=lambda k: k.__name__)
def test_the_steps_put_together_are_the_equations_that_run(kind):
    reading, form = read(kind()), symbolic(kind())
    steps = {sympy.Symbol(n, real=True): e for n, e in reading.definitions.items()}

    def whole(expression):
        while expression.free_symbols & steps.keys():
            expression = expression.subs(steps)
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


def test_pages_are_written_into_a_folder(tmp_path, capsys):
    main([str(tmp_path)])
    assert {p.name: p.read_text("utf-8") for p in (tmp_path / "components").iterdir()} == PAGES
    assert (tmp_path / "root_locus.png").read_bytes().startswith(b"\x89PNG")
    assert capsys.readouterr().out.count("\n") == len(PAGES) + 1
