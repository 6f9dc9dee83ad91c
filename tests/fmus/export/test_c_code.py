"""The generated C: compiles without a warning anywhere, and computes what the equations compute in Python."""

import ctypes
import shutil
import subprocess
from importlib.util import find_spec

import numpy as np
import pytest

from fmus import Component, input, output, parameter, state
from fmus.export.build import COMPILED, guid_of, source_contents
from fmus.export.c_code import literal
from fmus.export.compilers import host_compiler, zig
from fmus.export.interface import Interface
from fmus.linear_analysis.linearisation import linearise
from rider_fmu import riders
from rider_fmu.components.full_rider import on_rig
from tests import as_study
from vehicle_fmu import dampers, motorcycles

STRICT = ["-std=c99", "-Wall", "-Wextra", "-Wpedantic", "-Werror"]


class Words(Component):
    """Every word that equations may use."""

    gain = parameter("1", "Gain", start=1.7, min=0.1, max=10)
    double = parameter("1", "A name that C keeps for itself", start=0.4)
    signal = input("1", "Signal")
    value = state("1", "State")
    other = state("1", "Another state")
    smooth = output("1", "Smooth words")
    kinked = output("1", "Words with a kink")
    switched = output("1", "A switch inside a switch")

    def mass(self, v, m):
        return {
            ("value", "value"): 2 + v.gain + v.other**2,
            ("value", "other"): m.sin(v.value),
            ("other", "value"): v.double,
        }

    def equations(self, v, m):
        x, y = v.value, v.other
        return {
            "der(value)": m.sin(x) * m.cos(y) + m.exp(-(x**2)) + v.gain**-3 * m.atan2(x, 2 + y**2) + v.time * y,
            "der(other)": m.tanh(x)
            - m.sqrt(1 + y**2)
            + m.log(2 + x**4)
            + m.sinh(0.1 * x)
            - m.cosh(0.1 * y)
            + m.tan(0.1 * x) * v.double,
            "smooth": m.asin(0.1 * x) + m.acos(0.1 * y) + m.atan(x) + v.signal / 3 + m.pi,
            "kinked": m.absolute(x) * m.sign(y) + m.maximum(x, v.signal) + m.minimum(y, v.gain * x),
            "switched": m.where(x > y, m.where(v.signal > 0, x, x * y), v.gain / (1 + x**2)),
        }


def compiled_library(component, folder, fmi=2):
    if host_compiler() is None:
        pytest.skip("no C compiler on this machine")
    interface = Interface(component)
    for name, data in source_contents(interface, fmi).items():
        (folder / name.rpartition("/")[2]).write_bytes(data)
    subprocess.run(
        [*host_compiler(), *STRICT, "-O1", "-fPIC", "-shared", "-o", "model.so", *COMPILED[fmi], "-lm"],
        cwd=folder,
        check=True,
    )
    return interface, ctypes.CDLL(str(folder / "model.so"))


class Functions(ctypes.Structure):
    """The tail of the struct Model: pointers to the generated functions."""

    _fields_ = [("guid", ctypes.c_char_p),
                *((n, ctypes.c_uint) for n in ("n_variables", "n_values", "n_terms", "n_inputs", "n_states", "n_outputs", "first_input",
                                               "first_state", "first_output", "first_derivative", "tolerance", "output_order")),
                *((n, ctypes.c_int) for n in ("exact", "has_mass", "has_held")), ("held", ctypes.c_void_p),
                ("output_references", ctypes.POINTER(ctypes.c_uint)), ("variables", ctypes.c_void_p),
                *((n, ctypes.CFUNCTYPE(None, ctypes.c_void_p)) for n in ("parameters", "terms")),
                *((n, ctypes.CFUNCTYPE(None, ctypes.c_void_p, ctypes.c_void_p)) for n in ("rates", "mass")),
                *((n, ctypes.CFUNCTYPE(None, ctypes.c_void_p)) for n in ("outputs",)),
                *((n, ctypes.CFUNCTYPE(None, ctypes.c_void_p, ctypes.c_void_p, ctypes.c_void_p)) for n in ("jacobian",))]  # fmt: skip


LOADED = {
    "words": lambda: Words("words"),
    "rider": lambda: riders.load("mean_2011", cross_inertia=0.05),
    "motorcycle": lambda: motorcycles.load("sharp_1971"),
    "bicycle": lambda: motorcycles.load("benchmark_bicycle"),
    "progressive": lambda: dampers.load("progressive"),
    "full rider": lambda: riders.load("full_mean_2011"),
    "full rider on the rig": lambda: on_rig(riders.load("full_mean_2011")),
}


WITHIN_REACH = ("steer_angle", "torso_angle")  # of the full rider


@pytest.mark.slow
@pytest.mark.parametrize("name", [as_study(n) if "full" in n else n for n in LOADED])
def test_c_computes_what_the_equations_compute(name, tmp_path):
    component = LOADED[name]()
    interface, library = compiled_library(component, tmp_path)
    model = Functions.in_dll(library, "model")
    nx, ny, nu = model.n_states, model.n_outputs, model.n_inputs
    assert (nx, ny, nu) == (len(component.states), len(component.outputs), len(component.inputs))
    random = np.random.default_rng(2)
    for _ in range(20):
        values = {**component.start_values(), "time": random.uniform(0, 5)}
        values.update(
            {n: random.uniform(-2, 2) for n in component.states}, **{n: random.uniform(1, 9) for n in component.inputs}
        )
        values.update({n: random.uniform(-0.2, 0.2) for n in WITHIN_REACH if n in values and "full" in name})
        z = np.zeros(model.n_values + model.n_terms)
        for variable_name, value in values.items():
            z[interface.reference(variable_name)] = value
        f, mass, jacobian = np.zeros(nx), np.zeros((nx, nx)), np.zeros((nx + ny, nx + nu + 1))
        model.parameters(z.ctypes.data)
        model.terms(z.ctypes.data)
        model.rates(z.ctypes.data, f.ctypes.data)
        model.mass(z.ctypes.data, mass.ctypes.data)
        model.outputs(z.ctypes.data)
        rates = np.linalg.solve(mass, f) if nx else f
        expected, outputs = component.derivatives(
            *(np.array([values[n] for n in names]) for names in (component.states, component.inputs)), values["time"]
        )
        # The same sums in another order: roundings, weighed by the largest term.
        assert rates == pytest.approx(expected, rel=1e-10, abs=1e-12 * max(1, *np.abs(expected), 1))
        found = z[[model.output_references[i] for i in range(ny)]]
        assert found == pytest.approx(outputs, rel=1e-10, abs=1e-12)
        model.jacobian(z.ctypes.data, np.ascontiguousarray(rates).ctypes.data, jacobian.ctypes.data)
        linear = linearise(component, **values)
        assert jacobian[nx:, :nx] == pytest.approx(linear.C, rel=1e-10, abs=1e-9) and jacobian[
            nx:, nx:-1
        ] == pytest.approx(linear.D, rel=1e-10, abs=1e-9)
        if nx:
            assert np.linalg.solve(mass, jacobian[:nx, :nx]) == pytest.approx(
                linear.A, rel=1e-9, abs=1e-9 * np.abs(linear.A).max()
            )
            assert np.linalg.solve(mass, jacobian[:nx, nx:-1]) == pytest.approx(
                linear.B, rel=1e-9, abs=1e-9 * (1 + np.abs(linear.B).max())
            )


@pytest.mark.slow
def test_the_runtime_of_fmi_3_has_no_warnings(tmp_path):
    _, library = compiled_library(Words("words"), tmp_path, fmi=3)
    assert ctypes.CFUNCTYPE(ctypes.c_char_p)(("fmi3GetVersion", library))() == b"3.0"


@pytest.mark.skipif(shutil.which("clang") is None, reason="clang is not installed")
@pytest.mark.parametrize("fmi", [2, 3])
def test_a_second_compiler_has_no_warnings_either(fmi, tmp_path):
    without_warnings(["clang"], fmi, tmp_path)


@pytest.mark.slow
@pytest.mark.skipif(find_spec("ziglang") is None, reason="ziglang is not installed (pip install motofmi[platforms])")
@pytest.mark.parametrize("fmi", [2, 3])
def test_nor_has_the_compiler_for_all_platforms(fmi, tmp_path):
    without_warnings(zig(), fmi, tmp_path)


def without_warnings(compiler, fmi, folder):
    for name, data in source_contents(Interface(riders.load("mean_2011")), fmi).items():
        (folder / name.rpartition("/")[2]).write_bytes(data)
    subprocess.run([*compiler, *STRICT, "-c", *COMPILED[fmi]], cwd=folder, check=True)


@pytest.mark.slow
def test_only_the_c_runtime_and_its_mathematics_are_needed(tmp_path):
    if shutil.which("nm") is None:
        pytest.skip("nm is not installed")
    compiled_library(riders.load("mean_2011"), tmp_path)
    listed = subprocess.run(
        ["nm", "-D", "--undefined-only", "model.so"], cwd=tmp_path, capture_output=True, text=True, check=True
    ).stdout
    needed = {line.split()[-1].split("@")[0] for line in listed.splitlines()}
    weak = {
        "_ITM_deregisterTMCloneTable",
        "_ITM_registerTMCloneTable",
        "__cxa_finalize",
        "__gmon_start__",
        "__stack_chk_fail",
    }
    c = {
        "calloc",
        "free",
        "malloc",
        "memcmp",
        "memcpy",
        "memset",
        "snprintf",
        "strcmp",
        "strcpy",
        "strlen",
        "vsnprintf",
    }
    assert needed - weak <= c | {"exp2", "fmax", "fmin", "ldexp", "log2", "pow", "sqrt", "sin", "cos", "floor"}


def test_numbers_keep_all_their_digits():
    for value in (0.1, 1 / 3, 1e-300, 12345678.9):
        assert float(literal(value)) == value
    assert literal(float("inf")) == "DBL_MAX"


def test_a_guid_follows_from_the_content():
    one, other = (
        source_contents(Interface(riders.load("mean_2011", arm_damping=d)), 2)["modelDescription.xml"] for d in (19, 20)
    )
    assert one != other
    assert guid_of("0" * 64) == "{00000000-0000-0000-0000-000000000000}"
