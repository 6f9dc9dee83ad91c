"""The benchmark of effects outside the library: its simulator, and how answers are counted."""

import numpy as np
import pytest

from benchmarks.gap_outside_library import run, summary
from fmus.effects import unspecified_law
from fmus.effects.library import declared_by
from tests.simulators.outside_library_cases import FORMS, LAWS, OutsideMachine, kind_of
from tests.simulators.real_like_cases import Machine


@pytest.mark.slow
def test_the_law_has_the_size_that_was_asked_for():
    machine = OutsideMachine(np.random.default_rng(3), "imposed", "product", "bump", 0.2, 0.1)
    same = np.random.default_rng(3)
    linear = Machine(same, "imposed", "none", "none", 0.0)
    made = linear.motion(linear.drive(same))
    first, second = (linear.beyond_linear(made, law) for law in (machine.law, machine.second))
    assert first == pytest.approx(0.1 * made[2].std(), rel=1e-9) and second == pytest.approx(0.2 * first, rel=1e-9)


def test_every_law_has_a_form_with_which_the_library_compares():
    compared = {law.form for law in declared_by(unspecified_law)}
    assert all(FORMS[kind_of(law)] <= compared for law in LAWS)


def test_names_and_laws_are_counted():
    row = {"hidden": "blunt_product", "names": [], "law": "", "verdict": "unknown"}
    rates = summary([row, row | {"law": "product"}, row | {"law": "thinning"},
                     row | {"verdict": "named", "names": ["drift"]}])["rates"]  # fmt: skip
    assert {name: rate["rate"] for name, rate in rates.items()} == {
        "nothing named": 0.75, "a name": 0.25, "the law stated": 0.25, "another law stated": 0.25,
    }  # fmt: skip


@pytest.mark.study
def test_a_case_is_not_run_again(tmp_path):
    first = run(lambda items, _: items, cases=1, seed=5, out=tmp_path)
    assert first["cases"] == 1
    assert run(lambda items, _: items, cases=1, seed=5, out=tmp_path) == first
