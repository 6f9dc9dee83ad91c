"""Results that are derived once for each structure of a component."""

import gc
import weakref

import pytest

from fmus.equations import by_structure
from fmus.equations.by_structure import once_per_structure
from fmus.mechanisms import MassSpringDamper, Pendulum


@pytest.fixture
def derived():
    """A function that is kept, and the components for which it was called."""
    called = []

    @once_per_structure
    def states(component):
        called.append(component)
        return component.states

    return states, called


def test_components_that_differ_in_values_alone_share_a_result(derived):
    states, called = derived
    for mass in (1.0, 2.0):
        assert states(MassSpringDamper(mass=mass)) == MassSpringDamper().states
    assert states(Pendulum()) == Pendulum().states
    assert [type(c) for c in called] == [MassSpringDamper, Pendulum]


def test_the_results_of_the_latest_structures_are_kept_and_no_others(derived, monkeypatch):
    states, called = derived
    monkeypatch.setattr(by_structure, "KEPT", 2)
    forms = [type("Form", (Pendulum,), {}) for _ in range(3)]
    for index in (0, 1, 0, 2, 0, 1):  # the third one takes the place of the second
        states(forms[index]())
    assert [forms.index(type(c)) for c in called] == [0, 1, 2, 1]
    assert len(states.kept) == 2


def test_a_structure_that_is_not_kept_is_released(derived, monkeypatch):
    states, called = derived
    monkeypatch.setattr(by_structure, "KEPT", 1)
    form = type("Form", (Pendulum,), {})
    reference = weakref.ref(form)
    states(form())
    states(Pendulum())
    del form
    called.clear()
    gc.collect()
    assert reference() is None


def test_an_error_is_not_kept():
    @once_per_structure
    def refused(component):
        raise ValueError(component.name)

    for _ in range(2):
        with pytest.raises(ValueError, match="Pendulum"):
            refused(Pendulum())
    assert not refused.kept
