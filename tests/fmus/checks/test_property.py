"""Random valid model descriptions: the check never raises and never calls one faulty."""

from xml.sax.saxutils import quoteattr

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from fmus.checks.check import check
from tests.fmus.checks import bench

pytestmark = pytest.mark.slow

names = st.lists(st.text(st.characters(codec="utf-8", exclude_categories=("Cc", "Cs", "Zl", "Zp", "Zs", "Cn", "Co")), min_size=1, max_size=12),
                 min_size=1, max_size=12, unique=True)  # fmt: skip
numbers = st.floats(allow_nan=False, allow_infinity=False, width=32)
UNITS = ("N.m", "rad/s", "[furlong]", "a[/red]b", "°C")
FLOATS = {"2": "Real", "3": "Float64"}
# Causality and variability -> whether a start is required; those of any numeric type.
KINDS = {("parameter", "fixed"): True, ("parameter", "tunable"): True, ("input", "discrete"): True, ("output", "discrete"): False,
         ("local", "discrete"): False, ("local", "constant"): True, ("calculatedParameter", "fixed"): False}  # fmt: skip
TYPES = {"2": ("Real", "Integer", "Boolean", "String"), "3": ("Float64", "Float32", "Int8", "UInt64", "Int32", "Boolean", "String", "Enumeration")}


@st.composite
def variables(draw, version):
    """(name, type, causality, variability, attributes) of a random number of variables."""
    found = []
    for name in draw(names):
        kind = draw(st.sampled_from(TYPES[version]))
        causality, variability = draw(st.sampled_from(sorted(KINDS)))
        if kind in ("Real", "Float64", "Float32") and draw(st.booleans()):
            causality, variability = draw(st.sampled_from([("input", "continuous"), ("output", "continuous"), ("local", "continuous")]))
        found.append((name, kind, causality, variability, draw(attributes(kind, KINDS.get((causality, variability), causality == "input")))))
    return found


@st.composite
def attributes(draw, kind, started):
    low, middle, high = sorted(draw(st.lists(numbers, min_size=3, max_size=3)))
    if kind == "String":
        return {"start": draw(st.text(st.characters(codec="utf-8", categories=("L", "N")), max_size=8))} if started else {}
    if kind == "Boolean":
        return {"start": draw(st.sampled_from(("true", "false", "0", "1")))} if started else {}
    if kind == "Enumeration":
        return {"declaredType": "colour", **({"start": draw(st.sampled_from(("1", "-3")))} if started else {})}
    whole = kind not in ("Real", "Float64", "Float32")
    if whole:
        low, middle, high = sorted(draw(st.lists(st.integers(0, 100), min_size=3, max_size=3)))
    given = {"min": low, "max": high} if draw(st.booleans()) else {}
    if started:
        given["start"] = middle
    if not whole and draw(st.booleans()):
        given["unit"] = draw(st.sampled_from(UNITS))
    return {key: str(value) for key, value in given.items()}


@st.composite
def kinds(draw, version):
    """Kinds of an FMU with flags of early return, of which some combinations are permitted; clocks need event mode."""
    if version == "2":
        return '<ModelExchange modelIdentifier="bench" /><CoSimulation modelIdentifier="bench" />'
    provides = draw(st.booleans())
    flags = {"hasEventMode": True, "providesIntermediateUpdate": provides, "canReturnEarlyAfterIntermediateUpdate": provides and draw(st.booleans()),
             "mightReturnEarlyFromDoStep": draw(st.booleans())}  # fmt: skip
    words = " ".join(f'{name}="{str(value).lower()}"' for name, value in flags.items())
    offered = {"ModelExchange": "", "CoSimulation": words, "ScheduledExecution": ""}
    chosen = draw(st.sets(st.sampled_from(sorted(offered)), min_size=1))
    return "".join(f'<{kind} modelIdentifier="bench" {words} />' for kind, words in offered.items() if kind in chosen)


TIMES = st.floats(1e-3, 10)
INTERVALS = {"constant": True, "fixed": None, "tunable": None, "changing": False, "countdown": False, "triggered": False}  # in the description: must, may, must not


@st.composite
def clocks(draw):
    """Clocks, clocked variables with states among them, intermediate updates and binary data of FMI 3, and the
    outputs."""
    text, outputs, inputs = [], [], []
    for k in range(draw(st.integers(0, 3))):
        variability, reference = draw(st.sampled_from(sorted(INTERVALS))), 5000 + k
        timed = INTERVALS[variability] if INTERVALS[variability] is not None else draw(st.booleans())
        more = f'intervalDecimal="{draw(TIMES)!r}"' + (f' shiftDecimal="{draw(TIMES)!r}"' if draw(st.booleans()) else "") if timed else ""
        more += ' supportsFraction="true"' if not timed and draw(st.booleans()) else ""
        text.append(f'<Clock name="\u00a0clock {k}" valueReference="{reference}" causality="input" intervalVariability="{variability}" priority="{k}" {more} />')
        inputs.append(reference)
    if inputs and draw(st.booleans()):
        text.append(f'<Clock name="\u00a0ticks" valueReference="5100" causality="output" intervalVariability="triggered" clocks="{inputs[0]}" />')
        outputs.append(5100)
    for k, owner in enumerate(draw(st.lists(st.sampled_from(inputs), max_size=3)) if inputs else []):
        text.append(f'<Int32 name="\u00a0before {k}" valueReference="{5300 + k}" causality="local" clocks="{owner}" />'
                    f'<Int32 name="\u00a0state {k}" valueReference="{5200 + k}" causality="output" previous="{5300 + k}" clocks="{owner}" />')  # fmt: skip
        outputs.append(5200 + k)
    if draw(st.booleans()):
        data = draw(st.lists(st.binary(max_size=4), min_size=2, max_size=2))
        starts = "".join(f'<Start value="{one.hex()}" />' for one in data)
        text.append(f'<Binary name="\u00a0data" valueReference="5400" causality="input" mimeType="text/plain" maxSize="4"><Dimension start="2" />{starts}</Binary>'
                    '<Binary name="\u00a0result" valueReference="5401" causality="output" />')  # fmt: skip
        outputs.append(5401)
    if draw(st.booleans()):
        text.append('<Float64 name="\u00a0swift" valueReference="5500" causality="output" intermediateUpdate="true" />')
        outputs.append(5500)
    return text, outputs


def described(version, given, offered, clocked=((), ())):
    """A valid description of the variables, with kinds, units and structure; without binaries."""
    text = [f'<fmiModelDescription fmiVersion="{version}.0" modelName="m" {"guid" if version == "2" else "instantiationToken"}="t">', offered]
    text.append("<UnitDefinitions>" + "".join(f"<Unit name={quoteattr(u)}><BaseUnit /></Unit>" for u in UNITS) + "</UnitDefinitions>")
    if version == "3":
        text.append('<TypeDefinitions><EnumerationType name="colour"><Item name="a" value="1" /><Item name="b" value="-3" /></EnumerationType></TypeDefinitions>')
    text.append("<ModelVariables>")
    if version == "3":
        text.append('<Float64 name="\u00a0time" valueReference="4000" causality="independent" />')
    for i, (name, kind, causality, variability, extra) in enumerate(given):
        head = f'name={quoteattr(name)} valueReference="{i}" causality="{causality}" variability="{variability}"'
        values = dict(extra)
        if version == "2":
            text.append(f"<ScalarVariable {head}><{kind} {' '.join(f'{k}={quoteattr(v)}' for k, v in values.items())} /></ScalarVariable>")
        else:
            start = f"<Start value={quoteattr(values.pop('start'))} />" if kind == "String" and "start" in values else ""
            text.append(f"<{kind} {head} {' '.join(f'{k}={quoteattr(v)}' for k, v in values.items())}>{start}</{kind}>")
    text += clocked[0]
    text.append("</ModelVariables><ModelStructure>")
    outputs = [i for i, v in enumerate(given) if v[2] == "output"]
    unknowns = [i for i, v in enumerate(given) if v[2] in ("output", "calculatedParameter")]
    if version == "2":
        for name, listed in (("Outputs", outputs), ("InitialUnknowns", unknowns)):
            if listed:
                text.append(f"<{name}>" + "".join(f'<Unknown index="{i + 1}" />' for i in listed) + f"</{name}>")
    else:
        unclocked = [r for r in clocked[1] if r in (5401, 5500)]
        text += [f'<Output valueReference="{i}" />' for i in [*outputs, *clocked[1]]]
        text += [f'<ClockedState valueReference="{i}" />' for i in clocked[1] if 5200 <= i < 5300]
        text += [f'<InitialUnknown valueReference="{i}" />' for i in [*unknowns, *unclocked]]
    return "\n".join([*text, "</ModelStructure></fmiModelDescription>"])


@pytest.mark.parametrize("version", ["2", "3"])
def test_a_valid_description_has_no_error(version, tmp_path_factory):
    folder = tmp_path_factory.mktemp("valid")

    @settings(max_examples=40)
    @given(variables(version), kinds(version), clocks() if version == "3" else st.just(((), ())))
    def property_holds(given, offered, clocked):
        xml = described(version, given, offered, clocked)
        found = check(bench.written(folder / "valid.fmu", xml), other_tools=False)
        assert [p for p in found if p.severity == "error"] == []

    property_holds()


@pytest.mark.parametrize("version", ["2", "3"])
def test_a_damaged_description_raises_nothing(version, tmp_path_factory):
    """Any part of a valid description cut out or repeated: whatever it is called, the check returns."""
    folder = tmp_path_factory.mktemp("damaged")

    @settings(max_examples=40)
    @given(variables(version), st.floats(0, 1), st.integers(0, 80), st.text(max_size=5))
    def property_holds(given, place, length, text):
        xml = described(version, given, '<ModelExchange modelIdentifier="bench" /><CoSimulation modelIdentifier="bench" />')
        at = int(place * len(xml))
        damaged = xml[:at] + text.replace("\ud800", "") + xml[at + length :]
        assert isinstance(check(bench.written(folder / "damaged.fmu", damaged.encode("utf-8", "replace")), other_tools=False), list)

    property_holds()
