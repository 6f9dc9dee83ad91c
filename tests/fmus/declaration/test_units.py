"""Units against the definitions of the SI and against each other."""

from math import pi

import pytest
from hypothesis import given
from hypothesis import strategies as st

from fmus.declaration.units import DISPLAY, SYMBOLS, convert, unit
from fmus.support.errors import InputError

# Factor and exponents of kg, m, s, A, K, rad, from the definitions of the units (SI brochure, Tables 4 and 8).
DEFINITIONS = {
    "N.m.s/rad": (1.0, (1, 2, -1, 0, 0, -1)),
    "kg.m2": (1.0, (1, 2, 0, 0, 0, 0)),
    "m/s2": (1.0, (0, 1, -2, 0, 0, 0)),
    "km/h": (1000 / 3600, (0, 1, -1, 0, 0, 0)),
    "rpm": (2 * pi / 60, (0, 0, -1, 0, 0, 1)),
    "N.m/deg": (180 / pi, (1, 2, -2, 0, 0, -1)),
    "mV": (1e-3, (1, 2, -3, -1, 0, 0)),
    "g.mm2": (1e-9, (1, 2, 0, 0, 0, 0)),
    "1/s": (1.0, (0, 0, -1, 0, 0, 0)),
    "1": (1.0, (0, 0, 0, 0, 0, 0)),
    "%": (0.01, (0, 0, 0, 0, 0, 0)),
    "N.m.s2/rad2": (1.0, (1, 2, 0, 0, 0, -2)),
    # as laboratories write them
    "°": (pi / 180, (0, 0, 0, 0, 0, 1)),
    "°/s": (pi / 180, (0, 0, -1, 0, 0, 1)),
    "mN.m": (1e-3, (1, 2, -2, 0, 0, 0)),
    "N·m": (1.0, (1, 2, -2, 0, 0, 0)),
    "N-m": (1.0, (1, 2, -2, 0, 0, 0)),
    "N m": (1.0, (1, 2, -2, 0, 0, 0)),
    "m s-2": (1.0, (0, 1, -2, 0, 0, 0)),
    "m/s²": (1.0, (0, 1, -2, 0, 0, 0)),
    "µm": (1e-6, (0, 1, 0, 0, 0, 0)),
    "μs": (1e-6, (0, 0, 1, 0, 0, 0)),
    "mA": (1e-3, (0, 0, 0, 1, 0, 0)),
    "Ohm": (1.0, (1, 2, -3, -2, 0, 0)),
    "V.s/A": (1.0, (1, 2, -2, -2, 0, 0)),
    "H": (1.0, (1, 2, -2, -2, 0, 0)),
    "mH": (1e-3, (1, 2, -2, -2, 0, 0)),
    "rev/min": (2 * pi / 60, (0, 0, -1, 0, 0, 1)),
    "bar.cm2": (10.0, (1, 1, -2, 0, 0, 0)),
    "kPa": (1e3, (1, -1, -2, 0, 0, 0)),
    "kHz": (1e3, (0, 0, -1, 0, 0, 0)),
    # NIST Special Publication 811, Appendix B.8
    "ft": (0.3048, (0, 1, 0, 0, 0, 0)),
    "in": (0.0254, (0, 1, 0, 0, 0, 0)),
    "lb": (0.45359237, (1, 0, 0, 0, 0, 0)),
    "lbf": (4.4482216152605, (1, 1, -2, 0, 0, 0)),
    "lbf.ft": (1.3558179483314004, (1, 2, -2, 0, 0, 0)),
    "kip": (4448.2216152605, (1, 1, -2, 0, 0, 0)),
    "kgf": (9.80665, (1, 1, -2, 0, 0, 0)),
    "psi": (4.4482216152605 / 0.0254**2, (1, -1, -2, 0, 0, 0)),
    "MPa": (1e6, (1, -1, -2, 0, 0, 0)),
    "mph": (0.44704, (0, 1, -1, 0, 0, 0)),
    "mi/h": (0.44704, (0, 1, -1, 0, 0, 0)),
    "slug": (4.4482216152605 / 0.3048, (1, 0, 0, 0, 0, 0)),
    "dps": (pi / 180, (0, 0, -1, 0, 0, 1)),
    "lb.ft2": (0.45359237 * 0.3048**2, (1, 2, 0, 0, 0, 0)),
}


@pytest.mark.parametrize("name", DEFINITIONS)
def test_a_unit_is_its_definition(name):
    factor, exponents = DEFINITIONS[name]
    assert unit(name).factor == pytest.approx(factor, rel=1e-15)
    assert unit(name).exponents == exponents


@pytest.mark.parametrize(
    "given, wanted, value",
    [("deg", "rad", pi), ("km/h", "m/s", 50.0), ("Nm", "N.m", 180.0), ("N.m/deg", "N.m/rad", 180 * 180 / pi)],
)
def test_conversions(given, wanted, value):
    assert convert(180.0, given, wanted) == pytest.approx(value, rel=1e-15)


@pytest.mark.parametrize(
    "written, symbols",
    [("RPM", "rpm"), ("Degrees/second", "deg/s"), ("N.inch", "N.in"), ("Volts", "V"), ("PSI", "psi"), ("ohms", "Ohm")],
)
def test_words_and_capitals_are_read_as_symbols(written, symbols):
    assert (unit(written).factor, unit(written).exponents) == (unit(symbols).factor, unit(symbols).exponents)


@pytest.mark.slow
@given(st.sampled_from(sorted(SYMBOLS)), st.sampled_from(sorted(SYMBOLS)), st.integers(1, 4), st.floats(-1e6, 1e6))
def test_there_and_back_is_the_same(first, second, power, value):
    name = f"{first}{power if first not in '1%' else ''}/{second}"
    in_si = unit(name).factor * value
    assert in_si / unit(name).factor == pytest.approx(value, rel=1e-14)
    product = [
        power * a - b if first not in "1%" else a - b
        for a, b in zip(SYMBOLS[first][1], SYMBOLS[second][1], strict=True)
    ]
    assert unit(name).exponents == tuple(product)


@pytest.mark.parametrize("name", ["furlong", "N.m/", "", "kg^", "kg-", "m//s2x", "mPa", "MNm", "S"])
def test_an_unknown_unit_is_named_with_the_known_symbols(name):
    with pytest.raises(InputError, match=r"known symbols: .*kg.*rad") as error:
        unit(name)
    assert f"[{name}]" in str(error.value) and "\n" not in str(error.value)


@pytest.mark.parametrize("name", ["degC", "°C", "degF", " degC "])
def test_a_temperature_with_an_offset_is_refused_with_the_unit_to_use(name):
    with pytest.raises(InputError, match=r"has an offset, which is not converted: use K, in the columns and in the"):
        unit(name)


def test_things_of_different_kinds_are_not_converted():
    with pytest.raises(InputError, match=r"\[deg\] cannot be converted to \[N\.m\]"):
        convert(1.0, "deg", "N.m")


@pytest.mark.parametrize("si, shown", DISPLAY.items())
def test_display_units_measure_the_same_thing(si, shown):
    assert unit(si).factor == 1.0
    assert unit(si).exponents == unit(shown).exponents
