"""SSP archives: against the schema, fmpy's runner, and the FMUs that went in; participation; wiring that is refused."""

import json
import zipfile

import numpy as np
import pytest
from fmpy.ssp.simulation import simulate_ssp
from fmpy.ssp.ssd import Parameter, ParameterSet, read_ssd
from scipy.io import loadmat

from fmus.cosimulation.cosimulate import cosimulate
from fmus.cosimulation.network import Network, agree
from fmus.cosimulation.ssp import read_ssp, write_ssp
from fmus.export.build import build
from fmus.linear_analysis.linearisation import StateSpace, linearise
from fmus.linear_analysis.participation import participation
from fmus.support.errors import InputError
from motofmi.cli.main import main
from tests.coupled import MOTORCYCLE, RIDER
from vehicle_fmu import dampers, ridden

PORT = {**{f"device.{n}": [f"vehicle.{n}"] for n in ("steer_angle", "steer_rate", "frame_rate")},
        **{f"vehicle.{n}": [f"device.{n}"] for n in ("handlebar_torque", "frame_torque")}}  # fmt: skip
VALUES = {"vehicle": {"speed": 30.0, "steer_rate": 0.5, "added_steer_inertia": 0.02}, "device": {"arm_damping": 25.0}}


@pytest.fixture
def archive(tmp_path):
    fmus = {"vehicle": build(MOTORCYCLE, tmp_path).path, "device": build(RIDER, tmp_path).path}
    return write_ssp(tmp_path / "ridden.ssp", fmus, PORT, VALUES)


def test_the_structure_is_valid_ssp_with_units_and_bindings(archive):
    structure = read_ssd(str(archive), validate=True)
    assert [c.name for c in structure.system.elements] == ["vehicle", "device"]
    text = zipfile.ZipFile(archive).read("SystemStructure.ssd").decode()
    assert '<ssc:Unit name="N.m"><ssc:BaseUnit kg="1" m="2" s="-2" />' in "".join(
        line.strip() for line in text.splitlines()
    )
    assert 'name="handlebar_torque" kind="input"' in text


def test_what_is_read_back_runs_as_what_was_written(archive):
    system = read_ssp(archive)
    subsystems, wiring = system.subsystems, system.wiring
    assert wiring == PORT
    assert system.fmus["device"].get("arm_damping") == 25.0
    exact = linearise(
        ridden(MOTORCYCLE, RIDER.with_values(arm_damping=25.0, added_steer_inertia=0.02)), **{"vehicle.speed": 30.0}
    )
    found = Network(subsystems, wiring).linearised()
    for eigenvalue in np.linalg.eigvals(exact.A):
        assert np.abs(np.linalg.eigvals(found.A) - eigenvalue).min() <= 1e-9 * abs(eigenvalue)
    assert np.abs(cosimulate(subsystems, 1e-2, 0.1, wiring=wiring)["vehicle.roll_angle"]).max() > 0
    system.close()


@pytest.mark.slow
def test_fmpy_runs_the_archive(archive):
    # fmpy reads the bindings of an archive, but its runner applies only what it is given by hand.
    bound = [
        Parameter(name=f"{unit}.{name}", value=value)
        for unit, values in VALUES.items()
        for name, value in values.items()
    ]
    theirs = simulate_ssp(
        str(archive), stop_time=0.02, step_size=1e-3, parameter_set=ParameterSet(name="bound", parameters=bound)
    )
    system = read_ssp(archive)
    subsystems, wiring = system.subsystems, system.wiring
    ours = cosimulate(subsystems, 1e-3, 0.02, "jacobi", wiring=wiring)
    # Its connections are one step late and its rows are stamped one step early: alike within what a step changes.
    assert theirs["vehicle.steer_rate"][-3] == pytest.approx(ours["vehicle.steer_rate"][-3], abs=0.05 * 0.5)
    system.close()


def test_shares_of_the_units_add_up_and_find_the_rider(archive):
    system = read_ssp(archive)
    subsystems, wiring = system.subsystems, system.wiring
    eigenvalues, shares = participation(Network(subsystems, wiring).linearised())
    assert sum(shares.values()) == pytest.approx(np.ones(len(eigenvalues)))
    frequency = eigenvalues.imag / (2 * np.pi)
    rider_wobble, weave = np.argmin(np.abs(frequency - 4.8)), np.argmin(np.abs(frequency - 3.0))
    assert shares["device"][rider_wobble] > shares["device"][weave]  # the torso is what moves in the former
    system.close()


def test_participation_of_units_that_do_not_touch():
    space = StateSpace(
        np.diag([-1.0, -2.0]), np.zeros((2, 0)), np.zeros((0, 2)), np.zeros((0, 0)), ("a.x", "b.x"), (), ()
    )
    eigenvalues, shares = participation(space)
    assert eigenvalues.real.tolist() == [-1, -2]
    assert shares["a"].tolist() == [1, 0] and shares["b"].tolist() == [0, 1]


@pytest.mark.slow
def test_wrong_wiring_is_refused_by_name(tmp_path):
    fmus = {
        "vehicle": build(MOTORCYCLE, tmp_path).path,
        "device": build(RIDER, tmp_path).path,
        "damper": build(dampers.load("low_2011"), tmp_path).path,
    }
    out = tmp_path / "wrong.ssp"
    with pytest.raises(
        InputError, match=r"vehicle.frame_rate \[rad/s\] cannot drive device.steer_angle \[rad\]: the units differ"
    ):
        write_ssp(out, fmus, {"device.steer_angle": ["vehicle.frame_rate"]})
    with pytest.raises(InputError, match=r"unknown output 'vehicle.steer', did you mean"):
        write_ssp(out, fmus, {"device.steer_angle": ["vehicle.steer"]})
    with pytest.raises(
        InputError, match=r"vehicle.handlebar_torque has 2 writers: device.handlebar_torque, damper.handlebar_torque"
    ):
        write_ssp(out, fmus, {"vehicle.handlebar_torque": ["device.handlebar_torque", "damper.handlebar_torque"]})
    with pytest.raises(InputError, match="unknown variable of device 'arm_dampin'"):
        write_ssp(out, fmus, PORT, {"device": {"arm_dampin": 1.0}})
    assert not out.exists()
    out.write_text("no archive")
    with pytest.raises(InputError, match=r"wrong\.ssp is not an SSP archive"):
        read_ssp(out)


@pytest.mark.slow
def test_modes_of_an_archive_with_the_share_of_each_fmu(archive, tmp_path):
    result = tmp_path / "modes.json"
    matrices = tmp_path / "ridden.mat"
    assert main(["modes", "--ssp", str(archive), "--speed", "30,50", "--json", str(result), "--matlab", str(matrices)]) == 0
    found = json.loads(result.read_text())
    exact = linearise(
        ridden(MOTORCYCLE, RIDER.with_values(arm_damping=25.0, added_steer_inertia=0.02)), **{"vehicle.speed": 30.0}
    )
    weave = complex(*found["modes"]["weave"]["eigenvalue"][0])
    assert np.abs(np.linalg.eigvals(exact.A) - weave).min() <= 1e-9 * abs(weave)
    ridden_fmus = loadmat(matrices)
    assert ridden_fmus["speed"].ravel() == pytest.approx([30.0, 50.0])
    # The FMUs give the entries of A with the rounding of their C code.
    assert np.abs(np.linalg.eigvals(ridden_fmus["A"][:, :, 0]) - weave).min() <= 1e-9 * abs(weave)
    for mode in found["unstable"]:
        shares = found["participation"][mode]
        assert set(shares) == {"vehicle", "device"}
        assert np.sum(list(shares.values()), axis=0) == pytest.approx([1, 1])


def test_units_of_the_same_measure_agree():
    assert agree("N.m", "Nm") and agree("", "rad") and agree("bogus", "bogus")
    assert not agree("rad", "deg") and not agree("rad", "rad/s") and not agree("bogus", "rad")
