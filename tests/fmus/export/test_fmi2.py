"""What FMI 2.0 makes optional, and how the FMU reacts to misuse. Exactness against solutions nobody here wrote."""

import json
import subprocess
import sys
from concurrent.futures import ThreadPoolExecutor

import fmpy
import numpy as np
import pytest
from fmpy.fmi1 import FMICallException
from scipy.integrate import solve_ivp

from fmus import linearise
from fmus.export.build import build
from rider_fmu import riders
from tests import ROOT
from tests.importer import COMPONENTS, Opened, drive_of
from vehicle_fmu import motorcycles

RESTORE = """
import json, sys
from tests.importer import Opened
import numpy as np
given = json.load(sys.stdin)
fmu = Opened(given["path"]).start()
state = fmu.fmu.deSerializeFMUstate(bytes(given["bytes"]))
fmu.fmu.setFMUstate(state)
fmu.fmu.doStep(given["time"], 0.01)
print(json.dumps([x.hex() for x in fmu.get(*given["names"])]))
"""


def wandered(fmu, component, end=0.2):
    """After some steps with moving inputs."""
    drive = drive_of(component)
    for i in range(round(end / 0.01)):
        fmu.set(**drive(0.01 * i))
        fmu.fmu.doStep(0.01 * i, 0.01)
    return end


@pytest.mark.slow
@pytest.mark.parametrize("name", ["rider", "motorcycle", "oscillator", "damper"])
def test_a_restored_state_repeats_the_step_to_the_last_bit(name, opened):
    component = COMPONENTS[name]()
    fmu, names = opened(component).start(), component.states + component.outputs
    now = wandered(fmu, component)
    state = fmu.fmu.getFMUstate()
    fmu.fmu.doStep(now, 0.01)
    first = fmu.get(*names)
    fmu.fmu.doStep(now + 0.01, 0.03)
    fmu.fmu.setFMUstate(state)
    fmu.fmu.doStep(now, 0.01)
    assert fmu.get(*names).tobytes() == first.tobytes()
    fmu.fmu.freeFMUstate(state)


@pytest.mark.slow
@pytest.mark.parametrize("name", ["rider", "motorcycle", "oscillator"])
def test_serialised_states_are_the_same_bytes_again_and_work_in_another_process(name, opened, tmp_path):
    component = COMPONENTS[name]()
    fmu, names = opened(component).start(), list(component.states + component.outputs)
    now = wandered(fmu, component)
    state = fmu.fmu.getFMUstate()
    data = fmu.fmu.serializeFMUstate(state)
    again = fmu.fmu.deSerializeFMUstate(data)
    fmu.fmu.setFMUstate(again)
    assert fmu.fmu.serializeFMUstate(fmu.fmu.getFMUstate()) == data == fmu.fmu.serializeFMUstate(again)
    fmu.fmu.doStep(now, 0.01)
    given = {"path": str(build(component, tmp_path).path), "bytes": list(data), "time": now, "names": names}
    done = subprocess.run([sys.executable, "-c", RESTORE], input=json.dumps(given), capture_output=True, text=True, check=True,
                          cwd=ROOT)  # fmt: skip
    assert [float.fromhex(x) for x in json.loads(done.stdout)] == list(fmu.get(*names))


@pytest.mark.slow
def test_bytes_of_another_model_are_refused(opened):
    one, other = opened(riders.load("mean_2011")).start(), opened(riders.load("1_2011")).start()
    data = one.fmu.serializeFMUstate(one.fmu.getFMUstate())
    with pytest.raises(FMICallException):
        other.fmu.deSerializeFMUstate(data)
    assert "no FMU state of this model" in other.log[-1][1]


@pytest.mark.slow
@pytest.mark.parametrize("name", COMPONENTS)
def test_directional_derivatives_are_the_jacobian(name, opened):
    component = COMPONENTS[name]()
    fmu = opened(component, exchange=True).start()
    random = np.random.default_rng(3)
    x, u = random.uniform(0.1, 1, len(component.states)), random.uniform(1, 30, len(component.inputs))
    fmu.set(**dict(zip(component.inputs, u, strict=True)))
    if len(x):
        fmu.set_states(x)
    model = linearise(component, **dict(zip(component.states + component.inputs, [*x, *u], strict=True)))
    expected = np.block([[model.A, model.B], [model.C, model.D]])
    unknowns = fmu.references([f"der({n})" for n in component.states] + list(component.outputs))
    knowns = fmu.references(component.states + component.inputs)
    found = np.array([fmu.fmu.getDirectionalDerivative(unknowns, [known], [1.0]) for known in knowns]).T
    # Two ways to the same number, from the same symbolic expressions: roundings only.
    assert found == pytest.approx(expected, rel=1e-10, abs=1e-11 * np.abs(expected).max())
    seed = random.normal(size=len(knowns))
    found = np.array(fmu.fmu.getDirectionalDerivative(unknowns, knowns, list(seed)))
    assert found == pytest.approx(expected @ seed, rel=1e-10, abs=1e-10 * np.abs(expected).max())


@pytest.mark.slow
@pytest.mark.parametrize("order", [1, 2, 3])
@pytest.mark.parametrize(
    ("name", "ramped_speed"),
    [("rider", False), ("motorcycle", False), ("motorcycle", True), ("inerter", False), ("oscillator", False)],
)
def test_inputs_as_polynomials_in_time(name, order, ramped_speed, opened):
    component = COMPONENTS[name]()
    moving = [n for n in component.inputs if ramped_speed or n != "speed"]
    random = np.random.default_rng(order)
    coefficients = {n: random.normal(size=order + 1) for n in moving}  # derivatives of order 0, 1, ...
    for n in moving:
        coefficients[n][0] += component.table[n].start
    fmu = opened(component).start()
    fmu.set(**{n: c[0] for n, c in coefficients.items()})
    for k in range(1, order + 1):
        fmu.set_slopes(k, **{n: c[k] for n, c in coefficients.items()})
    step = 0.05

    def inputs(t):
        factors = t ** np.arange(order + 1) / np.cumprod([1, *range(1, order + 1)])
        return np.array(
            [coefficients[n] @ factors if n in moving else component.table[n].start for n in component.inputs]
        )

    x0 = np.array([component.table[n].start for n in component.states])
    solved = solve_ivp(
        lambda t, x: component.derivatives(x, inputs(t), t)[0], (0, step), x0, method="DOP853", rtol=1e-12, atol=1e-14
    )
    fmu.fmu.doStep(0.0, step)
    # scipy's own error over the step is some times its tolerance; ours is 1e-10 where the step is not exact.
    scale = np.abs(solved.y).max(axis=1) + 1e-6
    assert np.abs(fmu.get(*component.states) - solved.y[:, -1]) / scale == pytest.approx(0, abs=1e-9)
    assert fmu.get(*component.inputs) == pytest.approx(inputs(step), rel=1e-14)
    # They hold for one step: in the next the inputs stay where they are.
    fmu.fmu.doStep(step, step)
    assert fmu.get(*component.inputs) == pytest.approx(inputs(step), rel=1e-14)


@pytest.mark.slow
@pytest.mark.parametrize("name", ["rider", "motorcycle", "inerter", "system", "oscillator"])
def test_derivatives_of_outputs_are_those_of_their_polynomial(name, opened):
    component = COMPONENTS[name]()
    fmu = opened(component).start()
    now = wandered(fmu, component)
    outputs = fmu.references(component.outputs)
    orders = range(1, 1 + fmu.description.coSimulation.maxOutputDerivativeOrder)
    assert len(orders) == (1 if name == "oscillator" else 3)
    found = {k: np.array(fmu.fmu.getRealOutputDerivatives(outputs, [k] * len(outputs))) for k in orders}
    state = fmu.fmu.getFMUstate()
    h = 3e-4
    samples = [fmu.get(*component.outputs)]
    for i in range(1, 7):  # seven points, held inputs: one-sided differences through a polynomial of degree six
        fmu.fmu.setFMUstate(state)
        fmu.fmu.doStep(now, i * h)
        samples.append(fmu.get(*component.outputs))
    polynomial = np.polynomial.polynomial.polyfit(np.arange(7), np.array(samples), 6)
    for k in orders:
        expected = polynomial[k] * np.prod(range(1, k + 1)) / h**k
        size = np.abs(np.array(samples)).max(axis=0) + 1e-3
        # The polynomial leaves (omega h)^4 < 1e-5 of the fastest mode out; h^k divides the error of the samples,
        # which is a rounding, or for the oscillator its tolerance.
        noise = (2e-12 if name != "oscillator" else 1e-9) / h**k
        assert np.all(np.abs(found[k] - expected) <= 1e-4 * np.abs(expected) + noise * size)


def test_a_message_names_variable_value_and_bounds_and_nothing_changes(opened):
    fmu = opened(riders.load("mean_2011")).start()
    saved = fmu.fmu.getFMUstate()
    before = fmu.fmu.serializeFMUstate(saved)
    cases = [
        ({"steer_rate": 2.0, "arm_damping": -1.0}, "arm_damping = -1 N.m.s/rad is outside its bounds [0, 100000]"),
        ({"steer_angle": float("nan")}, "steer_angle = nan rad is not a finite number"),
        ({"steer_angle": float("inf")}, "steer_angle = inf rad is not a finite number"),
        (
            {"added_steer_inertia": 0.1},
            "added_steer_inertia is a fixed parameter: it can be set only before initialisation is over",
        ),
        ({"torso_angle": 0.1}, "torso_angle is a state: it can be set only before initialisation is over"),
        ({"handlebar_torque": 0.1}, "handlebar_torque is calculated and cannot be set"),
        ({"time": 0.1}, "time is the time, which the steps set"),
    ]
    for values, message in cases:
        with pytest.raises(FMICallException) as raised:
            fmu.set(**values)
        discarded = "bounds" in message or "finite" in message  # FMI 2.0.4, 2.1.3: the computation can continue
        assert fmu.log[-1] == ("logStatusDiscard" if discarded else "logStatusError", message)
        assert raised.value.status == (fmpy.fmi2.fmi2Discard if discarded else fmpy.fmi2.fmi2Error)
        if not discarded:
            fmu.fmu.setFMUstate(saved)
    assert fmu.fmu.serializeFMUstate(fmu.fmu.getFMUstate()) == before
    fmu.set(steer_rate=1.0)
    fmu.fmu.doStep(0.0, 0.01)


@pytest.mark.slow
def test_a_step_that_cannot_be_done_leaves_the_state_and_says_why(opened):
    fmu = opened(COMPONENTS["oscillator"]()).start(position=0.1, hardening=1e6, relative_tolerance=1e-13)
    saved = fmu.fmu.getFMUstate()
    before = fmu.fmu.serializeFMUstate(saved)
    for time, step, message in ((0.0, 0.0, "positive and finite"), (0.0, -1.0, "positive and finite"), (0.0, float("nan"), "positive and finite"),
                                (7.0, 0.01, "the instance is at 0 s"), (0.0, 1e9, "relative tolerance")):  # fmt: skip
        with pytest.raises(FMICallException) as raised:
            fmu.fmu.doStep(time, step)
        assert message in fmu.log[-1][1]
        assert raised.value.status == (fmpy.fmi2.fmi2Discard if "tolerance" in message else fmpy.fmi2.fmi2Error)
        fmu.fmu.setFMUstate(saved)
    assert fmu.fmu.serializeFMUstate(fmu.fmu.getFMUstate()) == before
    assert fmu.fmu.getRealStatus(fmpy.fmi2.fmi2LastSuccessfulTime) == 0.0


def test_a_polynomial_that_leaves_the_bounds_discards_the_step(opened):
    fmu = opened(motorcycles.load("sharp_1971")).start()
    fmu.set_slopes(1, speed=-400.0)
    with pytest.raises(FMICallException):
        fmu.fmu.doStep(0.0, 0.1)
    assert "speed = -10 m/s at the end of the step is outside [0.1, 200]" in fmu.log[-1][1]


@pytest.mark.slow
def test_a_tunable_parameter_takes_effect_at_the_next_step(opened):
    fast, slow = (
        opened(riders.load("mean_2011", arm_damping=40.0)).start(torso_angle=0.1),
        opened(riders.load("mean_2011")).start(torso_angle=0.1),
    )
    slow.fmu.doStep(0.0, 0.01)
    slow.set(arm_damping=40.0)
    fast.fmu.doStep(0.0, 0.01)
    assert slow.get("torso_angle") != fast.get("torso_angle")
    other = opened(riders.load("mean_2011")).start(
        torso_angle=float(slow.get("torso_angle")[0]),
        torso_momentum=float(slow.get("torso_momentum")[0]),
        arm_damping=40.0,
    )
    slow.fmu.doStep(0.01, 0.01)
    other.fmu.doStep(0.0, 0.01)
    assert (
        slow.get("torso_angle", "handlebar_torque").tobytes() == other.get("torso_angle", "handlebar_torque").tobytes()
    )


def test_a_calculated_parameter_follows(opened):
    fmu = opened(riders.load("mean_2011")).start(cross_inertia=0.2, added_steer_inertia=0.3)
    inertia = riders.load("mean_2011").values["torso_inertia"]
    assert fmu.get("port_inertia") == pytest.approx(0.3 - 0.2**2 / inertia, rel=1e-15)


def test_after_an_error_an_instance_refuses_to_go_on_until_it_is_reset_or_restored(opened):
    # FMI 2.0.4, 2.1.3 and the table of 4.2.4: in the state error values can be read, and the simulation cannot go on
    fmu = opened(riders.load("mean_2011")).start(torso_angle=0.1)
    saved = fmu.fmu.getFMUstate()
    with pytest.raises(FMICallException):
        fmu.fmu.doStep(0.0, -1.0)
    for call, name in ((lambda: fmu.fmu.doStep(0.0, 0.01), "fmi2DoStep"), (lambda: fmu.set(steer_rate=1.0), "fmi2SetReal"),
                       (fmu.fmu.terminate, "fmi2Terminate"), (fmu.fmu.getFMUstate, "fmi2GetFMUstate")):  # fmt: skip
        with pytest.raises(FMICallException):
            call()
        assert fmu.log[-1][1] == f"{name} may not be called after an error; reset the instance or restore a state first"
    assert fmu.get("torso_angle") == 0.1
    fmu.fmu.setFMUstate(saved)
    fmu.fmu.doStep(0.0, 0.01)
    with pytest.raises(FMICallException):
        fmu.fmu.doStep(0.0, 0.01)
    fmu.fmu.reset()
    fmu.start()
    fmu.fmu.doStep(0.0, 0.01)


def test_calls_out_of_order_are_refused_until_a_reset(opened):
    fmu = opened(riders.load("mean_2011"))
    for call, message in ((lambda: fmu.fmu.doStep(0.0, 0.01), "fmi2DoStep may not be called before initialisation"),
                          (fmu.fmu.exitInitializationMode, "fmi2ExitInitializationMode may not be called before initialisation"),
                          (fmu.fmu.terminate, "fmi2Terminate may not be called before initialisation")):  # fmt: skip
        with pytest.raises(FMICallException):
            call()
        assert fmu.log[-1][1] == message
        fmu.fmu.reset()
    fmu.start()
    fmu.fmu.doStep(0.0, 0.01)
    fmu.fmu.terminate()
    with pytest.raises(FMICallException):
        fmu.fmu.doStep(0.01, 0.01)
    fmu.fmu.reset()
    fmu.start()
    fmu.fmu.doStep(0.0, 0.01)


def test_log_categories(opened, tmp_path):
    fmu = opened(riders.load("mean_2011")).start()
    with pytest.raises(FMICallException):
        fmu.fmu.setDebugLogging(True, ["logEverything"])
    assert "unknown log category 'logEverything' (valid: logAll, logStatusError" in fmu.log[-1][1]
    fmu.fmu.setDebugLogging(True, ["logStatusError"])
    fmu.fmu.reset()
    count = len(fmu.log)
    with pytest.raises(FMICallException):
        fmu.set(arm_damping=-1.0)
    assert len(fmu.log) == count
    assert {c.name for c in fmu.description.logCategories} >= {"logStatusError", "logStatusDiscard", "logAll"}


def test_a_wrong_guid_gives_no_instance(tmp_path):
    fmu = Opened(build(riders.load("mean_2011"), tmp_path).path)
    fmu.fmu.guid = "{00000000-0000-0000-0000-000000000000}"
    with pytest.raises(Exception, match="Failed to instantiate"):
        fmu.fmu.instantiate(callbacks=fmu.callbacks, loggingOn=True)
    assert "do not belong together" in fmu.log[-1][1]
    fmu.fmu.freeLibrary()


@pytest.mark.slow
def test_instances_share_nothing_not_even_between_threads(tmp_path):
    path = build(COMPONENTS["motorcycle"](), tmp_path).path
    drive, times = drive_of(COMPONENTS["motorcycle"]()), np.linspace(0, 2, 201)

    def one(i):
        fmu = Opened(path).start(roll_angle=0.01 * i)
        rows = fmu.run(times, drive, ("roll_angle", "steer_angle", "frame_rate"))
        fmu.close()
        return rows.tobytes()

    alone = [one(i) for i in range(6)]
    with ThreadPoolExecutor(6) as pool:
        assert list(pool.map(one, range(6))) == alone
    assert len(set(alone)) == 6


@pytest.mark.study
def test_beyond_the_reach_of_the_arms_the_step_says_where(opened):
    """A state that leaves its bounds and equations that have no value name what is to blame, and nothing has
    changed."""
    rider = riders.load("full_mean_2011")
    fmu = opened(rider).start()
    before = fmu.fmu.serializeFMUstate(fmu.fmu.getFMUstate())
    fmu.set(frame_rate=100.0)
    with pytest.raises(FMICallException) as raised:
        fmu.fmu.doStep(0.0, 0.05)
    assert raised.value.status == fmpy.fmi2.fmi2Discard
    assert "torso_angle = -0." in fmu.log[-1][1] and "is outside its bounds [-0.35, 0.35]" in fmu.log[-1][1]
    short = opened(
        rider.with_values(upper_arm_length=0.26, forearm_length=0.26, upper_arm_centre=0.1, forearm_centre=0.1)
    ).start(steer_angle=0.6)
    with pytest.raises(FMICallException):
        short.fmu.doStep(0.0, 0.01)
    assert (
        "der(torso_angle) has no value at time = " in short.log[-1][1]
        and ", steer_angle = 0.6 rad, " in short.log[-1][1]
    )
    fmu.set(frame_rate=0.0)
    assert fmu.fmu.serializeFMUstate(fmu.fmu.getFMUstate()) == before
    fmu.fmu.doStep(0.0, 0.02)
