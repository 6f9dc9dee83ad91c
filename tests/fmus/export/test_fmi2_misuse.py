"""How the FMU reacts to misuse: messages, refused calls and values, and what remains of the state."""

from concurrent.futures import ThreadPoolExecutor

import fmpy
import numpy as np
import pytest
from fmpy.fmi1 import FMICallException

from fmus.export.build import build
from rider_fmu import riders
from tests.importer import COMPONENTS, Opened, drive_of
from vehicle_fmu import motorcycles


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
