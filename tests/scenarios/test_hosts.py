"""Other people's simulators with our FMUs inside, against exact solutions and the theory of their couplings."""

import importlib.util
import os
import shutil
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.linalg import expm

import vehicle_fmu
from fmus.export.build import build
from motofmi.scenarios.hosts import (
    cofmpy_bar,
    container_bar,
    exudyn_bicycle,
    fmpy_bar,
    hosts,
    libcosim_bar,
    mujoco_bar,
    plain_c_bar,
    table,
)
from motofmi.scenarios.hosts.device import Device
from motofmi.scenarios.hosts.rider_on_a_bar import (
    STEER_INERTIA,
    STRIKE,
    ModeError,
    exact_motion,
    measured_eigenvalues,
    mode_errors,
)
from rider_fmu import riders
from tests import ROOT
from vehicle_fmu import motorcycles

STEP = 1e-3
PAGE = ROOT / "docs" / "hosts.md"
TABLE_2 = Path(vehicle_fmu.__file__).parent / "published" / "meijaard_2007_eigenvalues.csv"


def struck_bar(times: np.ndarray) -> np.ndarray:
    """Steer angle, its rate, torso angle and rate by scipy from the equations as the 2011 paper prints them."""
    p = riders.load("mean_2011").values

    def rates(t, x):
        delta, s, theta, torso_rate = x
        arms = p["arm_stiffness"] * (theta - delta) + p["arm_damping"] * (torso_rate - s)
        waist = p["waist_stiffness"] * theta + p["waist_damping"] * torso_rate
        return s, arms / STEER_INERTIA, torso_rate, -(arms + waist) / p["torso_inertia"]

    return solve_ivp(rates, (0, times[-1]), [0, STRIKE, 0, 0], "DOP853", times, rtol=1e-12, atol=1e-14).y.T


def held_torque_samples(step: float, count: int, scheme: str) -> np.ndarray:
    """Samples of both parts solved exactly, with what they exchange held over a step as the scheme has it."""
    p = riders.load("mean_2011").values
    stiffness, damping, inertia = p["arm_stiffness"], p["arm_damping"], p["torso_inertia"]
    A = np.array([[0, 1], [-(stiffness + p["waist_stiffness"]) / inertia, -(damping + p["waist_damping"]) / inertia]])
    B = np.array([[0, 0], [stiffness / inertia, damping / inertia]])
    arms = np.array([stiffness, damping])
    held = expm(step * np.block([[A, B], [np.zeros((2, 4))]]))[:2]
    torso, bar, bar_input, torque, rows = np.zeros(2), np.array([0.0, STRIKE]), np.zeros(2), 0.0, []

    def bar_after_step(torque):
        return np.array(
            [bar[0] + step * bar[1] + step**2 * torque / (2 * STEER_INERTIA), bar[1] + step * torque / STEER_INERTIA]
        )

    for _ in range(count):
        if scheme == "refreshed jacobi":
            torque = arms @ (torso - bar)
        rows.append([*bar, *torso, torque])
        after = bar_after_step(torque)
        bar_input = bar if "jacobi" in scheme else after
        if scheme == "iterated":  # both with what holds at the end; contracts by H c_a / I = 0.03 an iteration
            for _ in range(15):
                bar_input = after
                after = bar_after_step(arms @ (held @ [*torso, *bar_input] - bar_input))
        torso = held @ [*torso, *bar_input]
        bar, torque = after, arms @ (torso - bar_input)
    return np.array(rows)


def expected(scheme: str) -> dict[str, ModeError]:
    return mode_errors(held_torque_samples(STEP, 1000, scheme), STEP)


def agree(found: dict, scheme: str, within: float = 1e-6) -> bool:
    """The modes of a host are those of the scheme.

    What is only in the memory of a coupling has decayed to 1e-8 in the samples, their rounding is 1e-15: 1e-7, and a
    factor for the two modes' condition. The schemes themselves differ by 1e-2 and more.
    """
    pairs = [(found[name], true) for name, true in expected(scheme).items()]
    return all(
        abs(f.frequency_error - t.frequency_error) < within and abs(f.damping_error - t.damping_error) < within
        for f, t in pairs
    )


def test_the_exact_motion_is_that_of_the_printed_equations():
    times = np.arange(501) * STEP
    # rtol 1e-12 of the integration, accumulated over 500 samples.
    np.testing.assert_allclose(exact_motion(times)[:, :4], struck_bar(times), atol=1e-10)


@pytest.mark.parametrize(
    ("scheme", "sign"), [("stale jacobi", -1), ("refreshed jacobi", 1), ("gauss-seidel", -1), ("iterated", -1)]
)
def test_the_modes_of_samples_are_the_eigenvalues_of_what_made_them(scheme, sign):
    # The theory: -k_a H / (2 c_t) of the slow mode's damping for a torque that is H / 2 late beyond what the rider's own
    # half step makes good, the opposite where it is refreshed; the next order is (H k_a / c_a)^2 and the like.
    p = riders.load("mean_2011").values
    first_order = p["arm_stiffness"] * STEP / (2 * p["waist_damping"])
    assert expected(scheme)["slow"].damping_error == pytest.approx(sign * first_order, rel=0.15)


@pytest.fixture(scope="module", autouse=True)
def cache_of_module(cache):
    """Runs that serve several tests keep to the cache of the tests, too."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("MOTOFMI_CACHE", str(cache))
        yield


@pytest.fixture(scope="module")
def fmpys():
    return fmpy_bar.run(STEP)


class TestFmpy:
    def test_simulate_fmu_records_what_follows_an_input_at_once_one_step_late(self, fmpys):
        # The rest of the response is known to 1e-16, so that only rounding is left: 1e-9 of a step.
        assert fmpys["simulate_fmu"]["lag_in_steps"] == pytest.approx(1, abs=1e-9)
        # Stiffness and damping of the arms, a step late, are 20 rad/s * 1 ms = 2 % off; the torque left of them and
        # the torso's is smaller, so more than that.
        assert fmpys["simulate_fmu"]["torque_error"] > 0.02

    def test_the_ssp_runner_hands_over_stale_torques(self, fmpys):
        assert agree(fmpys["ssp"], "stale jacobi")

    def test_in_a_loop_that_reads_after_it_has_set_they_are_of_the_moment(self, fmpys):
        assert agree(fmpys["loop"], "refreshed jacobi")


@pytest.mark.skipif(sys.platform != "linux", reason="the plain C host looks for the archive's library for Linux")
class TestPlainC:
    def test_rows_are_near_the_exact_solution(self):
        rows = plain_c_bar.rows(STEP, 1.0)
        np.testing.assert_array_equal(rows[:, 0], np.arange(1001) * STEP)
        true = struck_bar(rows[:, 0])
        # Second order: what is left out is T'' H^3 / 6 I in the rate, 0.03 ms of phase at most; measured 4.5e-5.
        assert np.abs(rows[:, 1] - true[:, 0]).max() < 1e-4 * np.abs(true[:, 0]).max()

    @pytest.mark.slow
    @pytest.mark.slow
    def test_the_error_falls_with_the_square_of_the_step(self):
        coarse, fine = (plain_c_bar.run(h)["plain_c"]["trajectory_error"] for h in (2e-3, 1e-3))
        # The third order adds H |lambda| = 6 % of the error at 1 ms and twice that at 2 ms.
        assert coarse / fine == pytest.approx(4, rel=0.15)

    def test_the_slow_mode_is_a_thousand_times_nearer_than_with_torques_exchanged_alone(self):
        slow = plain_c_bar.run(STEP)["plain_c"]["slow"]
        assert abs(slow.damping_error) < 1e-3 * abs(expected("refreshed jacobi")["slow"].damping_error)

    @pytest.mark.slow
    @pytest.mark.slow
    @pytest.mark.slow
    def test_it_runs_outside_of_a_checkout(self, tmp_path):
        """From an installation, where the scenarios are the package `motofmi.scenarios` and there is no other folder."""
        for name in ("fmus", "rider_fmu", "vehicle_fmu", "motofmi"):
            shutil.copytree(ROOT / name, tmp_path / name, ignore=shutil.ignore_patterns("__pycache__", "scenarios.py"))
        shutil.copytree(
            ROOT / "scenarios", tmp_path / "motofmi" / "scenarios", ignore=shutil.ignore_patterns("__pycache__")
        )
        environment = {**os.environ, "PYTHONPATH": str(tmp_path)}
        command = [sys.executable, "-m", "motofmi.scenarios.hosts.plain_c_bar"]
        done = subprocess.run(command, env=environment, cwd=tmp_path, capture_output=True, text=True, check=True)
        assert "trajectory_error" in done.stdout


class TestLibcosim:
    @pytest.fixture
    def found(self):
        pytest.importorskip("libcosimpy")
        return libcosim_bar.run(STEP)

    def test_it_hands_over_stale_torques(self, found):
        assert agree(found["fixed_step"], "stale jacobi")

    def test_ecco_chooses_steps_by_power_and_is_no_nearer(self, found):
        ecco = found["ecco"]
        assert ecco["smallest_step"] < STEP < ecco["largest_step"]
        # The torque is as stale as with fixed steps: the error is of the first order in the largest steps, at the end.
        assert ecco["trajectory_error"] > found["fixed_step"]["trajectory_error"]


def test_fmucontainer_hands_over_stale_torques():
    pytest.importorskip(
        "fmu_manipulation_toolbox", reason="fmu-manipulation-toolbox is not installed: pip install '.[hosts]'"
    )
    # It writes numbers of the description with nine digits.
    assert agree(container_bar.run(STEP)["container"], "stale jacobi", within=2e-6)


class TestCofmpy:
    @pytest.mark.parametrize(("name", "scheme"), [("jacobi", "stale jacobi"), ("gauss_seidel", "gauss-seidel")])
    def test_modes_are_those_of_the_coupling(self, cofmpys, name, scheme):
        assert agree(cofmpys[name], scheme)

    def test_iterated_it_stops_at_a_thousandth(self, cofmpys):
        # It stops where torques change by less than 1e-3 N.m, of 20 at the start and 1 at the end of the run.
        assert agree(cofmpys["iterated"], "iterated", within=1e-3)


@pytest.fixture(scope="module")
def cofmpys():
    pytest.importorskip(
        "cofmupy", reason="CoFMPy is not installed: pip install --no-deps cofmupy, see scenarios/hosts/cofmpy_bar.py"
    )
    return cofmpy_bar.run(STEP)


def relative_errors(found: dict) -> list[float]:
    return [abs(mode["error"] / mode["exact"]) for mode in found.values() if isinstance(mode, dict)]


class TestExudyn:
    @pytest.mark.parametrize("speed", [3, 5, 8])
    def test_the_bicycle_alone_has_the_printed_eigenvalues(self, speed):
        pytest.importorskip("exudyn")
        table = np.genfromtxt(TABLE_2, delimiter=",", names=True, skip_header=2)
        row = table[table["speed_m_per_s"] == speed][0]
        printed = np.array([row["caster"], row["capsize"], row["weave_real"] + 1j * row["weave_imag"]])
        bicycle = motorcycles.load("benchmark_bicycle")
        samples = exudyn_bicycle.free_motion(bicycle, speed, STEP, 1.0)
        found = measured_eigenvalues(samples, exudyn_bicycle.SAMPLING, printed)
        # Second order in the step: a wheel turns by up to 27 mrad in it, the caster mode decays by 20 1/s, and
        # (0.027)^2 / 12 = 6e-5 is what the trapezoidal rule leaves; three times that with the solver's own damping.
        # A rate of 1e-4 rad/s at the start leaves 1e-8 of what is not linear.
        np.testing.assert_allclose(found, printed, rtol=2e-4)

    def test_ridden_its_modes_are_those_of_the_one_linear_system(self):
        pytest.importorskip("exudyn")
        found = exudyn_bicycle.run(speed=5.0, step=STEP)
        # Second order in the step: (H |lambda|)^2 / 12 for the fastest mode, 83 1/s.
        assert max(relative_errors(found["ridden"])) < (83 * STEP) ** 2 / 12
        assert max(relative_errors(found["with_damper"])) < (83 * STEP) ** 2 / 12
        # A held torque is on average half a step late in a solver of its own: H |lambda| / 2 = 4 %.
        assert max(relative_errors(found["ridden_with_held_torque"])) > 0.04


def runge_kutta_with(device: Device, count: int) -> np.ndarray:
    """Samples of the bar in a solver of fourth order, with the device asked in its stages."""
    bar, rows = np.array([0.0, STRIKE]), []

    def rates(time, bar):
        return np.array([bar[1], device.torques(time, np.array([*bar, 0.0]))[0] / STEER_INERTIA])

    for k in range(count):
        t = k * STEP
        device.meet(t, np.array([*bar, 0.0]))
        rows.append([*bar, *device.get("torso_angle", "torso_rate", "handlebar_torque")])
        first = rates(t, bar)
        second = rates(t + STEP / 2, bar + STEP / 2 * first)
        third = rates(t + STEP / 2, bar + STEP / 2 * second)
        bar = bar + STEP / 6 * (first + 2 * second + 2 * third + rates(t + STEP, bar + STEP * third))
    return np.array(rows)


@pytest.mark.parametrize(
    "row",
    ["SSP runner", "a loop through fmpy", "`gauss_seidel` |", "`gauss_seidel`, iterative", "plain C", "Runge-Kutta"],
)
def test_the_page_tells_what_is_measured(row, tmp_path, request):
    line = next(line for line in PAGE.read_text("utf-8").splitlines() if line.startswith("|") and row in line)
    printed = [x.strip() for cell in line.split("|")[3:5] for x in cell.split(",")]
    schemes = {
        "SSP runner": "stale jacobi",
        "a loop through fmpy": "refreshed jacobi",
        "`gauss_seidel` |": "gauss-seidel",
    }
    if row == "plain C":
        if sys.platform != "linux":
            pytest.skip("the plain C host looks for the archive's library for Linux")
        found = plain_c_bar.run(STEP)["plain_c"]
    elif row == "Runge-Kutta":
        device = Device(build(riders.load("mean_2011"), tmp_path).path, tmp_path / "rider")
        found = mode_errors(runge_kutta_with(device, 1000), STEP)
        device.close()
    elif row in schemes:
        found = expected(schemes[row])
    else:
        found = request.getfixturevalue("cofmpys")["iterated"]
    measured = [
        100 * error for mode in ("slow", "fast") for error in (found[mode].frequency_error, found[mode].damping_error)
    ]
    # As many digits as the page prints.
    assert [f"{m:+.{len(p.partition('.')[2])}f}" for m, p in zip(measured, printed, strict=True)] == printed


def test_the_fmu_is_stepped_only_when_it_is_met(tmp_path):
    rider = riders.load("mean_2011")
    device = Device(build(rider, tmp_path).path, tmp_path / "rider")
    device.meet(0.01, np.array([0.01, 0.5, 0.1]))
    before = device.get("torso_angle", "torso_rate")
    first = [device.torques(0.012, np.array([0.02, 0.4, 0.2])) for _ in range(6)]
    assert device.get("torso_angle", "torso_rate") == before
    assert all((torques == first[0]).all() for torques in first)
    device.close()


def test_without_its_package_a_host_says_so_in_one_line(monkeypatch):
    monkeypatch.setitem(sys.modules, "mujoco", None)  # as if it were not installed
    with pytest.raises(SystemExit, match=r"mujoco is not installed: pip install '\.\[hosts\]'"):
        table.main(mujoco_bar.run)


def test_what_was_found_is_shown_by_name(capsys):
    table.main(lambda: {"loop": {"slow": ModeError(1.2, 0.24, -0.01, 0.1), "trajectory_error": 0.05}})
    assert [line.split() for line in capsys.readouterr().out.splitlines()] == [
        ["loop"], ["slow"], ["frequency", "1.2"], ["damping_ratio", "0.24"], ["frequency_error", "-0.01"], ["damping_error", "0.1"],
        ["trajectory_error", "0.05"]]  # fmt: skip


@pytest.mark.slow
def test_every_host_is_listed_and_says_what_it_needs():
    shown = subprocess.run(
        [sys.executable, "-m", "motofmi.scenarios.hosts"], cwd=ROOT, capture_output=True, text=True, check=True
    ).stdout
    for name, host in hosts().items():
        assert host.HOST and host.__doc__ and callable(host.run)
        (line,) = [line for line in shown.splitlines() if f"motofmi.scenarios.hosts.{name}" in line.split()]
        assert line.startswith(host.HOST) and ("not installed" in line) == (
            importlib.util.find_spec(host.PACKAGE) is None
        )


SHARED = {"device", "exudyn_tree", "rider_on_a_bar", "table"}  # modules that hosts share


def test_the_page_of_hosts_names_every_module_that_runs_a_simulator():
    modules = {path.stem for path in (ROOT / "scenarios" / "hosts").glob("*.py") if not path.stem.startswith("_")}
    page = (ROOT / "docs" / "hosts.md").read_text("utf-8")
    assert set(hosts()) <= modules - SHARED
    assert [name for name in sorted(modules - SHARED) if f"`{name}`" not in page] == []


NEW = """
import numpy as np

HOST, PACKAGE = "a new tool", "numpy"


def run():
    return {"nothing": 0.0}


SAMPLES = {"a new tool": lambda fmus, step, count: np.zeros((count, 5))}
"""


@pytest.mark.slow
def test_a_host_is_one_file(tmp_path):
    """A new file in the folder of the hosts is in the list and in the benchmark of couplings."""
    (tmp_path / "new_tool.py").write_text(NEW, "utf-8")
    code = f"""
import motofmi.scenarios.hosts as package
package.__path__.append({str(tmp_path)!r})
from motofmi.scenarios.hosts.__main__ import main
main()
from benchmarks.coupling import PEERS
print("peers:", *PEERS, sep=";")
"""
    shown = subprocess.run([sys.executable, "-c", code], cwd=ROOT, capture_output=True, text=True, check=True).stdout
    assert any(
        line.split() == ["a", "new", "tool", "python", "-m", "motofmi.scenarios.hosts.new_tool"]
        for line in shown.splitlines()
    )
    peers = shown.rpartition("peers:")[2].strip().split(";")
    assert {"a new tool", "fmpy loop", "fmpy SSP runner", "fmucontainer in fmpy", "libcosim", "CoFMPy"} <= set(peers)
