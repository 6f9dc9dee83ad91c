"""What archives have besides description and code: documentation, icon, terminals, nominals, reference results."""

import io
import json
import re
import zipfile
from html.parser import HTMLParser
from xml.etree import ElementTree as Xml

import fmpy
import numpy as np
import pytest
from lxml import etree
from PIL import Image

import rider_fmu.effects
from fmus.cosimulation.subsystems.fmu_subsystem import FmuSubsystem
from fmus.effects import effects_in
from fmus.effects.added_terms import added_terms
from fmus.export import documentation, icon, mathml, reference
from fmus.export.build import build
from fmus.export.interface import Interface
from fmus.linear_analysis.linearisation import linearise
from rider_fmu import riders
from rider_fmu.components.full_rider import FullRiderOnRig
from tests.importer import COMPONENTS

VOID = {"meta"}


class Balanced(HTMLParser):
    """Elements that are open, and references to other files."""

    def __init__(self):
        super().__init__()
        self.open, self.references = [], []

    def handle_starttag(self, tag, attrs):
        self.references += [value for name, value in attrs if name in ("src", "href")]
        if tag not in VOID:
            self.open.append(tag)

    def handle_endtag(self, tag):
        assert self.open.pop() == tag


@pytest.mark.slow
@pytest.mark.parametrize("name", COMPONENTS)
def test_the_page_is_complete_and_needs_no_other_file(name):
    interface = Interface(COMPONENTS[name]())
    text = documentation.index(interface).decode()
    page = Balanced()
    page.feed(text)
    assert page.open == [] and page.references == [] and "<script" not in text
    for variable in interface.of("parameter", "input", "state", "output"):
        assert f"<td>{variable.name}</td>" in text and documentation.escape(variable.row.description) in text
    assert documentation.index(Interface(COMPONENTS[name]())).decode() == text


@pytest.mark.slow
def test_the_documentation_of_a_component_with_an_effect_says_what_it_adds():
    """Effects may bring states and outputs of their own, which the equations of the component do not have."""
    for effect in effects_in(rider_fmu.effects):
        text = documentation.index(Interface(riders.load("mean_2011").with_effects(effect()))).decode()
        assert documentation.escape(effect.sentence()) in text
        for equation in added_terms(effect):
            assert documentation.escape(equation) in text


@pytest.mark.parametrize(("latex", "expected"), [
    (r"\delta", "<mi>δ</mi>"),
    ("I_t", "<msub><mi>I</mi><mi>t</mi></msub>"),
    (r"\dot{\delta}", "<mover><mi>δ</mi><mo>&#x2d9;</mo></mover>"),
    (r"k_{a1}'", "<msubsup><mi>k</mi><mi>a1</mi><mi>'</mi></msubsup>"),
    (r"\mathrm{port\_inertia}", "<mi>port_inertia</mi>"),
    ("a<b", "<mi>a</mi>"),
])  # fmt: skip
def test_symbols_as_mathml(latex, expected):
    assert mathml.symbol_markup(latex) == expected


def test_the_icon_is_a_picture_of_the_port():
    seen = set()
    for name, component in COMPONENTS.items():
        data = icon.png(Interface(component()))
        with Image.open(io.BytesIO(data)) as picture:
            assert picture.size == (icon.SIZE, icon.SIZE) and len(set(picture.convert("RGB").get_flattened_data())) > 2, name
        etree.fromstring(icon.svg(Interface(component())))
        seen.add(data)
    assert len(seen) == 3  # device, vehicle, block


@pytest.mark.slow
def test_states_have_nominals_of_their_unit(tmp_path):
    for name, expected in (("rider", {"torso_angle": 0.1}), ("motorcycle", {"front_side_force": 100.0, "steer_angle": 0.1})):
        description = fmpy.read_model_description(str(build(COMPONENTS[name](), tmp_path).path))
        nominal = {v.name: float(v.nominal) for v in description.modelVariables if v.nominal}
        assert expected.items() <= nominal.items()


@pytest.mark.slow
@pytest.mark.parametrize("fmi", [2, 3])
def test_archives_hold_documentation_icon_and_references_where_the_standards_have_them(fmi, tmp_path):
    with zipfile.ZipFile(build(riders.load("mean_2011"), tmp_path, fmi=fmi).path) as archive:
        names = set(archive.namelist())
        manifest = Xml.fromstring(archive.read(reference.MANIFEST))
        experiment = json.loads(archive.read(f"{reference.FOLDER}/experiment.json"))
        results = archive.read(f"{reference.FOLDER}/results.csv").decode().splitlines()
    # FMI 3.0, 2.5.1: icon.png has to be present with icon.svg; FMI 2.0.4, 2.3: model.png
    assert {"documentation/index.html", "terminalsAndIcons/icon.png", "terminalsAndIcons/icon.svg"} <= names
    assert ("model.png" in names) == (fmi == 2)
    # fmi3LayeredStandardReferenceManifest.xsd: names and roles
    assert manifest.get("{http://fmi-standard.org/fmi-ls-manifest}fmi-ls-name") == "org.fmi-standard.fmi-ls-ref"
    roles = re.compile("(document|experiment(/(smoke-test|validation|uncertainty-analysis))?|result)")
    for related in manifest:
        assert roles.fullmatch(related.get("role")) and f"{reference.FOLDER}/{related.get('source')}" in names
    assert len(results) == 2 + round(experiment["stopTime"] / experiment["stepSize"])
    assert results[0].startswith("time [s],") and "handlebar_torque [N.m]" in results[0]


@pytest.mark.slow
@pytest.mark.parametrize("name", COMPONENTS)
def test_reference_modes_are_those_of_the_exact_jacobian(name):
    component = COMPONENTS[name]()
    files = reference.files(Interface(component))
    exact = np.linalg.eigvals(linearise(component).A)
    exact = exact[exact.imag > 1e-6 * np.abs(exact)]
    size = np.abs(exact).max(initial=0.0)
    exact = np.sort(exact.imag) / (2 * np.pi)
    path = f"{reference.FOLDER}/{reference.MODES}"
    found = sorted(mode["frequency"] for mode in json.loads(files[path])["modes"]) if path in files else []
    assert found == pytest.approx(exact.tolist(), abs=3e-7 * size)  # the oscillator has a kink at rest


@pytest.mark.slow
def test_terminals_in_fmi_2_do_not_disturb_an_importer(tmp_path):
    with FmuSubsystem(build(riders.load("mean_2011"), tmp_path).path) as fmu:
        assert fmu.exchange(np.zeros(3)) == pytest.approx(np.zeros(len(fmu.outputs)))


@pytest.mark.slow
def test_an_experiment_that_leaves_the_range_of_the_equations_has_no_results():
    """Without stiffness and damping the hands of the rider on the rig swing out of reach."""
    files = reference.files(Interface(FullRiderOnRig()))
    assert f"{reference.FOLDER}/{reference.RESULTS}" not in files
