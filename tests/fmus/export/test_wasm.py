"""The WebAssembly of an FMU: without imports, with the numbers of the host's library, in wasmtime and in a browser;
and the component of fmi-ls-wasm around it."""

import base64
import re
import struct
import zipfile
from importlib.util import find_spec
from xml.etree import ElementTree as Xml

import fmpy
import numpy as np
import pytest

from fmus.export.build import build
from fmus.export.wasm_component import component, core_module
from fmus.export.wasm_interface import EVERY_KIND, KINDS, functions
from tests.browser import chromium, needs_browser
from tests.importer import COMPONENTS

wasmtime = pytest.importorskip("wasmtime", reason="needs wasmtime (pip install motofmi[dev])")
pytest.importorskip("wasmtime.component")
pytestmark = [
    pytest.mark.slow,
    pytest.mark.skipif(find_spec("ziglang") is None, reason="needs ziglang (pip install motofmi[platforms])"),
]
# The sine functions of two C libraries differ in the last digit; a trajectory of 40 steps keeps that small.
EQUAL = {"rel": 1e-12, "abs": 1e-12}
STEP, STEPS = 1 / 128, 40
MODULE, COMPONENT = "binaries/wasm32-unknown-unknown", "binaries/wasm32-wasip2"


def archive(name, folder, fmi=3):
    """Model description and the WebAssembly by folder of a component."""
    path = build(COMPONENTS[name](), folder, fmi=fmi, platforms="wasm").path
    with zipfile.ZipFile(path) as members:
        return fmpy.read_model_description(path), {
            n.rpartition("/")[0]: members.read(n) for n in members.namelist() if n.startswith(("binaries/", "extra/"))
        }


def names_of(description, causality):
    return [v.name for v in description.modelVariables if v.causality == causality]


def references(description, names):
    by_name = {v.name: v.valueReference for v in description.modelVariables}
    return [by_name[n] for n in names]


def signal(step, count):
    """Inputs that jump from step to step."""
    return [1 + ((step * 7 + i * 3) % 11) / 16 for i in range(count)]


def native(name, description, opened):
    """The outputs after each step of the host's own library of FMI 2."""
    fmu, inputs, outputs = opened(COMPONENTS[name]()).start(), *(names_of(description, k) for k in ("input", "output"))
    rows = []
    for step in range(STEPS):
        fmu.set(**dict(zip(inputs, signal(step, len(inputs)), strict=True)))
        fmu.fmu.doStep(step * STEP, STEP)
        rows.append(fmu.get(*outputs))
    return np.array(rows)


class Module:
    """A module in wasmtime; a list of numbers is an argument by its address."""

    def __init__(self, data):
        engine = wasmtime.Engine()
        self.store, module = wasmtime.Store(engine), wasmtime.Module(engine, data)
        assert not list(module.imports)
        self.exports = wasmtime.Instance(self.store, module, []).exports(self.store)

    def call(self, name, *arguments):
        return self.exports[name](self.store, *arguments)

    def place(self, data):
        address = self.call("malloc", max(len(data), 1))
        self.exports["memory"].write(self.store, data, address)
        return address

    def integers(self, values):
        return self.place(struct.pack(f"<{len(values)}I", *values))

    def numbers(self, values):
        return self.place(struct.pack(f"<{len(values)}d", *values))

    def read(self, address, count):
        return struct.unpack(f"<{count}d", self.exports["memory"].read(self.store, address, address + 8 * count))


def steps_of_module(module, description, fmi):
    """The outputs after each step, by the functions of FMI in C."""
    inputs, outputs = (references(description, names_of(description, k)) for k in ("input", "output"))
    token, name = module.place(description.guid.encode() + b"\0"), module.place(b"test\0")
    where = (
        module.integers(inputs),
        module.integers(outputs),
        module.numbers([0.0] * len(outputs)),
        module.numbers([0.0] * 4),
    )
    if fmi == 3:
        instance = module.call("fmi3InstantiateCoSimulation", name, token, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0)
        assert module.call("fmi3EnterInitializationMode", instance, 0, 0.0, 0.0, 0, 0.0) == 0
    else:
        callbacks = module.integers([0] * 5)
        instance = module.call("fmi2Instantiate", name, 1, token, 0, callbacks, 0, 0)
        assert module.call("fmi2SetupExperiment", instance, 0, 0.0, 0.0, 0, 0.0) == 0
        assert module.call("fmi2EnterInitializationMode", instance) == 0
    assert module.call(f"fmi{fmi}ExitInitializationMode", instance) == 0
    rows = []
    for step in range(STEPS):
        values = module.numbers(signal(step, len(inputs)))
        if fmi == 3:
            module.call("fmi3SetFloat64", instance, where[0], len(inputs), values, len(inputs))
            assert module.call("fmi3DoStep", instance, step * STEP, STEP, 1, *(where[3] + 8 * k for k in range(4))) == 0
            module.call("fmi3GetFloat64", instance, where[1], len(outputs), where[2], len(outputs))
        else:
            module.call("fmi2SetReal", instance, where[0], len(inputs), values)
            assert module.call("fmi2DoStep", instance, step * STEP, STEP, 1) == 0
            module.call("fmi2GetReal", instance, where[1], len(outputs), where[2])
        rows.append(module.read(where[2], len(outputs)))
        module.call("free", values)
    return np.array(rows)


@pytest.mark.parametrize(("name", "fmi"), [("rider", 2), ("motorcycle", 3), ("oscillator", 3)])
def test_a_module_without_imports_has_the_numbers_of_the_native_library(name, fmi, opened, tmp_path):
    description, made = archive(name, tmp_path, fmi)
    found = steps_of_module(Module(made["binaries/wasm32" if fmi == 2 else MODULE]), description, fmi)
    assert found == pytest.approx(native(name, description, opened), **EQUAL)


class Instance:
    """An instance of a component in wasmtime: methods of the interface by name."""

    def __init__(self, data, kind, *arguments):
        components = wasmtime.component
        engine = wasmtime.Engine()
        self.store, self.component = wasmtime.Store(engine), components.Component(engine, data)
        self.imports = self.component.type.imports(engine)
        self.kind = kind
        self.instance = components.Linker(engine).instantiate(self.store, self.component)
        self.handle = self._call(f"[static]{kind}-instance.instantiate-{kind}", *arguments)

    def _call(self, name, *arguments):
        interface = self.component.get_export_index(f"fmi:fmi3/{self.kind}@3.0.0")
        function = self.instance.get_func(self.store, self.component.get_export_index(name, interface))
        result = function(self.store, *arguments)
        function.post_return(self.store)
        return result

    def call(self, name, *arguments):
        return self._call(f"[method]{self.kind}-instance.{name}", self.handle, *arguments)


def co_simulation(made, token):
    return Instance(made[COMPONENT], "co-simulation", "test", token, "", False, False, False, False, [])


def test_the_component_of_fmi_ls_wasm_has_the_numbers_of_the_native_library(opened, tmp_path):
    description, made = archive("motorcycle", tmp_path)
    inputs, outputs = (references(description, names_of(description, k)) for k in ("input", "output"))
    fmu = co_simulation(made, description.guid)
    assert not fmu.imports
    assert fmu.call("enter-initialization-mode", None, 0.0, None) == fmu.call("exit-initialization-mode") == "ok"
    rows = []
    for step in range(STEPS):
        assert fmu.call("set-float64", inputs, signal(step, len(inputs))) == "ok"
        done = vars(fmu.call("do-step", step * STEP, STEP, True))
        assert done["last-successful-time"] == pytest.approx((step + 1) * STEP) and not done["early-return"]
        rows.append(fmu.call("get-float64", outputs))
    assert np.array(rows) == pytest.approx(native("motorcycle", description, opened), **EQUAL)


def test_a_component_saves_states_refuses_errors_and_frees_its_memory(tmp_path):
    description, made = archive("rider", tmp_path)
    assert co_simulation(made, "another token").handle is None
    fmu = co_simulation(made, description.guid)
    fmu.call("enter-initialization-mode", 1e-6, 0.0, 1.0)
    fmu.call("exit-initialization-mode")
    (angle,) = references(description, ["torso_angle"])
    saved = fmu.call("get-fmu-state")
    fmu.call("set-float64", references(description, ["steer_rate"]), [1.0])
    fmu.call("do-step", 0.0, 0.1, True)
    later = fmu.call("get-float64", [angle])
    assert fmu.call("set-fmu-state", saved) == "ok" and fmu.call("get-float64", [angle]) == [0.0] != later
    assert fmu.call("set-fmu-state", saved[:-1]) == "error"
    assert fmu.call("do-step", 0.0, -0.1, True) == "error"  # a result that failed is its status
    assert fmu.call("get-boolean", []) == [] and fmu.call("get-boolean", [angle]) == "error"
    pages = fmu.call("get-directional-derivative", [angle], [angle], [1.0])
    for _ in range(20_000):  # 100 bytes each would need another 30 pages of memory
        assert fmu.call("get-directional-derivative", [angle], [angle], [1.0]) == pages


def test_a_component_exchanges_its_model(tmp_path):
    description, made = archive("oscillator", tmp_path)
    fmu = Instance(made[COMPONENT], "model-exchange", "test", description.guid, "", False, False)
    fmu.call("enter-initialization-mode", None, 0.0, None)
    fmu.call("exit-initialization-mode")
    assert fmu.call("enter-continuous-time-mode") == "ok"
    assert fmu.call("get-number-of-continuous-states") == 2 and fmu.call("get-number-of-event-indicators") == 0
    assert fmu.call("set-continuous-states", [0.5, 0.25]) == "ok"
    assert fmu.call("get-continuous-states") == [0.5, 0.25]
    derivatives = fmu.call("get-continuous-state-derivatives")
    # M a = - 9 x - k x^3 - R tanh(50 v) - |v| v, as the oscillator of the tests is declared
    force = -9 * 0.5 - 40 * 0.5**3 - 0.2 * np.tanh(12.5) - 0.25**2
    assert derivatives == pytest.approx([0.25, force / (1.3 * 1.25)], rel=1e-12)
    assert vars(fmu.call("completed-integrator-step", True)) == {
        "enter-event-mode": False,
        "terminate-simulation": False,
    }


def test_a_component_has_every_function_of_the_draft_and_its_manifest(tmp_path):
    _, made = archive("rider", tmp_path)
    fmu = Instance(made[COMPONENT], "co-simulation", "test", "no token", "", False, False, False, False, [])
    for kind in KINDS:
        interface = fmu.component.get_export_index(kind.interface)
        for function in [*functions(EVERY_KIND), *functions(kind.functions)]:
            assert fmu.component.get_export_index(f"[method]{kind.resource}.{function.name}", interface)
    manifest = Xml.fromstring(made["extra/org.modelica.fmi-ls-wasm"])
    prefix = "{http://fmi-standard.org/fmi-ls-manifest}fmi-ls-"
    assert manifest.tag == "fmiLayeredStandardManifest" and manifest.get(prefix + "name") == "org.modelica.fmi-ls-wasm"
    assert re.fullmatch(r"\d+\.\d+\.\d+", manifest.get(prefix + "version"))


def test_the_module_is_the_first_part_of_the_component(tmp_path):
    _, made = archive("rider", tmp_path)
    assert core_module(made[COMPONENT]) == made[MODULE] and component(made[MODULE]) == made[COMPONENT]


IN_THE_BROWSER = """async ({code, token, inputs, outputs, signals, step}) => {
  const bytes = Uint8Array.from(atob(code), c => c.charCodeAt(0));
  const {exports: fmu} = (await WebAssembly.instantiate(bytes, {})).instance;
  const place = data => { const at = fmu.malloc(data.byteLength + 1);
    new Uint8Array(fmu.memory.buffer).set([...new Uint8Array(data.buffer), 0], at); return at; };
  const text = value => place(new TextEncoder().encode(value));
  const u = place(new Uint32Array(inputs)), y = place(new Uint32Array(outputs));
  const values = fmu.malloc(8 * outputs.length), flags = fmu.malloc(32), rows = [];
  const s = fmu.fmi3InstantiateCoSimulation(text("test"), text(token), 0, 0, 0, 0, 0, 0, 0, 0, 0, 0);
  fmu.fmi3EnterInitializationMode(s, 0, 0, 0, 0, 0);
  fmu.fmi3ExitInitializationMode(s);
  signals.forEach((signal, k) => {
    fmu.fmi3SetFloat64(s, u, inputs.length, place(new Float64Array(signal)), inputs.length);
    fmu.fmi3DoStep(s, k * step, step, 1, flags, flags + 8, flags + 16, flags + 24);
    fmu.fmi3GetFloat64(s, y, outputs.length, values, outputs.length);
    rows.push([...new Float64Array(fmu.memory.buffer, values, outputs.length)]);
  });
  return rows;
}"""


@needs_browser
def test_a_browser_gets_the_numbers_of_the_native_library(opened, tmp_path):
    description, made = archive("motorcycle", tmp_path)
    inputs, outputs = (references(description, names_of(description, k)) for k in ("input", "output"))
    given = {
        "code": base64.b64encode(made[MODULE]).decode(), "token": description.guid, "inputs": inputs,
        "outputs": outputs, "step": STEP, "signals": [signal(k, len(inputs)) for k in range(STEPS)],
    }  # fmt: skip
    with chromium() as browser:
        found = np.array(browser.new_page().evaluate(IN_THE_BROWSER, given))
    assert found == pytest.approx(native("motorcycle", description, opened), **EQUAL)
