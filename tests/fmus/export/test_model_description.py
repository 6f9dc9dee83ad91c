"""The model description: FMI's own schema, units that add up, dependencies against differences of the equations."""

from xml.etree import ElementTree as Xml

import numpy as np
import pytest
from fmpy import read_model_description
from lxml import etree

from fmus import Component, input, output, parameter, state
from fmus.declaration.units import BASE, unit
from fmus.export.interface import Interface, per_second
from fmus.export.model_description2 import DATE, compiled, model_description
from rider_fmu import riders
from vehicle_fmu import dampers, motorcycles

LOADED = [lambda: riders.load("mean_2011"), lambda: motorcycles.load("sharp_1971"),
          lambda: motorcycles.load("benchmark_bicycle"), lambda: dampers.load("progressive"), lambda: dampers.load("inerter")]  # fmt: skip


def rendered(component):
    interface = Interface(component)
    return interface, Xml.fromstring(
        model_description(interface, interface.identifier, "{guid}", compiled(interface, ["model.c"]))
    )


@pytest.mark.slow
@pytest.mark.parametrize("load", LOADED)
def test_units_are_defined_with_the_exponents_of_the_base_units(load):
    _, root = rendered(load())
    defined = {e.get("name"): e for e in root.iter("Unit")}
    for real in root.iter("Real"):
        exponents = {k: int(v) for k, v in defined[real.get("unit")].find("BaseUnit").attrib.items()}
        assert exponents == {b: e for b, e in zip(BASE, unit(real.get("unit")).exponents, strict=True) if e}
        if real.get("displayUnit"):
            assert real.get("displayUnit") in [d.get("name") for d in defined[real.get("unit")].iter("DisplayUnit")]


def test_a_display_unit_is_value_times_factor():
    _, root = rendered(riders.load("mean_2011"))
    degrees = next(d for d in root.iter("DisplayUnit") if d.get("name") == "deg")
    assert float(degrees.get("factor")) * np.pi == pytest.approx(180, rel=1e-15)


def test_starts_are_the_values_of_the_instance():
    _, root = rendered(riders.load("mean_2011", arm_damping=12.25))
    starts = {v.get("name"): v[0].get("start") for v in root.iter("ScalarVariable")}
    assert float(starts["arm_damping"]) == 12.25
    assert float(starts["arm_stiffness"]) == riders.load("mean_2011").values["arm_stiffness"]
    assert starts["handlebar_torque"] is None and starts["port_inertia"] is None


@pytest.mark.parametrize("load", LOADED)
def test_dependencies_are_where_differences_see_a_slope(load):
    component = load()
    interface, root = rendered(component)
    names = [v.name for v in interface.variables]
    listed = {}
    for unknown in [*root.find("ModelStructure/Outputs"), *(root.find("ModelStructure/Derivatives") or ())]:
        listed[names[int(unknown.get("index")) - 1]] = {names[int(i) - 1] for i in unknown.get("dependencies").split()}
    values = {
        **component.start_values(),
        **{n: 0.3 + 0.1 * i for i, n in enumerate(component.states + component.inputs)},
    }
    unknowns = [f"der({n})" for n in component.states] + list(component.outputs)

    def evaluated(**changed):
        at = {**values, **changed}
        rates, outputs = component.with_values(**{n: at[n] for n in component.values}).derivatives(
            np.array([at[n] for n in component.states]), np.array([at[n] for n in component.inputs]))  # fmt: skip
        return np.concatenate([rates, outputs])

    for known in component.states + component.inputs:
        slopes = (evaluated(**{known: values[known] + 1e-3}) - evaluated(**{known: values[known] - 1e-3})) / 2e-3
        seen = {n for n, slope in zip(unknowns, slopes, strict=True) if abs(slope) > 1e-9}
        # Every slope is listed; a listed one may happen to vanish at these values, as with a cross inertia of zero.
        assert seen <= {n for n, known_of in listed.items() if known in known_of}


class Mixed(Component):
    """One output of each kind of dependency."""

    fixed_gain = parameter("1", "Gain that stays", start=2, tunable=False)
    gain = parameter("1", "Gain", start=3)
    signal = input("m", "Signal")
    other = input("m", "Another signal")
    position = state("m", 'Position, "quoted" <and> & escaped')
    constant = output("m", "Slope 1")
    fixed = output("m", "Slope of a fixed parameter")
    tunable = output("m", "Slope of a tunable parameter")
    dependent = output("m2", "Slope that varies")
    switched = output("m", "Slope zero, but it switches")

    def equations(self, v, m):
        return {"der(position)": v.signal + m.sin(v.time), "constant": v.signal + v.other - v.other, "fixed": v.fixed_gain * v.signal,
                "tunable": v.gain * v.signal, "dependent": v.signal * v.other, "switched": m.where(v.signal > 0, 1.0, -1.0)}  # fmt: skip


def test_kinds_of_dependency():
    interface, root = rendered(Mixed("mixed"))
    names = [v.name for v in interface.variables]
    kinds = {names[int(u.get("index")) - 1]: {names[int(i) - 1]: k for i, k in zip(u.get("dependencies").split(), u.get("dependenciesKind").split(), strict=True)}
             for e in ("Outputs", "Derivatives") for u in root.find(f"ModelStructure/{e}")}  # fmt: skip
    assert kinds == {
        "constant": {"signal": "constant"},
        "fixed": {"signal": "fixed"},
        "tunable": {"signal": "tunable"},
        "dependent": {"signal": "dependent", "other": "dependent"},
        "switched": {"signal": "dependent"},
        "der(position)": {"time": "dependent", "signal": "constant"},
    }
    assert (
        next(v for v in root.iter("ScalarVariable") if v.get("name") == "position").get("description")
        == Mixed.declared["position"].description
    )


@pytest.mark.slow
@pytest.mark.parametrize("load", LOADED)
def test_the_importer_s_schema_accepts_it(load, tmp_path):
    interface = Interface(load())
    data = model_description(interface, interface.identifier, "{guid}", compiled(interface, ["model.c"]))
    assert etree.fromstring(data).get("generationDateAndTime") == DATE
    path = tmp_path / "modelDescription.xml"
    path.write_bytes(data)
    read = read_model_description(str(path), validate=True, validate_variable_names=True, validate_model_structure=True)
    assert [v.name for v in read.modelVariables] == [v.name for v in interface.variables]


@pytest.mark.parametrize("name", ["rad", "rad/s", "m/s2", "N.m.s", "kg.m2/s", "N", "1/s", "N.m/rad", "s", "N.s/m"])
def test_the_unit_of_a_rate(name):
    expected = list(unit(name).exponents)
    expected[BASE.index("s")] -= 1
    assert list(unit(per_second(name)).exponents) == expected
