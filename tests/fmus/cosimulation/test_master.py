"""The compiled loop does what the loop in Python does, stops where that stops, and is left out where it cannot be."""

import subprocess
import time

import numpy as np
import pytest

from fmus.cosimulation.cosimulate import cosimulate, join
from fmus.cosimulation.coupling import COUPLINGS
from fmus.cosimulation.master import library as loop_library
from fmus.cosimulation.master.select import CompiledMaster, InterpretedMaster, master
from fmus.cosimulation.network import Network
from fmus.cosimulation.profiles import Profile
from fmus.cosimulation.subsystems.fmu_subsystem import FmuSubsystem
from fmus.export import compilers
from fmus.export.build import build
from fmus.support.errors import SimulationError
from motofmi.workflows.parts import GivenFmu
from motofmi.workflows.ridden_fmus import ridden_fmus
from tests import coupled
from tests.coupled import MOTORCYCLE, RIDER
from vehicle_fmu import dampers


@pytest.fixture
def subsystems():
    made = []

    def make(device=RIDER):
        made.append(ridden_fmus(MOTORCYCLE, device, {"steer_rate": 0.5}, 30.0))
        return made[-1]

    yield make
    for each in made:
        for subsystem in each.values():
            subsystem.close()


@pytest.mark.slow
@pytest.mark.parametrize("name", COUPLINGS)
def test_both_loops_give_the_same_rows(subsystems, name):
    fast, plain = (cosimulate(subsystems(), 4e-3, 0.2, name, compiled=each) for each in (True, False))
    scale = np.abs(plain.rows).max(axis=0)
    # Sums in another order; an iteration stops when it has converged to 1e-10.
    assert np.all(np.abs(fast.rows - plain.rows) <= 1e-9 * np.maximum(scale, 1e-6))
    assert fast.power_residual == pytest.approx(plain.power_residual, rel=1e-6, abs=1e-9)


@pytest.mark.slow
def test_both_loops_follow_inputs_and_renew_a_linearisation(subsystems):
    results = []
    for each in (True, False):
        made = subsystems(dampers.load("progressive"))
        wiring = join(made)
        profile = Profile.over_time(
            Network(made, wiring),
            np.array([0.0, 0.1, 0.2]),
            {"speed": np.array([30.0, 28.0, 31.0]), "steer_torque": np.array([0.0, 50.0, 0.0])},
        )
        results.append(
            cosimulate(made, 5e-3, 0.2, "interface_jacobian", wiring=wiring, profile=profile, compiled=each).rows
        )
    scale = np.abs(results[1]).max(axis=0)
    assert np.all(np.abs(results[0] - results[1]) <= 1e-7 * np.maximum(scale, 1e-6))  # the FMUs' own tolerance is 1e-10


def test_a_failed_step_names_the_fmu_and_its_reason(subsystems):
    made = subsystems()
    wiring = join(made)
    profile = Profile.over_time(Network(made, wiring), np.array([0.0, 0.1]), {"speed": np.array([30.0, -30.0])})
    with pytest.raises(SimulationError, match=r"vehicle: fmi2DoStep failed.*speed"):
        cosimulate(made, 5e-3, 0.1, "jacobi", wiring=wiring, profile=profile)


@pytest.fixture
def third_riders(subsystems, tmp_path):
    """The motorcycle with a rider of FMI 3.0, as often as asked for."""
    archive = GivenFmu(build(RIDER, tmp_path, fmi=3).path)
    return lambda: subsystems(archive)


@pytest.mark.slow
@pytest.mark.parametrize("name", COUPLINGS)
def test_both_loops_take_fmi_3(third_riders, subsystems, name):
    fast, plain = (cosimulate(third_riders(), 4e-3, 0.1, name, compiled=each).rows for each in (True, False))
    second = cosimulate(subsystems(), 4e-3, 0.1, name).rows
    scale = np.maximum(np.abs(second).max(axis=0), 1e-6)
    # Sums in another order; FMI 3.0 represents polynomials by four values each, which costs some digits.
    assert np.all(np.abs(fast - plain) <= 1e-9 * scale)
    assert np.all(np.abs(fast - second) <= 1e-8 * scale)


@pytest.mark.slow
def test_without_a_compiler_python_sets_the_input_derivatives_of_fmi_3(third_riders, request):
    with_compiler, without_compiler = third_riders(), third_riders()
    reference = cosimulate(with_compiler, 4e-3, 0.1, "interface_jacobian").rows
    request.getfixturevalue("without_compiler")
    loop_library.library.cache_clear()
    found = cosimulate(without_compiler, 4e-3, 0.1, "interface_jacobian", compiled=False).rows
    loop_library.library.cache_clear()
    np.testing.assert_allclose(found, reference, rtol=0, atol=1e-9 * np.abs(reference).max())  # sums in another order


def test_a_subsystem_that_is_no_fmu_is_looped_over_in_python():
    network = coupled.network()
    assert isinstance(master(network, COUPLINGS["jacobi"].prepare(network, 1e-3)), InterpretedMaster)


def test_without_a_compiler_the_loop_is_in_python(subsystems, request):
    made = subsystems()
    network = Network(made, join(made))
    running = COUPLINGS["jacobi"].prepare(network, 1e-3)
    assert isinstance(master(network, running), CompiledMaster)
    request.getfixturevalue("without_compiler")
    loop_library.library.cache_clear()
    assert isinstance(master(network, running), InterpretedMaster)


@pytest.fixture
def seconds(tmp_path):
    """seconds(devices, steps): processor time of a run of as many riders on one bar, set-up included, the least of
    two."""
    rider, bar = build(RIDER, tmp_path).path, build(coupled.BAR, tmp_path).path

    def taken(devices, steps):
        times = []
        for _ in range(2):
            made = {
                "vehicle": FmuSubsystem(bar, "vehicle", {"steer_rate": 0.1}),
                **{f"device_{k}": FmuSubsystem(rider, f"device_{k}") for k in range(devices)},
            }
            began = time.process_time()
            cosimulate(made, 1e-4, steps * 1e-4, "jacobi")
            times.append(time.process_time() - began)
            for subsystem in made.values():
                subsystem.close()
        return min(times)

    return taken


@pytest.mark.slow
def test_a_step_of_ten_times_the_devices_costs_ten_times_as_much(seconds):
    # As many steps of a device in both; were the cost quadratic, the ratio would be ten.
    many, few = seconds(60, 5_000) - seconds(60, 1), seconds(6, 50_000) - seconds(6, 1)
    assert many < 3 * few


@pytest.mark.slow
def test_the_cost_of_a_run_grows_with_its_duration(seconds):
    # 5 times as much for linear cost, 35 times as much for quadratic cost; the speed of a core varies by a factor of two.
    nothing, short, long = (seconds(2, steps) for steps in (1, 50_000, 300_000))
    assert long - short < 15 * (short - nothing)


LAYOUT = """#include <stdbool.h>
#include <stddef.h>
#include <stdio.h>
#define EXPORT
#include "structures.h"
int main(void) {{ {prints} return 0; }}
"""


def test_python_and_c_have_the_same_layout_of_every_structure(tmp_path):
    """The compiler's sizes and offsets of all fields against those with which Python fills the structures."""
    ffi = loop_library.structures()
    found = {}
    for kind in ("Path", "Matrix", "Subsystem", "Master"):
        found[f"sizeof({kind})"] = ffi.sizeof(kind)
        found |= {f"offsetof({kind}, {name})": ffi.offsetof(kind, name) for name, _ in ffi.typeof(kind).fields}
    prints = " ".join(f'printf("%zu\\n", {each});' for each in found)
    (tmp_path / "layout.c").write_text(LAYOUT.format(prints=prints), "utf-8")
    header = tmp_path / "structures.h"
    header.write_bytes(loop_library.source("structures.h"))
    (compiler,) = compilers.commands(compilers.host(), native=True)
    subprocess.run([*compiler, str(tmp_path / "layout.c"), "-o", str(tmp_path / "layout")], check=True)
    printed = subprocess.run([str(tmp_path / "layout")], check=True, capture_output=True, text=True).stdout.split()
    assert dict(zip(found, map(int, printed), strict=True)) == found
    assert len(found) > 80
