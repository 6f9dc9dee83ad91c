"""SSP archives of other tools, one construct of the standard in each: values in files, mappings, prefixes, units,
transformations, nested systems, and what is refused."""

import zipfile

import numpy as np
import pytest

from fmus.cosimulation.cosimulate import cosimulate
from fmus.cosimulation.ssp import read_ssp
from fmus.support.errors import InputError
from tests.typed_fmu import typed_fmu

NAMES = {
    "xmlns:ssd": "http://ssp-standard.org/SSP1/SystemStructureDescription",
    "xmlns:ssc": "http://ssp-standard.org/SSP1/SystemStructureCommon",
    "xmlns:ssv": "http://ssp-standard.org/SSP1/SystemStructureParameterValues",
    "xmlns:ssm": "http://ssp-standard.org/SSP1/SystemStructureParameterMapping",
}
SPACES = " ".join(f'{name}="{uri}"' for name, uri in NAMES.items())
KMH = '<ssc:Unit name="km/h"><ssc:BaseUnit m="1" s="-1" factor="0.2777777777777778"/></ssc:Unit>'
CELSIUS = '<ssc:Unit name="degC"><ssc:BaseUnit K="1" offset="273.15"/></ssc:Unit>'


def parameters(body, version="1.0", units=""):
    return f'<ssv:ParameterSet {SPACES} version="{version}" name="p"><ssv:Parameters>{body}</ssv:Parameters>{units}</ssv:ParameterSet>'


def real(name, value, unit=""):
    return f'<ssv:Parameter name="{name}"><ssv:Real value="{value}"{f" unit={chr(34)}{unit}{chr(34)}" if unit else ""}/></ssv:Parameter>'


def mapping(body):
    return f'<ssm:ParameterMapping {SPACES} version="1.0">{body}</ssm:ParameterMapping>'


def bound(content="", **attributes):
    given = " ".join(f'{key}="{value}"' for key, value in attributes.items())
    return f"<ssd:ParameterBindings><ssd:ParameterBinding {given}>{content}</ssd:ParameterBinding></ssd:ParameterBindings>"


def inline(values):
    return f"<ssd:ParameterValues>{values}</ssd:ParameterValues>"


def component(name="a", bindings="", source="resources/a.fmu", more="", connectors=""):
    return (f'<ssd:Component name="{name}" source="{source}" {more}><ssd:Connectors>{connectors}</ssd:Connectors>'
            f"{bindings}</ssd:Component>")  # fmt: skip


def connection(start, end, inside="", **attributes):
    ends = {}
    for side, text in (("start", start), ("end", end)):
        element, _, name = text.rpartition(".")
        ends |= ({f"{side}Element": element} if element else {}) | {f"{side}Connector": name}
    given = " ".join(f'{key}="{value}"' for key, value in {**ends, **attributes}.items())
    return f"<ssd:Connection {given}>{inside}</ssd:Connection>"


def connector(name, kind, unit=""):
    return f'<ssd:Connector name="{name}" kind="{kind}"><ssc:Real{f" unit={chr(34)}{unit}{chr(34)}" if unit else ""}/></ssd:Connector>'


@pytest.fixture
def ssp(tmp_path):
    """Writes an archive of elements with FMUs a (m/s), b (km/h) and further files."""

    def write(elements, connections="", bindings="", files=None, version="1.0", units=KMH, connectors="", structure=None):
        path = tmp_path / "given.ssp"
        text = structure or (
            f'<ssd:SystemStructureDescription {SPACES} version="{version}" name="given"><ssd:System name="whole">'
            f"<ssd:Connectors>{connectors}</ssd:Connectors>{bindings}<ssd:Elements>{elements}</ssd:Elements>"
            f"<ssd:Connections>{connections}</ssd:Connections></ssd:System><ssd:Units>{units}</ssd:Units>"
            '<ssd:DefaultExperiment startTime="0" stopTime="0.5"/></ssd:SystemStructureDescription>'
        )
        with zipfile.ZipFile(path, "w") as archive:
            archive.writestr("SystemStructure.ssd", text)
            archive.write(typed_fmu(tmp_path / "a.fmu"), "resources/a.fmu")
            archive.write(typed_fmu(tmp_path / "b.fmu", "km/h"), "resources/b.fmu")
            for name, content in (files or {}).items():
                archive.writestr(name, content)
        return path

    return write


def outputs(path, **changed):
    """The outputs of every FMU of an archive by name."""
    with read_ssp(path, changed) as system:
        return {f"{n}.{o}": float(x) for n, f in system.fmus.items() for o, x in zip(f.outputs, f.exchange(f.present_inputs), strict=True)}


def test_values_from_a_file(ssp):
    files = {"resources/p.ssv": parameters(real("gain", 2) + real("u", 3))}
    assert outputs(ssp(component(bindings=bound(source="resources/p.ssv")), files=files))["a.y"] == 6.0


def test_a_file_that_is_missing_is_refused_by_name(ssp):
    with pytest.raises(InputError, match=r"given\.ssp: parameter binding of a: there is no resources/p\.ssv in the archive"):
        read_ssp(ssp(component(bindings=bound(source="resources/p.ssv"))))
    with pytest.raises(InputError, match=r"given\.ssp: a: there is no resources/c\.fmu in the archive"):
        read_ssp(ssp(component(source="resources/c.fmu")))
    missing = '<ssd:ParameterMapping source="m.ssm"/>'
    with pytest.raises(InputError, match=r"parameter mapping of a: there is no m\.ssm"):
        read_ssp(ssp(component(bindings=bound(inline(parameters("")) + missing))))


def test_a_file_inside_an_fmu(ssp, tmp_path):
    path = ssp(component(bindings=bound(source="extra/p.ssv", sourceBase="component")))
    inner = typed_fmu(tmp_path / "inner.fmu")
    with zipfile.ZipFile(inner, "a") as archive:
        archive.writestr("extra/p.ssv", parameters(real("gain", 4) + real("u", 1)))
    with zipfile.ZipFile(path) as archive:
        text = archive.read("SystemStructure.ssd").decode()
    with zipfile.ZipFile(path, "w") as archive:
        archive.writestr("SystemStructure.ssd", text)
        archive.write(inner, "resources/a.fmu")
    assert outputs(path)["a.y"] == 4.0


def test_values_at_the_system_with_and_without_a_prefix(ssp):
    whole = bound(inline(parameters(real("a.gain", 5) + real("a.u", 2))))
    assert outputs(ssp(component(), bindings=whole))["a.y"] == 10.0
    prefixed = bound(inline(parameters(real("gain", 5) + real("u", 2))), prefix="a.")
    assert outputs(ssp(component(), bindings=prefixed))["a.y"] == 10.0


def test_the_outermost_and_the_last_value_counts(ssp):
    # SSP, "ParameterBindings": higher levels take precedence, and of one level the succeeding binding
    own = bound(inline(parameters(real("gain", 5) + real("u", 1))))
    whole = bound(inline(parameters(real("a.gain", 6)))).replace("</ssd:ParameterBindings>", "")
    whole += bound(inline(parameters(real("a.gain", 7)))).replace("<ssd:ParameterBindings>", "")
    assert outputs(ssp(component(bindings=own), bindings=whole))["a.y"] == 7.0


def test_a_mapping_renames_transforms_and_leaves_out(ssp):
    entries = mapping('<ssm:MappingEntry source="k" target="gain"><ssc:LinearTransformation factor="2" offset="1"/></ssm:MappingEntry>'
                      '<ssm:MappingEntry source="v" target="u"/>')  # fmt: skip
    values = parameters(real("k", 3) + real("v", 36, "km/h") + real("gain", 100), units=f"<ssv:Units>{KMH}</ssv:Units>")
    expected = (2 * 3 + 1) * 10.0
    within = bound(inline(values) + f"<ssd:ParameterMapping>{entries}</ssd:ParameterMapping>")
    assert outputs(ssp(component(bindings=within)))["a.y"] == pytest.approx(expected)
    files = {"resources/p.ssv": values, "resources/p.ssm": entries}
    external = bound('<ssd:ParameterMapping source="resources/p.ssm"/>', source="resources/p.ssv")
    assert outputs(ssp(component(bindings=external), files=files))["a.y"] == pytest.approx(expected)


def test_a_mapping_sees_names_with_the_prefix(ssp):
    entries = mapping('<ssm:MappingEntry source="x.k" target="gain"/>')
    with_prefix = bound(inline(parameters(real("k", 3))) + f"<ssd:ParameterMapping>{entries}</ssd:ParameterMapping>", prefix="x.")
    assert outputs(ssp(component(bindings=with_prefix)), **{"a.u": 1.0})["a.y"] == 3.0


@pytest.mark.parametrize("where", ["of the parameter set", "of the structure"])
def test_108_km_per_h_is_30_m_per_s(ssp, where):
    units = f"<ssv:Units>{KMH}</ssv:Units>" if where == "of the parameter set" else ""
    path = ssp(component(bindings=bound(inline(parameters(real("u", 108, "km/h"), units=units)))))
    assert outputs(path)["a.y"] == pytest.approx(30.0, rel=1e-15)


def test_unit_conversion_can_be_suppressed(ssp):
    entries = mapping('<ssm:MappingEntry source="u" target="u" suppressUnitConversion="true"/>')
    values = inline(parameters(real("u", 108, "km/h"))) + f"<ssd:ParameterMapping>{entries}</ssd:ParameterMapping>"
    assert outputs(ssp(component(bindings=bound(values))))["a.y"] == 108.0


def test_units_that_cannot_be_converted_are_refused(ssp):
    path = ssp(component(bindings=bound(inline(parameters(real("u", 20, "degC"))))), units=CELSIUS)
    with pytest.raises(InputError, match=r"value u for a\.u: \[degC\] cannot be converted to \[m/s\]: the dimensions differ"):
        read_ssp(path)
    path = ssp(component(bindings=bound(inline(parameters(real("u", 20, "knots"))))))
    with pytest.raises(InputError, match=r"\[knots\] is not defined"):
        read_ssp(path)


def typed(kind, name, value, more=""):
    return f'<ssv:Parameter name="{name}"><ssv:{kind} value="{value}"{more}/></ssv:Parameter>'


def test_parameters_of_every_type(ssp):
    values = (typed("Boolean", "flag", "true") + typed("Integer", "count", -7) + typed("Enumeration", "mode", "fast")
              + typed("String", "label", "wobble") + typed("Integer", "gain", 3))  # fmt: skip
    found = outputs(ssp(component(bindings=bound(inline(parameters(values))))))
    assert [found[f"a.{n}"] for n in ("seen_flag", "seen_count", "seen_mode", "label_length")] == [1.0, -7.0, 2.0, 6.0]


@pytest.mark.parametrize(("value", "reason"), [
    (typed("Boolean", "flag", "perhaps"), r"value flag for a\.flag: 'perhaps' is no Boolean"),
    (typed("Integer", "count", "1.5"), r"value count for a\.count: '1\.5' is no number"),
    (typed("Enumeration", "mode", "quick"), "unknown item 'quick'.*valid: fast, slow"),
    (typed("Real", "count", "1"), "a value of type Real does not fit a variable of type Integer"),
    ('<ssv:Parameter name="gain"><ssv:Real value="1 2"/><ssv:Dimension size="2"/></ssv:Parameter>', "arrays are not supported"),
    (real("gain", "fast"), "'fast' is no number"),
])  # fmt: skip
def test_a_value_that_does_not_fit_is_refused_by_name(ssp, value, reason):
    with pytest.raises(InputError, match=reason):
        read_ssp(ssp(component(bindings=bound(inline(parameters(value))))))


def test_mapped_booleans_integers_and_items(ssp):
    entries = mapping(
        '<ssm:MappingEntry source="flag" target="flag"><ssc:BooleanMappingTransformation><ssc:MapEntry source="false" target="true"/>'
        '</ssc:BooleanMappingTransformation></ssm:MappingEntry><ssm:MappingEntry source="count" target="count">'
        '<ssc:IntegerMappingTransformation><ssc:MapEntry source="1" target="11"/></ssc:IntegerMappingTransformation></ssm:MappingEntry>'
        '<ssm:MappingEntry source="mode" target="mode"><ssc:EnumerationMappingTransformation><ssc:MapEntry source="B" target="fast"/>'
        "</ssc:EnumerationMappingTransformation></ssm:MappingEntry>"
    )
    values = typed("Boolean", "flag", "0") + typed("Integer", "count", 1) + typed("Enumeration", "mode", "B")
    found = outputs(ssp(component(bindings=bound(inline(parameters(values)) + f"<ssd:ParameterMapping>{entries}</ssd:ParameterMapping>"))))
    assert [found[f"a.{n}"] for n in ("seen_flag", "seen_count", "seen_mode")] == [1.0, 11.0, 2.0]


def test_a_value_without_a_variable_is_ignored_with_a_warning(ssp):
    with pytest.warns(UserWarning, match=r"values are bound to a\.gian, which no element has; they are ignored"):
        read_ssp(ssp(component(bindings=bound(inline(parameters(real("gian", 2))))))).close()


def test_a_connection_converts_units_and_transforms(ssp):
    start = bound(inline(parameters(real("u", 10))))
    change = '<ssc:LinearTransformation factor="2" offset="5"/>'
    path = ssp(component(bindings=start) + component("b", source="resources/b.fmu"), connection("a.y", "b.u", change))
    with read_ssp(path) as system:
        assert system.fmus["b"].present_inputs == pytest.approx([2 * 36.0 + 5.0])  # 10 m/s are 36 km/h
        run = cosimulate(system.subsystems, 0.1, 0.5, "jacobi", wiring=system.wiring)
        assert run["b.y"] == pytest.approx(77.0)
        assert system.duration == 0.5
    suppressed = connection("a.y", "b.u", change, suppressUnitConversion="true")
    assert outputs(ssp(component(bindings=start) + component("b", source="resources/b.fmu"), suppressed))["b.y"] == pytest.approx(25.0)


def test_the_direction_of_a_connection_follows_from_its_connectors(ssp):
    start = bound(inline(parameters(real("u", 10))))
    path = ssp(component(bindings=start) + component("b", source="resources/b.fmu"), connection("b.u", "a.y"))
    assert outputs(path)["b.y"] == pytest.approx(36.0)


def nested(elements, connections="", connectors="", name="inner", bindings=""):
    return (f'<ssd:System name="{name}"><ssd:Connectors>{connectors}</ssd:Connectors>{bindings}<ssd:Elements>{elements}</ssd:Elements>'
            f"<ssd:Connections>{connections}</ssd:Connections></ssd:System>")  # fmt: skip


def test_nested_systems_are_flattened_by_name(ssp):
    ports = connector("v", "input", "km/h") + connector("w", "output")
    middle = nested(component("a"), connection("v", "a.u") + connection("a.y", "w"), ports)
    outer = nested(middle, connection("v", "inner.v") + connection("inner.w", "w"), ports, "outer")
    start = bound(inline(parameters(real("gain", 2) + real("u", 18))), prefix="")
    path = ssp(component("b", source="resources/b.fmu", bindings=start) + outer + component("c"),
               connection("b.y", "outer.v") + connection("outer.w", "c.u"),
               bindings=bound(inline(parameters(real("outer.inner.a.gain", 3)))))  # fmt: skip
    found = outputs(path)
    assert set(found) >= {"outer/inner/a.y", "b.y", "c.y"}
    assert found["outer/inner/a.y"] == pytest.approx(3 * 10.0)  # 36 km/h are 10 m/s
    assert found["c.y"] == pytest.approx(30.0)


def test_a_value_of_a_connector_of_a_system_reaches_the_variable(ssp):
    inner = nested(component("a"), connection("v", "a.u") + connection("k", "a.gain"), connector("v", "input", "km/h") + connector("k", "parameter"))
    path = ssp(inner, bindings=bound(inline(parameters(real("inner.v", 36) + real("inner.k", 2)))))
    assert outputs(path)["inner/a.y"] == pytest.approx(20.0)
    through = connection("v", "inner.v") + connection("k", "inner.k")
    outer = ssp(inner, through, bound(inline(parameters(real("v", 20) + real("k", 3)))),
                connectors=connector("v", "input") + connector("k", "parameter"))  # fmt: skip
    assert outputs(outer)["inner/a.y"] == pytest.approx(3 * 20 / 3.6)


def test_ssp_2_with_its_types(ssp):
    values = parameters('<ssv:Parameter name="gain"><ssv:Float64 value="2"/></ssv:Parameter><ssv:Parameter name="count"><ssv:Int32 value="9"/></ssv:Parameter>'
                        '<ssv:Parameter name="label"><ssv:String><ssv:Value value="ab"/></ssv:String></ssv:Parameter>' + real("u", 1), "2.0")  # fmt: skip
    port = '<ssd:Connector name="y" kind="output"><ssc:Float64 unit="m/s"/></ssd:Connector>'
    found = outputs(ssp(component(bindings=bound(inline(values)), connectors=port), version="2.0"))
    assert [found[f"a.{n}"] for n in ("y", "seen_count", "label_length")] == [2.0, 9.0, 2.0]


REFUSED = {
    r"the system: .*: b\.speed|unknown element 'b'": {"connections": connection("a.y", "b.u")},
    r"a: unknown connector 'speed'": {"connections": connection("a.speed", "a.u")},
    r"connects a\.y with a\.seen_flag, which are not an output and an input": {"connections": connection("a.y", "a.seen_flag")},
    r"a\.u: has two connections into it": {"connections": connection("a.y", "a.u") + connection("a.seen_flag", "a.u")},
    r"a\.gain: is a parameter driven by an output": {"connections": connection("a.y", "a.gain")},
    r"has a BooleanMappingTransformation": {"connections": connection("a.y", "a.u", "<ssc:BooleanMappingTransformation/>")},
    r"connects elements of arrays": {"connections": connection("a.y", "a.u", startIndices="1")},
    r"d: is a SignalDictionaryReference, which is not supported": {"elements": '<ssd:SignalDictionaryReference name="d" dictionary="x"/>'},
    r"n: has the type application/x-ssp-package": {"elements": component("n", more='type="application/x-ssp-package"')},
    r"n: asks for ModelExchange": {"elements": component("n", more='implementation="ModelExchange"')},
    r"n: the source 'http://x\.org/a\.fmu' is no path": {"elements": component("n", source="http://x.org/a.fmu")},
    r"n: the source '\.\./a\.fmu' leaves the archive": {"elements": component("n", source="../a.fmu")},
    r"n: the source '%2e%2e/a\.fmu' leaves": {"elements": component("n", source="%2e%2e/a.fmu")},
    r"n: the source '/etc/passwd' leaves": {"elements": component("n", source="/etc/passwd")},
    r"has two elements 'a'": {"elements": component()},
    r"is of version 3\.0 of the standard \(valid: 1\.0, 2\.0\)": {"version": "3.0"},
    r"SystemStructure\.ssd is no XML": {"structure": "<ssd:System"},
    r"declares a document type": {"structure": '<!DOCTYPE x [<!ENTITY a "b">]><x>&a;</x>'},
    r"has the root element ParameterSet": {"structure": parameters("")},
    r"the unit km/h has the factor 0": {"units": KMH.replace("0.2777777777777778", "0")},
}


@pytest.mark.parametrize("reason", REFUSED)
def test_what_is_not_supported_is_refused_with_file_element_and_reason(ssp, reason):
    given = dict(REFUSED[reason])
    path = ssp(component() + given.pop("elements", ""), **given)
    with pytest.raises(InputError, match=reason):
        read_ssp(path)


def test_an_archive_that_unpacks_to_too_much_is_refused(ssp, monkeypatch):
    monkeypatch.setattr("fmus.cosimulation.ssp.package.LARGEST_XML", 1000)
    with pytest.raises(InputError, match=r"SystemStructure\.ssd has more than 1000 bytes"):
        read_ssp(ssp(component(), files={}, units=" " * 2000))


def test_values_can_be_changed_by_name(ssp):
    path = ssp(component() + component("b", source="resources/b.fmu"))
    assert outputs(path, **{"a.gain": 2.0, "a.u": 4.0})["a.y"] == 8.0
    with pytest.raises(InputError, match=r"'gain' is a variable of a and b: write a\.gain=2"):
        read_ssp(path, {"gain": 2.0})
    with pytest.raises(InputError, match=r"unknown variable 'a\.gian', did you mean 'a\.gain'"):
        read_ssp(path, {"a.gian": 2.0})


def test_a_system_leaves_no_file(ssp, tmp_path, monkeypatch):
    monkeypatch.setattr("tempfile.tempdir", str(tmp_path))
    before = set(tmp_path.iterdir())
    path = ssp(component())
    with read_ssp(path):
        assert np.any([p.name.startswith("ssp-") for p in tmp_path.iterdir()])
    assert not [p for p in set(tmp_path.iterdir()) - before if p.name.startswith("ssp-")]
