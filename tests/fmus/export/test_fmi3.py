"""FMI 3.0: the same numbers as FMI 2.0 to the last bit, and what only FMI 3.0 has."""

import contextlib
import zipfile
from xml.etree import ElementTree as Xml

import fmpy
import numpy as np
import pytest
from fmpy.fmi1 import FMICallException
from fmpy.fmi3 import FMU3Slave
from fmpy.validation import validate_fmu
from lxml import etree

from fmus import linearise
from fmus.export.build import build
from rider_fmu import riders
from tests.importer import COMPONENTS, Opened3, drive_of


@pytest.fixture
def opened3(tmp_path):
    made = []

    def open_fmu(component, exchange=False, **options):
        made.append(Opened3(build(component, tmp_path, fmi=3).path, exchange, **options))
        return made[-1]

    yield open_fmu
    for each in made:
        each.close()


@pytest.mark.slow
@pytest.mark.parametrize("name", COMPONENTS)
def test_trajectories_are_those_of_fmi_2_to_the_last_bit(name, opened, opened3):
    component = COMPONENTS[name]()
    names = component.states + component.outputs + tuple(f"der({n})" for n in component.states)
    times, drive = np.linspace(0, 0.3, 31), drive_of(component)
    assert (
        opened3(component).start().run(times, drive, names).tobytes()
        == opened(component).start().run(times, drive, names).tobytes()
    )


@pytest.mark.slow
@pytest.mark.parametrize("name", ["rider", "motorcycle", "progressive", "system", "oscillator"])
def test_archives_are_valid(name, tmp_path):
    path = build(COMPONENTS[name](), tmp_path, fmi=3).path
    assert path.name.endswith("_fmi3.fmu")
    assert validate_fmu(str(path)) == []


@pytest.mark.slow
@pytest.mark.parametrize(("file", "schema"), [("terminalsAndIcons/terminalsAndIcons.xml", "fmi3TerminalsAndIcons.xsd"),
                                              ("sources/buildDescription.xml", "fmi3BuildDescription.xsd")])  # fmt: skip
def test_the_other_files_follow_the_standard_s_schema(file, schema, tmp_path):
    path = build(COMPONENTS["rider"](), tmp_path, fmi=3).path
    with zipfile.ZipFile(path) as archive:
        document = etree.fromstring(archive.read(file))
    folder = fmpy.__file__.replace("__init__.py", "schema/fmi3/")
    etree.XMLSchema(etree.parse(folder + schema)).assertValid(document)


@pytest.mark.slow
@pytest.mark.parametrize("fmi", [2, 3])
def test_the_port_is_a_terminal(fmi, tmp_path):
    members = {}
    for name in ("rider", "motorcycle"):
        with zipfile.ZipFile(build(COMPONENTS[name](), tmp_path, fmi=fmi).path) as archive:
            root = Xml.fromstring(archive.read("terminalsAndIcons/terminalsAndIcons.xml"))
        (terminal,) = [t for t in root.iter("Terminal") if t.get("name") == "handlebar"]
        assert terminal.get("matchingRule") == "plug"
        members[name] = {m.get("memberName"): m.get("variableKind") for m in terminal}
    # Both sides have the same members, so that they plug into each other; the flow leaves the one and enters the other.
    motion = dict.fromkeys(("steer_angle", "steer_rate", "frame_rate"), "signal")
    for name, kind in (("rider", "outflow"), ("motorcycle", "inflow")):
        assert members[name] == {**motion, "handlebar_torque": kind, "frame_torque": kind}


@pytest.mark.slow
@pytest.mark.parametrize("name", COMPONENTS)
def test_directional_and_adjoint_derivatives(name, opened3):
    component = COMPONENTS[name]()
    fmu = opened3(component, exchange=True).start()
    random = np.random.default_rng(5)
    u = random.uniform(1, 30, len(component.inputs))
    fmu.set(**dict(zip(component.inputs, u, strict=True)))
    model = linearise(component, **dict(zip(component.inputs, u, strict=True)))
    matrix = np.block([[model.A, model.B], [model.C, model.D]])
    unknowns = fmu.references([f"der({n})" for n in component.states] + list(component.outputs))
    knowns = fmu.references(component.states + component.inputs)
    seed, weights = random.normal(size=len(knowns)), random.normal(size=len(unknowns))
    # The same symbolic expressions on two ways: roundings, weighed by the largest entry.
    size = 1e-10 * np.abs(matrix).max()
    assert np.array(fmu.fmu.getDirectionalDerivative(unknowns, knowns, list(seed))) == pytest.approx(
        matrix @ seed, rel=1e-10, abs=size
    )
    assert np.array(
        fmu.fmu.getAdjointDerivative(unknowns, knowns, list(weights), nSensitivity=len(knowns))
    ) == pytest.approx(weights @ matrix, rel=1e-10, abs=size)


@pytest.mark.slow
@pytest.mark.parametrize("name", ["rider", "motorcycle", "oscillator"])
def test_inputs_as_polynomials_by_intermediate_update_are_those_by_input_derivatives(name, tmp_path, opened, opened3):
    component = COMPONENTS[name]()
    random = np.random.default_rng(6)
    moving = {n: random.normal(size=4) * [1, 1, 5, 20] for n in component.inputs if n != "speed"}

    def inputs(t):
        return {n: c[0] + c[1] * t + c[2] * t**2 / 2 + c[3] * t**3 / 6 for n, c in moving.items()}

    step = 0.02
    two, three = opened(component).start(), opened3(component, moves=inputs).start()
    two.set(**inputs(0.0))
    for order in (1, 2, 3):
        two.set_slopes(order, **{n: c[order] for n, c in moving.items()})
    two.fmu.doStep(0.0, step)
    three.set(**inputs(0.0))
    three.fmu.doStep(0.0, step)
    names = component.states + component.inputs + component.outputs
    expected = two.get(*names)
    # Three derivatives from four values lose three digits to the differences.
    assert three.get(*names) == pytest.approx(expected, rel=1e-11, abs=1e-12 * np.abs(expected).max())
    asked = [time for time, set_requested, *_ in three.updates if set_requested]
    assert asked == pytest.approx([0, step / 3, 2 * step / 3, step], rel=1e-14)
    assert three.updates[-1] == (pytest.approx(step), False, True, True, False)


@pytest.mark.slow
def test_an_input_that_is_left_alone_is_held(opened, opened3):
    component = COMPONENTS["motorcycle"]()
    three, two = (
        opened3(component, moves=lambda t: {}).start(roll_angle=0.1, speed=20.0),
        opened(component).start(roll_angle=0.1, speed=20.0),
    )
    for fmu in (two, three):
        fmu.fmu.doStep(0.0, 0.05)
    assert three.get(*component.states).tobytes() == two.get(*component.states).tobytes()


@pytest.mark.slow
def test_early_return(opened3, opened):
    component = COMPONENTS["rider"]()
    fmu = opened3(component, moves=lambda t: {"steer_angle": np.sin(10 * t)}, returns_at=0.0125).start()
    assert fmu.fmu.doStep(0.0, 0.04) == (False, False, True, pytest.approx(0.0125))
    assert fmu.get("time") == pytest.approx(0.0125)
    fmu.returns_at = None
    assert fmu.fmu.doStep(0.0125, 0.01)[2:] == (False, pytest.approx(0.0225))


@pytest.mark.slow
@pytest.mark.parametrize("name", ["rider", "oscillator"])
def test_states_are_restored_to_the_last_bit(name, opened3):
    component = COMPONENTS[name]()
    fmu, names = opened3(component).start(), component.states + component.outputs
    fmu.run(np.linspace(0, 0.2, 21), drive_of(component), names)
    state = fmu.fmu.getFMUState()
    data = fmu.fmu.serializeFMUState(state)
    fmu.fmu.doStep(0.2, 0.01)
    first = fmu.get(*names).tobytes()
    again = fmu.fmu.deserializeFMUState(data)
    fmu.fmu.setFMUState(again)
    assert fmu.fmu.serializeFMUState(again) == data
    fmu.fmu.doStep(0.2, 0.01)
    assert fmu.get(*names).tobytes() == first
    for each in (state, again):
        fmu.fmu.freeFMUState(each)


@pytest.mark.slow
def test_slopes_of_outputs(opened3, opened):
    component = COMPONENTS["motorcycle"]()
    two, three = opened(component).start(roll_angle=0.1), opened3(component).start(roll_angle=0.1)
    references = two.references(component.outputs)
    for order in (1, 2, 3):
        orders = [order] * len(references)
        assert three.fmu.getOutputDerivatives(references, orders) == two.fmu.getRealOutputDerivatives(
            references, orders
        )


def test_after_an_error_an_instance_is_terminated_until_it_is_reset_or_restored(opened3):
    # FMI 3.0, 2.3.1: after fmi3Error in any state the FMU is in Terminated
    fmu = opened3(riders.load("mean_2011")).start(torso_angle=0.1)
    saved = fmu.fmu.getFMUState()
    with pytest.raises(FMICallException):
        fmu.fmu.doStep(0.0, -1.0)
    for call, name in ((lambda: fmu.fmu.doStep(0.0, 0.01), "fmi3DoStep"), (lambda: fmu.set(steer_rate=1.0), "fmi3SetFloat64"),
                       (fmu.fmu.terminate, "fmi3Terminate")):  # fmt: skip
        with pytest.raises(FMICallException):
            call()
        assert f"{name} may not be called after an error; reset" in fmu.log[-1][1]
    assert fmu.get("torso_angle") == 0.1
    fmu.fmu.setFMUState(saved)
    fmu.fmu.doStep(0.0, 0.01)
    with pytest.raises(FMICallException):
        fmu.fmu.doStep(0.0, 0.01)
    fmu.fmu.reset()
    fmu.start()
    fmu.fmu.doStep(0.0, 0.01)


def test_a_value_out_of_bounds_is_discarded(opened3):
    # FMI 3.0, 2.2.3: "handling of min/max violation" is an example of fmi3Discard; the instance is as before
    fmu = opened3(riders.load("mean_2011")).start()
    with pytest.raises(FMICallException) as raised:
        fmu.set(arm_damping=-1.0)
    assert raised.value.status == fmpy.fmi3.fmi3Discard
    fmu.fmu.doStep(0.0, 0.01)


def test_an_error_within_an_intermediate_update_fails_the_step(tmp_path):
    path = build(riders.load("mean_2011"), tmp_path, fmi=3).path
    description = fmpy.read_model_description(path)
    fmu = FMU3Slave(guid=description.guid, unzipDirectory=fmpy.extract(path), instanceName="test",
                    modelIdentifier=description.coSimulation.modelIdentifier)  # fmt: skip
    steer = next(v.valueReference for v in description.modelVariables if v.name == "steer_angle")

    def update(environment, time, set_requested, *_):
        if set_requested:
            with contextlib.suppress(FMICallException):
                fmu.setFloat64([1000], [1.0])

    fmu.instantiate(requiredIntermediateVariables=[steer], intermediateUpdate=update, logMessage=lambda *_: None)
    fmu.enterInitializationMode(startTime=0.0)
    fmu.exitInitializationMode()
    for _ in range(2):
        with pytest.raises(FMICallException):
            fmu.doStep(0.0, 0.01)
    fmu.freeInstance()


def test_misuse_is_refused_with_a_message(opened3):
    fmu = opened3(riders.load("mean_2011"))
    cases = [
        (lambda: fmu.fmu.doStep(0.0, 0.01), "fmi3DoStep may not be called before initialisation"),
        (lambda: fmu.set(arm_damping=-1.0), "arm_damping = -1 N.m.s/rad is outside its bounds [0, 100000]"),
        (lambda: fmu.fmu.getInt32([0]), "fmi3GetInt32: the model has nothing of this kind"),
        (lambda: fmu.fmu.getClock([0]), "fmi3GetClock: the model has nothing of this kind"),
        (fmu.fmu.enterConfigurationMode, "fmi3EnterConfigurationMode: the model has nothing of this kind"),
        (lambda: fmu.fmu.getFloat64([0, 1], 3), "3 values for 2 scalar variables"),
        (lambda: fmu.fmu.getFloat64([1000]), "there is no variable with value reference 1000"),
        (fmu.fmu.enterStepMode, "fmi3EnterStepMode may not be called before initialisation"),
    ]
    for call, message in cases:
        with pytest.raises(FMICallException):
            call()
        assert message in fmu.log[-1][1]
        fmu.fmu.reset()
    fmu.start()
    fmu.fmu.doStep(0.0, 0.01)


def test_event_mode_in_cosimulation_and_a_wrong_token_give_no_instance(tmp_path):
    fmu = Opened3(build(riders.load("mean_2011"), tmp_path, fmi=3).path)
    log = []
    options = {"loggingOn": True, "logMessage": lambda env, status, category, message: log.append(message.decode())}
    with pytest.raises(Exception, match="Failed to instantiate"):
        fmu.fmu.instantiate(eventModeUsed=True, **options)
    assert "event mode" in log[-1]
    fmu.fmu.guid = "something else"
    with pytest.raises(Exception, match="Failed to instantiate"):
        fmu.fmu.instantiate(**options)
    assert "do not belong together" in log[-1]
    fmu.fmu.freeLibrary()


@pytest.mark.slow
def test_model_exchange_in_fmpy(tmp_path):
    path = build(COMPONENTS["motorcycle"](), tmp_path, fmi=3).path
    ends = [fmpy.simulate_fmu(path, fmi_type=kind, start_values={"roll_angle": 0.05, "speed": 25.0}, stop_time=0.3, relative_tolerance=1e-10,
                              output=["roll_angle"])["roll_angle"][-1] for kind in ("ModelExchange", "CoSimulation")]  # fmt: skip
    assert ends[0] == pytest.approx(ends[1], rel=1e-6)  # the importer's integrator is held to 1e-10 per step
