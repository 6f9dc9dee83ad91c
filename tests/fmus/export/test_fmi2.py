"""What FMI 2.0 makes optional, held against solutions nobody here wrote."""

import json
import subprocess
import sys

import numpy as np
import pytest
from fmpy.fmi1 import FMICallException
from scipy.integrate import solve_ivp

from fmus import linearise
from fmus.export.build import build
from rider_fmu import riders
from tests import ROOT
from tests.importer import COMPONENTS, drive_of

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
