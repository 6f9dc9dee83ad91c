"""FMUs linearised: against the exact Jacobian of their component, and coupled, against the one coupled system."""

import re
import zipfile

import numpy as np
import pytest

from fmus.cosimulation.cosimulate import cosimulate, join
from fmus.cosimulation.coupling_error import ToleranceWarning
from fmus.cosimulation.network import Network
from fmus.cosimulation.subsystems import linearised_fmu as fmu_linear
from fmus.cosimulation.subsystems.fmu_subsystem import FmuSubsystem
from fmus.export.build import build
from fmus.linear_analysis.linearisation import linearise
from motofmi.workflows.parts import GivenFmu
from motofmi.workflows.ridden_fmus import over_speed_fmus, ridden_fmus
from tests.coupled import BAR, MOTORCYCLE, RIDER
from vehicle_fmu import dampers, ridden


def same(found, exact, tolerance):
    """Whether two state spaces agree entry by entry, signals matched by name."""
    for matrix, rows, columns in (
        ("A", "states", "states"),
        ("B", "states", "inputs"),
        ("C", "outputs", "states"),
        ("D", "outputs", "inputs"),
    ):
        order = np.ix_(
            [getattr(found, rows).index(n) for n in getattr(exact, rows)],
            [getattr(found, columns).index(n) for n in getattr(exact, columns)],
        )
        expected = getattr(exact, matrix)
        scale = np.abs(expected).max(initial=1.0)
        assert np.abs(getattr(found, matrix)[order] - expected).max(initial=0.0) <= tolerance * scale, matrix


@pytest.mark.slow
@pytest.mark.parametrize("fmi", [2, 3])
@pytest.mark.parametrize("component", [RIDER, MOTORCYCLE, dampers.load("inerter")], ids=lambda c: c.name)
def test_directional_derivatives_give_the_exact_jacobian(tmp_path, component, fmi):
    subsystem = FmuSubsystem(build(component, tmp_path, fmi=fmi).path)
    same(subsystem.linearised(), linearise(component), 1e-13)
    subsystem.close()


@pytest.mark.slow
@pytest.mark.parametrize("backend", ["compiled", "python"])
def test_central_differences_give_the_same(tmp_path, backend):
    subsystem = FmuSubsystem(
        build(MOTORCYCLE, tmp_path, backend=backend).path, values={"steer_angle": 0.01, "speed": 25.0}
    )
    states = subsystem.state_values().copy()
    jacobian = fmu_linear.by_differences(subsystem)
    exact = linearise(MOTORCYCLE, speed=25.0)
    assert jacobian[:8, :8] == pytest.approx(exact.A, abs=1e-9 * np.abs(exact.A).max())  # rounding over 1e-3
    assert np.array_equal(subsystem.state_values(), states)
    subsystem.close()


@pytest.mark.slow
def test_a_progressive_damper_is_linearised_where_it_is(tmp_path):
    damper = dampers.load("progressive")
    subsystem = FmuSubsystem(build(damper, tmp_path).path)
    subsystem.exchange(np.array([0.0, 0.5, 0.0]))
    slope = -(damper.values["damping"] + 2 * damper.values["progression"] * 0.5)
    found = subsystem.linearised()
    assert found.D[found.outputs.index("handlebar_torque"), 1] == pytest.approx(slope, rel=1e-12)
    subsystem.close()


@pytest.mark.slow
@pytest.mark.parametrize("speed", [10.0, 30.0, 50.0])
def test_coupled_fmus_have_the_eigenvalues_of_the_one_coupled_system(speed):
    subsystems = ridden_fmus(MOTORCYCLE, RIDER, speed=speed)
    found = Network(subsystems, join(subsystems)).linearised()
    exact = linearise(ridden(MOTORCYCLE, RIDER), **{"vehicle.speed": speed})
    eigenvalues = np.linalg.eigvals(found.A)
    for eigenvalue in np.linalg.eigvals(exact.A):
        assert np.abs(eigenvalues - eigenvalue).min() <= 1e-9 * abs(eigenvalue)
    for subsystem in subsystems.values():
        subsystem.close()


def test_over_speed_gives_stacked_matrices_with_named_signals():
    subsystems = ridden_fmus(MOTORCYCLE, RIDER)
    stacked = over_speed_fmus(subsystems)(np.array([10.0, 20.0]))
    exact = linearise(ridden(MOTORCYCLE, RIDER), **{"vehicle.speed": np.array([10.0, 20.0])})
    assert stacked.A.shape == (2, 10, 10)
    order = [stacked.states.index(n) for n in exact.states]
    assert stacked.A[:, order][:, :, order] == pytest.approx(exact.A, rel=1e-12, abs=1e-9)
    for subsystem in subsystems.values():
        subsystem.close()


def closed(component, tmp_path):
    """The FMU of a component as somebody would ship it who shows nothing: no states, no derivatives, no saved
    states."""
    whole, bare = build(component, tmp_path).path, tmp_path / "closed.fmu"
    with zipfile.ZipFile(whole) as source, zipfile.ZipFile(bare, "w") as made:
        for name in source.namelist():
            data = source.read(name)
            if name == "modelDescription.xml":
                text = re.sub(
                    r'(canGetAndSetFMUstate|canSerializeFMUstate|providesDirectionalDerivative|canInterpolateInputs)="true"',
                    r'\1="false"',
                    data.decode(),
                )
                text = re.sub(r'maxOutputDerivativeOrder="\d"', 'maxOutputDerivativeOrder="0"', text)
                data = re.sub(r"<Derivatives>.*</Derivatives>", "", text, flags=re.DOTALL).encode()
            made.writestr(name, data)
    return bare


@pytest.fixture
def closed_rider(tmp_path):
    return closed(RIDER, tmp_path)


@pytest.mark.slow
@pytest.mark.parametrize(("component", "values"), [(BAR, {}), (MOTORCYCLE, {"speed": 5.0}), (MOTORCYCLE, {"speed": 30.0}), (MOTORCYCLE, {"speed": 55.0})],
                         ids=["double integrator", "unstable weave", "unstable capsize", "nearly undamped wobble"])  # fmt: skip
def test_what_integrates_or_grows_is_known_by_its_responses_too(component, values, tmp_path):
    subsystem = FmuSubsystem(closed(component, tmp_path), "closed", values)
    found, exact = subsystem.linearised(), np.linalg.eigvals(linearise(component, **values).A)
    assert len(found.states) == len(exact)
    # The Hankel matrix is cut at 1e-8; a double eigenvalue moves by the root of a perturbation.
    assert all(np.abs(np.linalg.eigvals(found.A) - e).min() <= 1e-4 * max(abs(e), 1.0) for e in exact)
    subsystem.close()


def test_an_fmu_that_shows_nothing_is_known_by_its_responses(closed_rider):
    subsystem = FmuSubsystem(closed_rider, "closed")
    assert subsystem.states == () and not subsystem.can_restore
    found, exact = subsystem.linearised(), linearise(RIDER)
    assert len(found.states) == 2
    eigenvalues = np.linalg.eigvals(exact.A)
    # The Hankel matrix is cut at 1e-8 of its largest singular value.
    assert all(np.abs(np.linalg.eigvals(found.A) - e).min() <= 1e-6 * abs(e) for e in eigenvalues)
    omega = np.array([1.0, 10.0, 50.0])
    for name in ("steer_angle", "steer_rate", "frame_rate"):
        assert found.frequency_response(omega, "handlebar_torque", name) == pytest.approx(
            exact.frequency_response(omega, "handlebar_torque", name), rel=1e-5
        )
    subsystem.close()


@pytest.mark.slow
def test_a_closed_fmu_is_coupled_within_its_target_at_a_millisecond(closed_rider):
    subsystems = ridden_fmus(MOTORCYCLE, GivenFmu(closed_rider), {"steer_rate": 0.5}, 30.0)
    with pytest.warns(
        ToleranceWarning
    ):  # the tolerance is a tenth of the target; an FMU that takes held inputs alone misses it
        run = cosimulate(subsystems, 1e-3, 0.5)
    swings = run.predicted.oscillatory
    assert np.all(np.abs(run.predicted.frequency_error[swings]) <= 1e-4)
    assert np.all(np.abs(run.predicted.damping_error[swings]) <= 1e-3)
    for subsystem in subsystems.values():
        subsystem.close()


@pytest.mark.slow
def test_a_static_fmu_that_shows_nothing_has_no_states(tmp_path):
    subsystem = FmuSubsystem(build(dampers.load("medium_2011"), tmp_path, backend="python").path)
    found = subsystem.linearised()
    assert found.states == ()
    assert found.D[found.outputs.index("handlebar_torque"), 1] == pytest.approx(
        -dampers.load("medium_2011").values["damping"], rel=1e-9
    )
    subsystem.close()
