"""Unknown names are answered with the most similar one."""

import pytest

from fmus.support.errors import unknown

COMPONENTS = ["damper:inerter", "mechanism:pendulum", "rider:mean_2011", "roll"]


@pytest.mark.parametrize("given, meant", [
    ("pendul", "mechanism:pendulum"),
    ("mechanism:pendul", "mechanism:pendulum"),
    ("rol", "roll"),
])  # fmt: skip
def test_the_most_similar_name_is_given_with_its_kind(given, meant):
    assert f"unknown component '{given}', did you mean '{meant}'?" in str(unknown("component", given, COMPONENTS))


def test_no_name_is_guessed_where_none_is_similar():
    assert str(unknown("mode", "xyz", ["weave", "capsize"])) == "unknown mode 'xyz' (valid: capsize, weave)"
