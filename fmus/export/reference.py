"""Reference results of an FMU, in the folder of the layered standard FMI-LS-REF (1.0.0-alpha.1).

    fmi-ls-manifest.xml    the list of the files
    experiment.json        start values, step, duration, and the tolerance of the results with its reason
    inputs.csv             ramps: every importer that interpolates linearly represents them exactly
    results.csv            outputs over time
    modes.json             damped frequency and damping ratio of each oscillatory mode at the start values

They are computed from the equations in Python, independently of the FMU's code: results by an integrator with error
control (LSODA), modes from the eigenvalues of differences of fourth order,

    f'(x) = (8 (f(x+h) - f(x-h)) - (f(x+2h) - f(x-2h))) / 12 h.

`motofmi check` replays them. The standard: https://github.com/modelica/fmi-ls-ref.
"""

import json
from collections.abc import Mapping
from typing import Any
from xml.etree import ElementTree as Xml

import numpy as np

from fmus.declaration.component import Component
from fmus.declaration.variables import Variable
from fmus.export.interface import Interface
from fmus.export.model_description2 import to_bytes
from fmus.export.reference_folder import FOLDER, MANIFEST
from fmus.support.errors import InputError

SPACE = "http://fmi-standard.org/fmi-ls-manifest"
ATTRIBUTES = {
    "fmi-ls-name": "org.fmi-standard.fmi-ls-ref",
    "fmi-ls-version": "1.0.0-alpha.1",
    "fmi-ls-description": "Layered Standard providing information on related files included in an FMU.",
}
EXPERIMENT, INPUTS, RESULTS, MODES = "experiment.json", "inputs.csv", "results.csv", "modes.json"
RELATED = {  # file: type, role, description
    EXPERIMENT: ("application/json", "experiment/smoke-test", "Start values, step, duration, tolerance of the results"),
    INPUTS: ("text/csv", "experiment/smoke-test", "Inputs over time, linear between the rows"),
    RESULTS: ("text/csv", "result", "Outputs over time, computed independently of the code of this FMU"),
    MODES: ("application/json", "result", "Damped frequency [Hz] and damping ratio [1] of each oscillatory mode"),
}
DURATION, STEP = 0.2, 0.01  # s: one to two periods of the fastest mode of a motorcycle, which wobbles at 5 to 10 Hz
STATE, RAMP = 0.3, 0.5  # share of a state's usual size at the start; of an input's, which it gains over the duration
SOLVER = {"method": "LSODA", "rtol": 1e-9, "atol": 1e-12}
TOLERANCE = 1e-6
REASON = ("share of the largest value of the column; the reference was integrated with a relative tolerance of 1e-9 "
          "per step, and the results have 9 digits")  # fmt: skip
MODE_REASON = ("share of the undamped frequency, and absolute for the damping ratio; the differences are exact to "
               "about 1e-7")  # fmt: skip
DIFFERENCE = 1e-7  # of a state's usual size: small against its nonlinearity, large against rounding
OSCILLATES = 1e-6  # share of its size that the imaginary part of an oscillatory mode exceeds
Xml.register_namespace("fmi-ls", SPACE)


def files(interface: Interface) -> dict[str, bytes]:
    """The files by their path in the archive; none for a component whose equations have no value in the experiment."""
    component = interface.component
    with np.errstate(all="ignore"):
        found = {**_experiment(component), **_modes(component)}
    if not found:
        return {}
    return {MANIFEST: _manifest(found), **{f"{FOLDER}/{name}": data for name, data in found.items()}}


def _experiment(component: Component) -> dict[str, bytes]:
    states, inputs = component.rows("state"), component.rows("input")
    start = {n: _within(r, r.start + (-1) ** k * STATE * r.typical) for k, (n, r) in enumerate(states.items())}
    first = np.array([r.start for r in inputs.values()])
    gain = np.array([_gain(n, r, k) for k, (n, r) in enumerate(inputs.items())])
    times = np.linspace(0.0, DURATION, round(DURATION / STEP) + 1)

    def at(time: float) -> np.ndarray:
        return first + gain * time / DURATION

    try:
        rows = _integrated(component, np.array(list(start.values())), at, times)
    except InputError:  # the experiment leaves the range in which the equations hold
        return {}
    outputs = np.array([component.derivatives(x, at(t), t)[1] for t, x in zip(times, rows, strict=True)])
    if not (np.isfinite(outputs).all() and len(rows) == len(times) and len(component.outputs)):
        return {}
    experiment = {
        "startTime": 0.0, "stopTime": DURATION, "stepSize": STEP, "start": start, "inputs": INPUTS, "results": RESULTS,
        "tolerance": TOLERANCE, "tolerance_reason": REASON,
    }  # fmt: skip
    given = np.array([at(t) for t in times])
    return {
        EXPERIMENT: _json(experiment),
        INPUTS: _csv(component, times, tuple(inputs), given),
        RESULTS: _csv(component, times, component.outputs, outputs),
    }


def _gain(name: str, row: Variable, place: int) -> float:
    """The change of an input over the experiment; a speed is kept, which makes many components linear."""
    if name.rpartition(".")[2] == "speed":
        return 0.0
    wanted = RAMP * row.typical / (1 + place)
    return _within(row, row.start + wanted) - row.start


def _within(row: Variable, value: float) -> float:
    """The value, or half of the way to the bound that it exceeds."""
    low, high = (row.start + (bound - row.start) / 2 for bound in (row.min, row.max))
    return float(np.clip(value, low, high))


def _integrated(component: Component, start: np.ndarray, inputs: Any, times: np.ndarray) -> np.ndarray:
    """States (n, nx) at the times; fewer rows where the integrator does not reach the end."""
    from scipy.integrate import solve_ivp  # noqa: PLC0415 - imported on use: it takes 0.3 s

    if not len(start):
        return np.zeros((len(times), 0))
    found = solve_ivp(lambda t, x: component.derivatives(x, inputs(t), t)[0], (0.0, times[-1]), start, t_eval=times,
                      **SOLVER)  # fmt: skip
    return found.y.T


def _modes(component: Component) -> dict[str, bytes]:
    states, inputs = component.rows("state"), component.rows("input")
    x0, u = (np.array([r.start for r in rows.values()]) for rows in (states, inputs))
    jacobian = np.zeros((len(states), len(states)))
    for k, row in enumerate(states.values()):
        step = np.zeros(len(states))
        step[k] = DIFFERENCE * row.typical
        ends = {s: component.derivatives(x0 + s * step, u)[0] for s in (-2, -1, 1, 2)}
        near, far = ends[1] - ends[-1], ends[2] - ends[-2]
        jacobian[:, k] = (8 * near - far) / (12 * step[k])
    if not np.isfinite(jacobian).all():
        return {}
    values = np.linalg.eigvals(jacobian) if len(states) else np.zeros(0)
    values = values[values.imag > OSCILLATES * np.abs(values)]
    if not len(values):
        return {}
    modes = [{"frequency": _rounded(v.imag / (2 * np.pi)), "damping_ratio": _rounded(-v.real / abs(v))}
             for v in values[np.argsort(np.abs(values))]]  # fmt: skip
    units = {"frequency": "Hz", "damping_ratio": "1"}
    return {MODES: _json({"modes": modes, "units": units, "tolerance": TOLERANCE, "tolerance_reason": MODE_REASON})}


def _manifest(found: Mapping[str, bytes]) -> bytes:
    root = Xml.Element("fmiReferences", {f"{{{SPACE}}}{name}": value for name, value in ATTRIBUTES.items()})
    for name in found:
        type_, role, description = RELATED[name]
        Xml.SubElement(root, "Related", type=type_, source=name, role=role, description=description)
    return to_bytes(root)


def _rounded(value: float) -> float:
    return float(f"{value:.9g}")


def _json(content: Mapping[str, Any]) -> bytes:
    return (json.dumps(content, indent=1) + "\n").encode()


def _csv(component: Component, times: np.ndarray, names: tuple[str, ...], values: np.ndarray) -> bytes:
    """Rows of the values (n, names) at the times, with units in the headings."""
    header = ["time [s]", *(f"{name} [{component.table[name].unit}]" for name in names)]
    rows = np.column_stack([times, values])
    lines = [",".join(header), *(",".join(f"{x:.9g}" for x in row) for row in rows)]
    return ("\n".join(lines) + "\n").encode()
