"""The result of a co-simulation: columns by name, conversions, figures, and whether its tolerance is met."""

import re
import warnings

import numpy as np
import pytest

from fmus.cosimulation.cosimulate import TOLERANCE, cosimulate
from fmus.cosimulation.coupling import COUPLINGS, coupling
from fmus.cosimulation.coupling_error import ToleranceWarning, assess, predict
from fmus.cosimulation.subsystems.fmu_subsystem import FmuSubsystem
from fmus.export.build import build
from fmus.support.errors import InputError
from rider_fmu import riders
from tests import coupled

COUPLED = ("vehicle.steer_angle", "vehicle.steer_rate", "device.handlebar_torque")


@pytest.fixture
def run(tmp_path):
    """run(step, duration, coupling, **options): the mean rider on a struck bar."""
    rider, bar = build(riders.load("mean_2011"), tmp_path).path, build(coupled.BAR, tmp_path).path

    def made(step=1e-3, duration=0.05, name=None, **options):
        with FmuSubsystem(bar, "vehicle", {"steer_rate": 0.1}) as vehicle, FmuSubsystem(rider, "device") as device:
            return cosimulate({"vehicle": vehicle, "device": device}, step, duration, name, **options)

    return made


@pytest.mark.slow
def test_a_column_is_found_by_name_and_a_wrong_name_gets_the_nearest(run):
    found = run()
    assert set(COUPLED) <= set(found) and "time" in found and len(found) == len(found.columns)
    np.testing.assert_array_equal(found["time"], found.rows[:, 0])
    assert found["vehicle.steer_rate"][0] == 0.1
    with pytest.raises(
        InputError, match=re.escape("unknown column 'vehicle.steer_angl', did you mean 'vehicle.steer_angle'")
    ):
        found["vehicle.steer_angl"]
    with pytest.raises(InputError, match="did you mean"):
        found.plot("vehicle.steer_angl")


@pytest.mark.slow
def test_rows_in_a_file_are_read_from_there(run, tmp_path):
    kept, written = run(), run(out=tmp_path / "run.csv")
    assert len(written.rows) == 0
    for name in kept:
        np.testing.assert_array_equal(written[name], kept[name])


@pytest.mark.slow
def test_tables_of_pandas_and_xarray_have_units_and_time(run):
    found = run()
    table = found.to_dataframe()
    assert tuple(table.columns) == found.columns
    np.testing.assert_array_equal(table["vehicle.steer_angle [rad]"], found["vehicle.steer_angle"])
    data = found.to_xarray()
    assert data.time.units == "s" and data["device.handlebar_torque"].units == "N.m"
    np.testing.assert_array_equal(
        data["device.handlebar_torque"].sel(time=0.02, method="nearest"), found["device.handlebar_torque"][20]
    )


@pytest.mark.slow
def test_a_figure_has_axes_with_units_for_each_unit(run):
    found = run()
    angles, torque = found.plot("vehicle.steer_angle", "device.torso_angle", "device.handlebar_torque")
    assert "[rad]" in angles.get_ylabel() and "[N.m]" in torque.get_ylabel() and torque.get_xlabel() == "time [s]"
    np.testing.assert_array_equal(angles.lines[0].get_ydata(), found["vehicle.steer_angle"])
    angles.figure.clear()
    assert "<img" in found._repr_html_() and "handlebar_torque" in found._repr_html_()


@pytest.mark.slow
def test_the_repr_is_one_line(run):
    found = run()
    assert (
        repr(found)
        == f"<CosimulationRun: 50 steps of 0.001 s, coupling {found.coupling}, within the tolerance, {len(found.columns) - 1} signals>"
    )


@pytest.mark.slow
def test_a_step_that_meets_the_tolerance_needs_no_advice(run):
    found = run()
    assert found.meets_tolerance is True and found.advice is None


@pytest.mark.slow
def test_a_step_too_long_is_warned_of_with_one_that_meets_the_tolerance(run):
    with pytest.warns(ToleranceWarning, match="no coupling meets it at this step; take a step of at most"):
        found = run(0.1, 1.0)
    assert (
        found.meets_tolerance is False
        and "interface_jacobian exceeds the tolerance of 1e-05 at a step of 0.1 s" in found.advice
    )
    step, name = re.search(r"at most ([\d.e-]+) s, with (\w+)", found.advice).groups()
    network = coupled.network()
    assert predict(coupling(name), network, float(step)).worst <= TOLERANCE
    assert min(predict(c, network, 0.1).worst for c in COUPLINGS.values()) > TOLERANCE
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        assert run(float(step), 1.0).meets_tolerance


@pytest.mark.slow
def test_a_named_coupling_that_misses_the_tolerance_gets_a_better_one_as_advice(run):
    found = run(1e-3, 0.05, "jacobi")  # named: no warning
    assert found.meets_tolerance is False
    better = re.search(r"; (\w+) meets it at this step", found.advice)[1]
    assert predict(coupling(better), coupled.network(), 1e-3).worst <= TOLERANCE


@pytest.mark.slow
def test_a_tolerance_that_nothing_meets_is_said():
    network = coupled.network()
    found = assess(coupling("jacobi"), predict(coupling("jacobi"), network, 1e-3), network, 1e-3, 1e-300)
    assert not found.meets_tolerance and "take a larger tolerance" in found.advice
