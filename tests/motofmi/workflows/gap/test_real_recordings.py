"""Recordings of real machines with known effects; they are not part of the project."""

from pathlib import Path

import numpy as np
import pytest

import motofmi as mf
from benchmarks._sine_pendulum import SinePendulum
from tests import ROOT

MEASURED = ROOT.parent / "shared" / "data" / "measured"
pytestmark = pytest.mark.skipif(not MEASURED.is_dir(), reason="the folder of measured data is not beside the project")


def swings(component):
    folder = MEASURED / "multiarm_pendulum"
    fitted, others = ([str(p) for p in sorted(folder.glob(pattern))] for pattern in ("swing_*.csv", "validation_*.csv"))
    return mf.find_gap(fitted, validation=others, component=component)


def names(found):
    return {e["name"] for e in found.effects}


@pytest.mark.study
def test_a_filmed_pendulum_has_the_sine_of_large_angles():
    folder = MEASURED / "pendulum_camera"
    found = mf.find_gap(folder / "pendulum_first.csv", validation=folder / "pendulum_second.csv", component="pendulum")
    assert found.verdict == "named" and names(found) == {"geometric_nonlinearity"}
    assert found.to_dict()["explained"]["low"] > 0.99
    # A point mass on a rod has the share 1 of the sine: that is within three of the honest standard errors.
    share = found.effects[0]["parameters"]["share"]
    assert abs(share["value"] - 1) < 3 * share["standard_error"]


@pytest.mark.study
def test_swings_of_a_linear_pendulum_miss_the_sine():
    found = swings("pendulum")
    assert found.verdict == "named" and names(found) == {"geometric_nonlinearity"}
    share = found.effects[0]["parameters"]["share"]
    assert abs(share["value"] - 1) < 3 * share["standard_error"]


@pytest.mark.study
def test_swings_of_a_pendulum_with_its_sine_miss_friction_and_drag():
    assert names(swings(SinePendulum())) == {"coulomb_friction", "progressive_damping"}


@pytest.mark.study
def test_the_positioning_system_has_coulomb_friction():
    found = mf.find_gap(
        MEASURED / "emps/run.csv", validation=MEASURED / "emps/pulses.csv", component="mass_spring_damper"
    )
    assert found.verdict == "named" and names(found) == {"coulomb_friction"}
    force = found.effects[0]["parameters"]["friction_torque"]
    assert force["value"] == pytest.approx(20.4, rel=0.05)  # published; 5 % is what the data determine
    assert abs(force["value"] - 20.4) < 1.96 * force["standard_error"]


@pytest.mark.study
def test_the_silverbox_has_a_cubic_spring(tmp_path):
    time, voltage, answer = np.loadtxt(MEASURED / "silverbox/whole.csv", delimiter=",", skiprows=1).T
    paths = []
    for name, first in (("fitted", 40650), ("validation", 110000)):
        rows = np.column_stack([time, voltage, answer])[first : first + 4096]
        paths.append(Path(tmp_path / f"{name}.csv"))
        np.savetxt(paths[-1], rows, delimiter=",", header="time [s],force [N],displacement [m]", comments="")
    found = mf.find_gap(paths[0], validation=paths[1], component="mass_spring_damper")
    assert found.verdict == "named" and "hardening_stiffness" in names(found)
    assert next(e["form"] for e in found.effects if e["name"] == "hardening_stiffness") == "cubic"


@pytest.mark.study
def test_a_magnetorheological_damper_is_named():
    folder = MEASURED / "mr_damper"
    found = mf.find_gap(folder / "10mm1Hz1A.csv", validation=folder / "25mm0p5Hz1A.csv", component="mass_spring_damper", impose="displacement")  # fmt: skip
    assert found.verdict == "named" and names(found) <= {"coulomb_friction", "hysteresis"}
