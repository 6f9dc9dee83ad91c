"""The gap workflow on runs of a motorcycle of which only some states are recorded: prediction from sample to sample."""

import numpy as np
import pytest
import scipy.linalg
import scipy.signal

from fmus.support.errors import InputError
from motofmi.gap.models.kalman import Discrete, LinearisedForce, errors, sampled, sampled_noise, stationary
from motofmi.gap.models.one_step_prediction import PredictorModel
from motofmi.gap.preprocessing.best_prediction import with_best_prediction
from motofmi.gap.preprocessing.predicted_run import PredictedRun
from motofmi.recordings.reading import read_recording
from motofmi.recordings.recording import Recording
from motofmi.workflows.gap.vehicle import vehicle_runs_experiment
from motofmi.workflows.gap.vehicle_predictions import (
    predictable_effects,
    predicted_runs,
    with_disturbances,
)
from tests.simulators.hidden_ride import ride, write_ride
from tests.simulators.hidden_vehicle import SHARP, known_to
from tests.vehicle_fmu.test_motorcycle import KANE_NAMES
from vehicle_fmu import Motorcycle

STEERED = (-10.0, -5.0)  # N.m/rad and N.m.s/rad: a rider who steers into the fall


def motorcycles(seed):
    """What is known of a motorcycle, as a component, the real one, and the generator of what follows."""
    rng = np.random.default_rng(seed)
    known = known_to(rng, SHARP, 2.0)
    base = Motorcycle("known", **{KANE_NAMES[n]: x for n, x in known.items() if n in KANE_NAMES})
    return base, known_to(rng, known), rng


def test_the_gain_is_that_of_another_solver():
    rng = np.random.default_rng(0)
    A, C = rng.standard_normal((5, 5)), rng.standard_normal((2, 5))
    F = sampled(A, np.zeros((5, 0)), C, np.zeros((2, 0)), 0.01).F
    Q, R = sampled_noise(A, np.diag(rng.uniform(1e-4, 1e2, 5)), 0.01), np.diag([1e-6, 1e-2])
    K, S, P = stationary(F, C, Q, R)
    expected = scipy.linalg.solve_discrete_are(F.T, C.T, Q, R)
    # Both end with a relative change of 1e-9 of the covariance, whose entries are eight decades apart.
    assert pytest.approx(expected, rel=1e-5, abs=1e-6 * np.abs(P).max()) == P
    assert pytest.approx(C @ P @ C.T + R, rel=1e-6) == S
    assert pytest.approx(F @ P @ C.T @ np.linalg.inv(S), rel=1e-5, abs=1e-6 * np.abs(K).max()) == K


@pytest.mark.parametrize("held, method", [(False, "foh"), (True, "zoh")])
def test_sampled_matrices_are_scipys(held, method):
    rng = np.random.default_rng(1)
    A, B, C, D = (rng.standard_normal(s) for s in ((4, 4), (4, 2), (3, 4), (3, 2)))
    made = sampled(A, B, C, D, 0.1, held)
    F, G, _, more, _ = scipy.signal.cont2discrete((A, B, C, D), 0.1, method)
    # scipy absorbs the next input into its states: x = z + G_1 u.
    assert made.F == pytest.approx(F, abs=1e-12)
    assert made.G0 + made.F @ made.G1 == pytest.approx(G, abs=1e-12)
    assert C @ made.G1 + D == pytest.approx(more, abs=1e-12)


def test_sampled_noise_is_van_loans():
    rng = np.random.default_rng(2)
    A, W = rng.standard_normal((4, 4)), np.diag([1.0, 0.0, 3.0, 0.0])
    whole = scipy.linalg.expm(np.block([[-A, W], [np.zeros((4, 4)), A.T]]) * 0.01)
    # Simpson's rule over 0.01 s of motion of about 1 rad/s: h^4 / 2880 of its fourth derivative.
    assert sampled_noise(A, W, 0.01) == pytest.approx(whole[4:, 4:].T @ whole[:4, 4:], rel=1e-6, abs=1e-11)


def test_what_is_not_linear_acts_as_in_a_loop_over_the_samples():
    rng = np.random.default_rng(5)
    n, nonlinear = 400, np.tanh
    made = sampled(
        np.array([[0.0, 1.0], [-30.0, -0.5]]),
        np.array([[0.0, 0.0], [1.0, -2.0]]),
        np.array([[1.0, 0.0]]),
        np.zeros((1, 2)),
        0.01,
    )
    made = Discrete(*(m[None] for m in made.parts))
    K, place, share = np.array([[[0.3], [0.5]]]), np.zeros(n, int), np.zeros(n)
    y, u = 0.1 * rng.standard_normal((n, 1)), rng.standard_normal((n + 1, 1))
    motion = np.zeros((n, 2))
    for _ in range(20):
        after = np.concatenate([motion, motion[-1:]])
        slope = np.zeros((n + 1, 1, 2))
        slope[:, 0, 1] = (1 - nonlinear(after[:, 1] / 0.1) ** 2) / 0.1
        value = nonlinear(after[:, 1:] / 0.1) - (slope @ after[..., None])[..., 0]
        left, motion = errors(made, K, place, share, y, u, LinearisedForce(value, slope))
    F, G0, G1, C, _ = (m[0] for m in made.parts)
    x = np.zeros(2)
    for k in range(n - 1):
        assert left[k] == pytest.approx(y[k] - C @ x, abs=1e-9)
        known = F @ x + G0 @ [u[k, 0], nonlinear(x[1] / 0.1)] + G1 @ [u[k + 1, 0], 0.0] + K[0] @ (y[k] - C @ x)
        after = x
        for _ in range(100):  # G1 / 0.1 is 0.1: every round is ten times nearer
            after = known + G1[:, 1] * nonlinear(after[1] / 0.1)
        x = after


@pytest.mark.slow
def test_the_best_prediction_errs_by_the_innovations():
    rng = np.random.default_rng(3)
    n, deviation = 9000, 0.3
    u = rng.standard_normal(n)
    y = scipy.signal.lfilter([0, 0.5], [1, -1.6, 0.8], u) + scipy.signal.lfilter(
        [1, 0.4], [1, -1.6, 0.8], deviation * rng.standard_normal(n)
    )
    recording = Recording(
        "arma", np.arange(n) / 100, {"y": y, "u": u, "speed": np.ones(n)}, {"y": "rad", "u": "N.m", "speed": "m/s"}
    )
    run = with_best_prediction(PredictedRun(recording, ("y",), ("u",), "speed", 1, ((0, n),)), u[:, None], [])
    # 2400 cosines: their mean square has a deviation of 0.03, the deviation half of that; here four of it.
    assert 1 / run.mixing[0, 0] * np.sqrt(np.mean(run.densities[0](run.frequency))) == pytest.approx(
        deviation, rel=0.06
    )


@pytest.mark.slow
def test_a_held_input_has_no_information_on_the_disturbance_of_its_own_sample():
    """Fed back without delay or noise, u_k = -g x_k would determine x_k, and the floor would lie below the error of any
    prediction."""
    rng = np.random.default_rng(4)
    n, noise = 9000, 1.0
    x, disturbance = np.zeros(n), 0.5 * rng.standard_normal(n)
    for k in range(n - 1):
        x[k + 1] = 0.9 * x[k] - 0.2 * x[k] + disturbance[k]
    y, u = x + noise * rng.standard_normal(n), -0.2 * x
    recording = Recording(
        "fed_back", np.arange(n) / 100, {"y": y, "u": u, "speed": np.ones(n)}, {"y": "rad", "u": "N.m", "speed": "m/s"}
    )
    floors = []
    for held in (True, False):
        run = PredictedRun(recording, ("y",), ("u",), "speed", 1, ((0, n),), held=held)
        floors.append(1 / with_best_prediction(run, u[:, None], []).mixing[0, 0])
    # Known before: the sensor's noise and the disturbance; with u_k, the noise alone. 9000 samples: 0.8 % each, here
    # four of it.
    assert floors == pytest.approx([np.hypot(noise, 0.5), noise], rel=0.03)


@pytest.mark.parametrize("swing, several", [(0.0, False), (0.02, True)])
def test_a_speed_that_swings_by_two_percent_is_followed(swing, several):
    t = np.arange(6000) / 100
    columns = {
        "roll_rate": np.sin(t),
        "speed": 20 * (1 + swing * np.sin(0.2 * t)) + 0.02 * np.random.default_rng(0).standard_normal(6000),
    }
    run = PredictedRun(
        Recording("ride", t, columns, {"roll_rate": "rad/s", "speed": "m/s"}),
        ("roll_rate",),
        (),
        "speed",
        1,
        ((0, 6000),),
    )
    speeds, place, share = run.speeds
    assert (len(speeds) > 1) == several
    followed = np.interp(place + share, np.arange(len(speeds)), speeds)
    # Its noise is averaged over a second: 0.002 m/s; the ends of the range, 1 % of the samples each, are cut off.
    assert np.abs(followed - 20 * (1 + swing * np.sin(0.2 * t)))[100:-100].max() < 0.012


@pytest.fixture(scope="module")
def prepared(tmp_path_factory):
    """A run with its disturbances, the stand, and the library."""
    base, real, rng = motorcycles(4)
    file = write_ride(
        tmp_path_factory.mktemp("prepared") / "run.csv", ride(rng, real, 20.0, {}, 30.0, gain=STEERED), rng
    )
    experiment = with_disturbances(vehicle_runs_experiment(base), ("yaw_rate", "roll_rate", "steer_angle"))
    run = predicted_runs([read_recording(file)], experiment)[0]
    return (
        PredictorModel(experiment).with_estimated_disturbances(run, PredictorModel(experiment).start()),
        experiment,
        predictable_effects(base, experiment, [run]),
    )


@pytest.mark.study
def test_slopes_are_those_of_differences(prepared):
    run, experiment, every = prepared
    library = {e.form: e for e in every}
    model = PredictorModel(experiment, [library["coulomb"], library["motor"]])
    q = model.start()
    q[len(model.base) :] = 0.5, 0.02
    z, slopes = model.reduced(run, q)
    for i in (
        1,
        10,
        model.base.index("disturbance.white_roll_torque"),
        model.base.index("disturbance.noise_yaw_rate"),
        len(q) - 2,
        len(q) - 1,
    ):
        step = 1e-4 * np.eye(len(q))[i]
        differences = (model.reduced(run, q + step)[0] - model.reduced(run, q - step)[0]) / 2e-4
        # The slopes are one-sided differences of matrices and of the inputs, each to 1e-5 of its size.
        assert np.linalg.norm(slopes[:, i] - differences) < 0.01 * np.linalg.norm(differences)
    assert z.shape == run.data.shape


@pytest.mark.study
def test_an_effect_of_size_zero_changes_nothing(prepared):
    run, experiment, library = prepared
    bare = PredictorModel(experiment)
    before = bare.reduced(run, bare.start())[0]
    for effect in library:
        model = PredictorModel(experiment, [effect])
        # A compliance, a sensor's delay, and the parameters of an effect with a log-normal prior cannot be zero.
        if effect.prior is not None or any(model.rows[i].min > 0 for i in model.sizes):
            continue
        q = model.start()
        q[[len(model.base) + i for i in model.sizes]] = 0.0
        # Riccati's equation is solved to 1e-9 in either; a spline through the samples is the samples.
        assert model.reduced(run, q)[0] == pytest.approx(before, rel=1e-4, abs=1e-4), effect.__name__


def test_a_run_that_is_too_short_for_its_noise_is_refused():
    time = np.arange(100) / 5
    *y, u = np.random.default_rng(1).standard_normal((5, len(time)))
    outputs = tuple("abcd")
    columns = dict(zip(outputs, y, strict=True)) | {"u": u, "speed": np.ones(len(time))}
    units = dict.fromkeys(outputs, "rad") | {"u": "N.m", "speed": "m/s"}
    run = PredictedRun(Recording("short", time, columns, units), outputs, ("u",), "speed", 1, ((0, len(time)),))
    with pytest.raises(InputError, match=r"short: \d+ samples are too few for the noise of its predictions"):
        with_best_prediction(run, u[:, None], [])
