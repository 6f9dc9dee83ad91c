"""Couplings: their printed errors, their orders, their knots, and loops that are refused."""

import os
import shutil
import subprocess
import sys
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from fmus.cosimulation.cosimulate import TOLERANCE, choose, join
from fmus.cosimulation.coupling import COUPLINGS, coupling
from fmus.cosimulation.coupling.iterated import COUPLING as ITERATED
from fmus.cosimulation.coupling_error import largest_stable_step, linear_network, predict
from fmus.cosimulation.network import Network
from fmus.cosimulation.polynomials import (
    END,
    HELD,
    HERMITE,
    LINE,
    LINEAR,
    PARABOLA,
    QUADRATIC,
    TAYLOR,
    nearest,
    through,
)
from fmus.cosimulation.scheme import Continuation
from fmus.cosimulation.subsystems.subsystem import LinearSubsystem
from fmus.linear_analysis.linearisation import StateSpace
from fmus.support.errors import InputError
from tests import ROOT
from tests.coupled import exact_eigenvalues, network, spaces

# Measured with another implementation (discrete-time eigenvalues of hand-written updates), in % of the mode of the
# mean rider on a bar of 0.6 kg.m2: (slow frequency, slow damping, fast frequency, fast damping) at 1 and at 10 ms.
# None: unstable. In UNDAMPED the frequency is |lambda|, in DAMPED the imaginary part. Rounded as printed there.
UNDAMPED = [
    ("Jacobi", COUPLINGS["jacobi"], (-0.33, 10.6, 1.2, -0.9), (-2.6, 110, 13, -13)),
    ("Gauss-Seidel", COUPLINGS["gauss_seidel"], (0.44, -11.3, 0.4, -0.3), None),
    ("iterated, held inputs", replace(ITERATED, after=Continuation(END)), (0.35, -10.6, -1.1, 0.8), None),
]
IMPLICIT = replace(ITERATED, before=Continuation(HELD))
DAMPED = [
    ("both linear", COUPLINGS["iterated"], (0.003, 0.005, 0.010, -0.018), (0.29, 0.50, 0.98, -1.8)),
    ("angle Hermite, torque linear", replace(IMPLICIT, after=Continuation(LINE, HERMITE, None)), (0.000, 0.000, 0.007, -0.012), (-0.007, -0.035, 0.65, -1.2)),
    ("angle Hermite, torque quadratic", replace(IMPLICIT, after=Continuation(PARABOLA, HERMITE, None)), (0.000, 0.000, 0.0001, 0.0002), (0.0005, -0.001, 0.15, 0.20)),
    ("one pass", COUPLINGS["hermite"], (0.000, 0.000, -0.0008, -0.002), (-0.004, 0.011, -2.7, -0.25)),
    ("Jacobi, quadratic", COUPLINGS["jacobi_quadratic"], (0.000, 0.000, 0.0002, -0.004), (0.011, 0.066, -2.1, -2.3)),
    ("Jacobi, cubic", replace(COUPLINGS["jacobi"], before=Continuation((*QUADRATIC, (-3, 0)))), (0.000, 0.000, 0.0002, 0.000), None),
]  # fmt: skip


def errors(scheme, step, frequency):
    """The four errors in %, of the exact eigenvalues written down by hand; None when unstable."""
    prediction = predict(scheme, network(), step)
    if not prediction.stable:
        return None
    exact = exact_eigenvalues()
    coupled = np.array([prediction.everything[np.abs(prediction.everything - e).argmin()] for e in exact])
    damping = (coupled.real / np.abs(coupled)) / (exact.real / np.abs(exact)) - 1
    return 100 * np.column_stack([frequency(coupled) / frequency(exact) - 1, damping]).ravel()


def rounding(printed):
    """Half a subsystem of the last printed digit, read from the shortest text; a printed 0.000 has three digits."""
    text = f"{printed}".rstrip("0").rstrip(".") if printed else "0.000"
    return 0.5001 * 10.0 ** -(len(text.partition(".")[2])) if printed else 0.0005001


@pytest.mark.parametrize(("scheme", "frequency", "one", "ten"),
                         [pytest.param(s, np.abs, a, b, id=n) for n, s, a, b in UNDAMPED]
                         + [pytest.param(s, np.imag, a, b, id=n) for n, s, a, b in DAMPED])  # fmt: skip
def test_printed_errors_of_the_rider_on_the_bar(scheme, frequency, one, ten):
    for step, printed in ((1e-3, one), (1e-2, ten)):
        found = errors(scheme, step, frequency)
        if printed is None:
            assert found is None
        else:
            assert np.all(np.abs(found - printed) <= [rounding(x) for x in printed]), found


TARGETS = {1e-3: (1e-5, 1e-4), 1e-2: (5e-4, 5e-3)}  # step: largest error of frequency and of damping ratio


@pytest.mark.slow
@pytest.mark.parametrize("speed", [None, 10.0, 30.0, 50.0])
@pytest.mark.parametrize("name", ["interface_jacobian", "implicit_hermite"])
@pytest.mark.parametrize("step", TARGETS)
def test_accurate_couplings_meet_the_targets_on_every_mode_below_15_hz(speed, name, step):
    prediction = predict(coupling(name), network(speed), step)
    exact = exact_eigenvalues(speed)
    coupled = np.array([prediction.everything[np.abs(prediction.everything - e).argmin()] for e in exact])
    frequency, damping = TARGETS[step]
    assert prediction.stable
    assert np.all(np.abs(coupled.imag / exact.imag - 1) <= frequency)
    assert np.all(np.abs((coupled.real / np.abs(coupled)) / (exact.real / np.abs(exact)) - 1) <= damping)


@pytest.mark.parametrize("speed", [None, 10.0, 30.0, 50.0])
@pytest.mark.parametrize("name", ["jacobi_quadratic", "hermite", "taylor", "interface_jacobian"])
def test_couplings_without_saved_states_meet_their_target_at_a_millisecond(speed, name):
    prediction = predict(coupling(name), network(speed, can_restore=False), 1e-3)
    swings = prediction.oscillatory & (prediction.exact.imag < 2 * np.pi * 15)
    assert prediction.stable
    assert np.all(np.abs(prediction.frequency_error[swings]) <= 1e-4)
    assert np.all(np.abs(prediction.damping_error[swings]) <= 1e-3)


@pytest.mark.slow
@pytest.mark.parametrize("rider", ["mean_2011", "3_2011", "10_2011", "2_2008"])
@pytest.mark.parametrize("can_restore", [True, False])
def test_the_default_meets_the_targets_with_every_rider_and_speed(rider, can_restore):
    for speed in (None, 5.0, 10.0, 20.0, 30.0, 50.0, 60.0):
        subsystems = network(speed, rider, can_restore=can_restore)
        for step, (frequency, damping) in TARGETS.items():
            chosen, found = choose(subsystems, subsystems, step, None, TOLERANCE)
            swings = found.oscillatory & (found.exact.imag < 2 * np.pi * 15)
            assert found.stable, (chosen.name, speed, step)
            assert np.abs(found.frequency_error[swings]).max() <= frequency, (chosen.name, speed, step)
            assert np.abs(found.damping_error[swings]).max() <= damping, (chosen.name, speed, step)


def test_units_that_are_alike_are_predicted_as_one():
    models = {
        "vehicle": LinearSubsystem(spaces(None)["vehicle"]),
        **{f"device_{k}": LinearSubsystem(spaces(None)["device"]) for k in range(3)},
    }
    wiring = join(models)
    whole, one = (
        predict(coupling("hermite"), Network(models, wiring), 4e-3),
        predict(coupling("hermite"), linear_network(models, wiring), 4e-3),
    )
    assert len(one.exact) < len(whole.exact)
    for exact, coupled in zip(one.exact, one.coupled, strict=True):
        k = np.abs(whole.exact - exact).argmin()
        # Equal to rounding, which a discrete eigenvalue shows as 1e-14 / H.
        assert abs(whole.exact[k] - exact) < 1e-9 and abs(whole.coupled[k] - coupled) < 1e-8


def test_an_unstable_vehicle_does_not_hide_an_unstable_coupling():
    # Without a rider capsize grows above 11 m/s. With one at 30 m/s and held torques, at 30 ms what grows is another.
    subsystems = network(30.0)
    exact = np.linalg.eigvals(subsystems.linearised().A)
    found = predict(coupling("jacobi"), subsystems, 0.03)
    assert exact.real.max() > 1e-3 and not found.stable
    assert predict(coupling("jacobi"), subsystems, 1e-3).stable


@pytest.mark.parametrize("scheme", COUPLINGS.values(), ids=COUPLINGS)
def test_eigenvalues_converge_at_the_order_that_the_coupling_promises(scheme):
    coarse, fine = 4e-3, 2e-3
    if scheme.name == "interface_jacobian":  # the others would meet rounding; this one has to be seen at large steps
        coarse, fine = 8e-2, 4e-2
    worst = [
        np.abs(predict(scheme, network(30.0), step).coupled - predict(scheme, network(30.0), step).exact)[:4].max()
        for step in (coarse, fine)
    ]
    assert worst[0] / worst[1] > 2**scheme.order * 0.8  # the next order still shows at these steps


def test_exact_eigenvalues_are_those_of_the_one_coupled_system():
    for speed in (None, 10.0, 30.0, 50.0):
        ours = predict(COUPLINGS["jacobi"], network(speed), 1e-3).exact
        assert all(
            np.abs(ours - e).min() <= 1e-9 * abs(e) for e in exact_eigenvalues(speed)
        )  # rounding of two eigensolutions


# Largest stable steps [s] of the mean rider on the bar, and on Sharp's motorcycle at 30 m/s, found by halving the step;
# inf: above 1 s.
STABLE = {
    "jacobi": (0.0365, 0.0263), "gauss_seidel": (0.00887, np.inf), "jacobi_linear": (0.0207, 0.0156), "jacobi_quadratic": (0.01055, 0.00835),
    "hermite": (0.01695, 0.01219), "taylor": (0.0481, 0.0412), "interface_jacobian": (np.inf, np.inf), "iterated": (0.0256, 0.0246),
    "implicit_hermite": (0.0244, 0.0209),
}  # fmt: skip


@pytest.mark.slow
@pytest.mark.parametrize("name", STABLE)
def test_decay_and_growth_are_separated_at_the_largest_stable_step(name):
    for limit, speed in zip(STABLE[name], (None, 30.0), strict=True):
        steps = (0.02, 0.1, 1.0) if np.isinf(limit) else (0.25 * limit, 0.98 * limit)  # 2 %: three digits are stated
        assert all(predict(coupling(name), network(speed), step).stable for step in steps)
        assert np.isinf(limit) or not predict(coupling(name), network(speed), 1.02 * limit).stable


@pytest.mark.slow
def test_largest_stable_step_separates_decay_from_growth():
    for name in ("jacobi", "gauss_seidel", "jacobi_linear", "hermite", "taylor"):
        limit = largest_stable_step(coupling(name), network())
        assert predict(coupling(name), network(), 0.98 * limit).stable
        assert not predict(coupling(name), network(), 1.02 * limit).stable


@pytest.mark.slow
@given(
    st.sampled_from([HELD, LINEAR, QUADRATIC, END, LINE, PARABOLA, HERMITE, TAYLOR]),
    st.lists(st.floats(-10, 10), min_size=4, max_size=4),
)
def test_a_polynomial_of_fitting_order_is_continued_exactly(knots, coefficients):
    p = np.polynomial.Polynomial(coefficients[: len(knots)])
    data = [p.deriv(d)(place) if d else p(place) for place, d in knots]
    expected = np.append(p.coef, np.zeros(4 - len(knots)))
    assert through(knots) @ data == pytest.approx(expected, abs=1e-11)  # rounding of a 4 by 4 solve


@pytest.mark.slow
@given(st.integers(0, 3), st.lists(st.floats(-10, 10), min_size=4, max_size=4))
def test_the_nearest_polynomial_leaves_what_is_orthogonal(order, coefficients):
    rest = np.polynomial.Polynomial(coefficients) - np.polynomial.Polynomial(nearest(order) @ coefficients)
    for k in range(order + 1):
        whole = (rest * np.polynomial.Polynomial.basis(k)).integ()
        assert whole(1) - whole(0) == pytest.approx(0, abs=1e-11)
    assert np.all(nearest(order)[order + 1 :] == 0)


def test_a_linear_unit_steps_polynomial_inputs_exactly():
    # x' = u, so x is the integral of u: u = 1 + 2 s + 3 s^2 + 4 s^3 over a step of 0.1 gives 0.1 (1 + 1 + 1 + 1).
    subsystem = LinearSubsystem(
        StateSpace(np.zeros((1, 1)), np.ones((1, 1)), np.ones((1, 1)), np.zeros((1, 1)), ("x",), ("u",), ("y",))
    )
    subsystem.step(np.array([[1.0], [2.0], [3.0], [4.0]]), 0.1)
    assert subsystem.state == pytest.approx([0.4], rel=1e-14)


def test_output_derivatives_are_those_of_the_motion():
    # Derivatives of the coupled motion y = C exp(A t) x by the coupled matrix against those the subsystems give one by
    # one.
    coupled = network(30.0)
    space = coupled.linearised()
    state = np.linspace(-1, 1, len(space.states))
    coupled.parts[0][0].state, coupled.parts[1][0].state = state[:8], state[8:]
    outputs = coupled.read(np.zeros(len(coupled.outputs)))
    assert outputs == pytest.approx(space.C @ state, rel=1e-12)
    coupled.settle(outputs)
    found = coupled.slopes(3)
    for k in range(3):
        expected = (space.C @ np.linalg.matrix_power(space.A, k + 1) @ state)[coupled.signal_outputs]
        assert found[k] == pytest.approx(expected, rel=1e-9, abs=1e-9 * np.abs(expected).max())


def test_a_loop_of_feedthrough_is_spelled_port_by_port():
    gain = StateSpace(np.zeros((0, 0)), np.zeros((0, 1)), np.zeros((1, 0)), np.ones((1, 1)), (), ("u",), ("y",))
    subsystems = {"first": LinearSubsystem(gain), "second": LinearSubsystem(gain)}
    with pytest.raises(InputError, match=r"algebraic loop: first\.y <- second\.y <- first\.y"):
        Network(subsystems, {"first.u": ["second.y"], "second.u": ["first.y"]})


def test_wiring_that_names_nothing_is_refused_with_the_choices():
    subsystems = {name: LinearSubsystem(space) for name, space in spaces(30.0).items()}
    with pytest.raises(InputError, match=r"did you mean 'vehicle.handlebar_torque'"):
        Network(subsystems, {"vehicle.handlebar_torqe": ["device.handlebar_torque"]})
    with pytest.raises(InputError, match=r"unknown output 'device.torque'"):
        Network(subsystems, {"vehicle.handlebar_torque": ["device.torque"]})


def test_an_unknown_coupling_is_answered_with_all_names():
    with pytest.raises(InputError, match=r"unknown coupling 'jakobi', did you mean 'jacobi'\?.*interface_jacobian"):
        coupling("jakobi")


def test_couplings_say_what_units_lack():
    plain = network(30.0, can_restore=False, output_order=0)
    assert "save" in COUPLINGS["iterated"].missing_capability(plain)
    assert "derivatives" in COUPLINGS["taylor"].missing_capability(plain)
    assert COUPLINGS["jacobi"].missing_capability(plain) == ""


def test_the_cheapest_coupling_comes_first():
    assert list(COUPLINGS) == ["jacobi", "gauss_seidel", "jacobi_linear", "jacobi_quadratic", "hermite", "taylor", "interface_jacobian",
                               "iterated", "implicit_hermite"]  # fmt: skip


NEW = """
from fmus.cosimulation.polynomials import HELD
from fmus.cosimulation.scheme import Continuation, Scheme

COUPLING = Scheme("held_twice", "all subsystems at once, inputs held", order=1, source="a test", before=Continuation(HELD))
"""


@pytest.mark.slow
def test_a_coupling_is_one_file(tmp_path):
    """A new file in the folder of the couplings is in the help of the command, in its place by cost."""
    shutil.copytree(ROOT / "fmus", tmp_path / "fmus", ignore=shutil.ignore_patterns("__pycache__"))
    (tmp_path / "fmus" / "cosimulation" / "coupling" / "held_twice.py").write_text(NEW, "utf-8")
    environment = {**os.environ, "PYTHONPATH": os.pathsep.join([str(tmp_path), str(ROOT)])}
    done = subprocess.run(
        [sys.executable, "-m", "motofmi", "cosimulate", "--help"],
        env=environment,
        cwd=tmp_path,
        capture_output=True,
        text=True,
        check=True,
    )
    first = [line.split()[0] for line in done.stdout.partition("Couplings")[2].splitlines()[1:4]]
    assert first == ["held_twice", "jacobi", "gauss_seidel"]
