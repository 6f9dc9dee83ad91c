"""The equations of components in CasADi against the project's own expressions: derivation, evaluation, generated C.

    python -m benchmarks casadi_equations

Both get the same `equations`: CasADi's SX symbols take the place of numbers. Seconds are processor time, the best of
some rounds.
"""

import subprocess
import tempfile
import time
from collections.abc import Callable
from importlib import import_module
from importlib.util import find_spec
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np

from fmus.declaration.component import Component
from fmus.equations.sympy_form import derive
from fmus.export.c_code import model_code
from fmus.export.interface import Interface
from motofmi.gap.models.equations import Equations
from rider_fmu import riders
from vehicle_fmu import motorcycles

SAMPLES = 20_000
SAME = ("sin", "cos", "tan", "asin", "acos", "atan", "atan2", "sinh", "cosh", "tanh", "exp", "log", "sqrt")
PARAMETERS = 8  # whose slopes are evaluated
CALLS = 200_000  # of compiled functions
DRIVER = """#include <stdio.h>
#include <stdlib.h>
#include <time.h>
#include "generated.c"
int main(void) {{
    static double z[{size}], f[{size}], w[{size}]; double sum = 0; clock_t begun;
    for (int i = 0; i < {size}; i++) z[i] = 0.5 + 0.001 * i;
    begun = clock();
    for (int k = 0; k < {calls}; k++) {{ z[0] += 1e-9; __asm__ volatile("" ::: "memory"); {call} sum += f[0]; }}
    printf("%.9g %g\\n", (double)(clock() - begun) / CLOCKS_PER_SEC, sum);
    return 0;
}}
"""


def run(progress: Callable, rounds: int = 3) -> dict[str, Any]:
    """Measurements by component; the reason where there are none."""
    if not find_spec("casadi"):
        return {"skipped": "CasADi is not installed; it is no dependency of the project: pip install casadi"}
    components = {"passive rider": riders.load("mean_2011"), "Sharp's motorcycle": motorcycles.load("sharp_1971"),
                  "full rider": riders.load("full_mean_2011")}  # fmt: skip
    return {name: compared(component, rounds) for name, component in progress(list(components.items()), "components")}


def compared(component: Component, rounds: int) -> dict[str, Any]:
    """One component in both."""
    names = [*component.states, *list(component.values)[:PARAMETERS]]
    rng = np.random.default_rng(0)
    start = component.start_values()
    moving = (*component.states, *component.inputs)
    values = {n: x + 0.05 * rng.standard_normal(SAMPLES) if n in moving else x for n, x in start.items()}

    derivation = {"SymPy (modes, C code)": best(lambda: derive(component).jacobian, 1)}
    derivation["expression graph (gap)"] = best(lambda: fresh(component), rounds)
    derivation["CasADi"] = best(lambda: functions(component, names), rounds)

    equations = fresh(component)
    rates, slopes = functions(component, names)
    arguments = np.array([np.broadcast_to(values[n], SAMPLES) for n in variables(component)])
    mapped = [f.map(SAMPLES) for f in (rates, slopes)]

    def own() -> tuple:
        found, by_state = equations(values)
        return found, by_state, equations.slopes(values)

    matrix = import_module("casadi").DM(arguments)

    def casadi() -> list[Any]:
        return [f(matrix) for f in mapped]

    _, by_state, by_parameter = own()
    ours = np.zeros((len(equations.rows), len(names), SAMPLES))
    for block, first in ((by_state, 0), (by_parameter, len(component.states))):
        for (i, j), entry in block.items():
            ours[i, first + j] = entry
    theirs = np.array(casadi()[1]).reshape(len(equations.rows), SAMPLES, len(names)).transpose(0, 2, 1)
    difference = float(np.max(np.abs(ours - theirs)) / np.max(np.abs(theirs)))
    return {"derivation_s": derivation, "evaluation_s": {"own": best(own, rounds), "CasADi map": best(casadi, rounds)},
            "largest_difference_of_slopes": difference, "c": generated(component)}  # fmt: skip


def fresh(component: Component) -> Equations:
    """Equations with slopes by the states and some parameters, derived anew."""
    import_module("fmus.equations.numpy_program").recorded_equations.kept.clear()
    return Equations(component, component.outputs, list(component.values)[:PARAMETERS])


def variables(component: Component) -> list[str]:
    """The names of all that the equations depend on."""
    return ["time", *component.rows("parameter", "input", "state")]


def words(ca: Any) -> SimpleNamespace:
    """The functions of equations on CasADi's symbols."""

    def total(items: Any, function: Callable) -> dict:
        summands = [function(item) for item in items]
        return {key: sum(s[key] for s in summands) for key in summands[0]}

    return SimpleNamespace(
        pi=np.pi, where=ca.if_else, sign=ca.sign, absolute=ca.fabs, maximum=ca.fmax, minimum=ca.fmin, total=total,
        term=lambda x, variables=(), slopes=(): x,
        quantised=lambda x, step: ca.if_else(step > 0, step * ca.floor(x / step + 0.5), x),  # its derivative is 0, not 1
        **{word: getattr(ca, word) for word in SAME})  # fmt: skip


def balances(component: Component, ca: Any) -> tuple[dict[str, Any], Any, Any, Any]:
    """All variables by name, f and M of M x' = f, and the outputs."""
    symbols = {n: ca.SX.sym(n) for n in variables(component)}
    m = words(ca)
    results = component.complete(component.run(symbols, m))
    mass = ca.SX.eye(len(component.states))
    for (row, column), entry in component.mass_entries(symbols, m).items():
        mass[component.states.index(row), component.states.index(column)] = entry
    right = ca.vertcat(*(results[f"der({n})"] for n in component.states))
    return symbols, right, mass, ca.vertcat(*(results[n] for n in component.outputs))


def functions(component: Component, names: list[str]) -> tuple[Any, Any]:
    """Rates and outputs, and their Jacobian by some variables, as CasADi functions of one vector."""
    ca = import_module("casadi")
    symbols, right, mass, outputs = balances(component, ca)
    every, rows = ca.vertcat(*symbols.values()), ca.vertcat(ca.solve(mass, right), outputs)
    slopes = ca.jacobian(rows, ca.vertcat(*(symbols[n] for n in names)))
    return ca.Function("rates", [every], [rows]), ca.Function("slopes", [every], [ca.densify(slopes)])


def generated(component: Component) -> dict[str, Any]:
    """The generated C: its size, whether it is twice the same, and nanoseconds of f and M together, and of the Jacobian
    of f - M x'."""
    ca = import_module("casadi")
    symbols, right, mass, outputs = balances(component, ca)
    rates = ca.SX.sym("rates", len(component.states))
    every = ca.vertcat(*symbols.values(), rates)
    moving = ca.vertcat(*(symbols[n] for n in (*component.states, *component.inputs)))
    made = [ca.Function("rates", [every], [right, mass]),
            ca.Function("jacobian", [every], [ca.jacobian(ca.vertcat(right - mass @ rates, outputs), moving)])]

    def code() -> str:
        generator = ca.CodeGenerator("generated.c")
        for function in made:
            generator.add(function)
        return generator.dump()

    own = lambda: model_code(Interface(component))  # noqa: E731
    return {"CasADi": timed(code, CASADI_CALLS), "own": timed(own, OWN_CALLS)}


def timed(code: Callable[[], str], calls: dict[str, str]) -> dict[str, Any]:
    """Size and speed of generated code; instead of a time, what the compiler says where it refuses it."""
    text = code()
    found: dict[str, Any] = {"bytes": len(text), "lines": text.count("\n"), "twice_the_same": text == code()}
    runtime = next(Path(import_module("fmus.export").__path__[0]).rglob("model.h")).parent
    with tempfile.TemporaryDirectory() as folder:
        (Path(folder) / "generated.c").write_text(text, "utf-8")
        for what, call in calls.items():
            driver, program = Path(folder) / "driver.c", Path(folder) / what
            driver.write_text(DRIVER.format(size=20_000, calls=CALLS, call=call), "utf-8")
            command = [
                "cc",
                "-O2",
                "-std=c99",
                "-D_GNU_SOURCE",
                "-w",
                f"-I{runtime}",
                "-o",
                str(program),
                str(driver),
                "-lm",
            ]
            compiled = subprocess.run(command, capture_output=True, text=True)
            if compiled.returncode:
                found[what] = compiled.stderr.splitlines()[0]
                continue
            runs = [subprocess.run([program], capture_output=True, text=True, check=True) for _ in range(3)]
            found[f"{what}_ns"] = round(1e9 / CALLS * min(float(run.stdout.split()[0]) for run in runs), 1)
    return found


CASADI_CALLS = {"rates": "{ const double *a[1] = {z}; double *r[2] = {f, f + 100}; rates(a, r, 0, w, 0); }",
                "jacobian": "{ const double *a[1] = {z}; double *r[1] = {f}; jacobian(a, r, 0, w, 0); }"}  # fmt: skip
OWN_CALLS = {"rates": "terms(z); rates(z, f); mass(z, w);", "jacobian": "terms(z); jacobian(z, w, f);"}


def best(action: Callable[[], Any], rounds: int) -> float:
    """Processor seconds."""
    times = []
    for _ in range(rounds):
        begun = time.process_time()
        action()
        times.append(time.process_time() - begun)
    return min(times)
