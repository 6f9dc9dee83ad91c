"""Other people's simulators with a rider's FMU that holds a bar, against exact solutions and the theory of their couplings."""

import json
import os
import shutil
import subprocess
import sys

import numpy as np
import pytest

from benchmarks.__main__ import RESULTS
from fmus.export.build import build
from motofmi.scenarios.hosts import cofmpy_bar, container_bar, fmpy_bar, libcosim_bar, plain_c_bar, runge_kutta_bar
from motofmi.scenarios.hosts.device import Device
from motofmi.scenarios.hosts.rider_on_a_bar import ModeError, exact_motion
from rider_fmu import riders
from tests import ROOT
from tests.simulators.held_torques import STEP, agree, expected, struck_bar


def test_the_exact_motion_is_that_of_the_printed_equations():
    times = np.arange(501) * STEP
    # rtol 1e-12 of the integration, accumulated over 500 samples.
    np.testing.assert_allclose(exact_motion(times)[:, :4], struck_bar(times), atol=1e-10)


@pytest.mark.parametrize(
    ("scheme", "sign"), [("stale jacobi", -1), ("refreshed jacobi", 1), ("gauss-seidel", -1), ("iterated", -1)]
)
def test_the_modes_of_samples_are_the_eigenvalues_of_what_made_them(scheme, sign):
    # The theory: -k_a H / (2 c_t) of the slow mode's damping for a torque that is H / 2 late beyond what the rider's
    # own half step makes good, the opposite where it is refreshed; the next order is (H k_a / c_a)^2 and the like.
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
    def test_the_error_falls_with_the_square_of_the_step(self):
        coarse, fine = (plain_c_bar.run(h)["plain_c"]["trajectory_error"] for h in (2e-3, 1e-3))
        # The third order adds H |lambda| = 6 % of the error at 1 ms and twice that at 2 ms.
        assert coarse / fine == pytest.approx(4, rel=0.15)

    def test_the_slow_mode_is_a_thousand_times_nearer_than_with_torques_exchanged_alone(self):
        slow = plain_c_bar.run(STEP)["plain_c"]["slow"]
        assert abs(slow.damping_error) < 1e-3 * abs(expected("refreshed jacobi")["slow"].damping_error)

    @pytest.mark.slow
    def test_it_runs_outside_of_a_checkout(self, tmp_path):
        """From an installation, where the scenarios are the package `motofmi.scenarios` and there is no other
        folder."""
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


class TestRungeKutta:
    def test_a_torque_that_follows_the_motion_leaves_an_error_of_second_order(self):
        coarse, fine = (runge_kutta_bar.run(step)["runge_kutta"] for step in (2 * STEP, STEP))
        assert coarse["trajectory_error"] / fine["trajectory_error"] == pytest.approx(4, rel=0.2)
        assert abs(fine["slow"].damping_error) < 1e-3 * abs(expected("refreshed jacobi")["slow"].damping_error)


def test_the_fmu_is_stepped_only_when_it_is_met(tmp_path):
    rider = riders.load("mean_2011")
    device = Device(build(rider, tmp_path).path, tmp_path / "rider")
    device.meet(0.01, np.array([0.01, 0.5, 0.1]))
    before = device.get("torso_angle", "torso_rate")
    first = [device.torques(0.012, np.array([0.02, 0.4, 0.2])) for _ in range(6)]
    assert device.get("torso_angle", "torso_rate") == before
    assert all((torques == first[0]).all() for torques in first)
    device.close()


KEPT = {"fmpy_bar.ssp": "stale jacobi", "fmpy_bar.loop": "refreshed jacobi", "libcosim_bar.fixed_step": "stale jacobi",
        "container_bar.container": "stale jacobi", "cofmpy_bar.jacobi": "stale jacobi", "cofmpy_bar.gauss_seidel": "gauss-seidel"}  # fmt: skip


@pytest.mark.parametrize("name", KEPT)
def test_the_kept_results_are_those_of_the_coupling(name):
    """What docs/hosts.md shows, also of hosts that are not installed here."""
    host, way = name.split(".")
    found = json.loads(RESULTS.read_text("utf-8"))["hosts"][host][way]
    assert agree({mode: ModeError(**found[mode]) for mode in ("slow", "fast")}, KEPT[name], within=5e-6)
