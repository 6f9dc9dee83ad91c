"""The model of the steer test that is fitted, and the rider component and value file from the fitted values."""

from pathlib import Path

import numpy as np

from fmus import Component, System
from fmus.composition.value_files import value_file
from fmus.support.files import write_text
from motofmi.frequency_response.response import Response
from motofmi.identification.parameter_fit import Identification
from motofmi.identification.population import population
from rider_fmu import Handlebar, PassiveRider, riders
from rider_fmu.rigs.handlebar import HANDLEBAR_INERTIA
from rider_fmu.two_degree_of_freedom import DERIVED_UNITS, derived

PARAMETERS = ("steer_inertia", "torso_inertia", "arm_stiffness", "waist_stiffness", "arm_damping", "waist_damping")
VALUES = ("added_steer_inertia", *PARAMETERS[1:])  # the same in a rider's file


def rig_response(rider: Component | None = None, steer_inertia: float = HANDLEBAR_INERTIA) -> Response:
    """The inertance of bar and rider (2011, eq. 6) over PARAMETERS; the fit starts at the rider's values, the mean
    rider's by default."""
    rider = rider or riders.load("mean_2011")
    system = System("rig", {"bar": Handlebar("bar", steer_inertia=steer_inertia), "rider": rider})
    return Response(system, "bar.servo_torque", "bar.steer_acceleration", [qualified(name) for name in PARAMETERS])


def qualified(name: str) -> str:
    """The parameter's name in the system of bar and rider."""
    return f"{'bar' if name == 'steer_inertia' else 'rider'}.{name}"


def rider_from(
    values: np.ndarray, handlebar_inertia: float = HANDLEBAR_INERTIA, name: str = "measured", source: str = ""
) -> PassiveRider:
    """The rider with identified values of PARAMETERS (6,); the rider's inertia is steer_inertia without that of the
    bar."""
    given = dict(zip(PARAMETERS, map(float, values), strict=True))
    given["added_steer_inertia"] = given.pop("steer_inertia") - handlebar_inertia
    return PassiveRider(name, source, (), **given)


def derived_with_errors(found: Identification, handlebar_inertia: float) -> dict[str, dict]:
    """Quantities derived from the parameters, name -> {value, standard_error, unit}; errors to first order."""

    def at(x: np.ndarray) -> dict[str, float | None]:
        values = np.clip(np.exp(x), low, high)  # a parameter on its bound keeps the value of the bound
        return derived(rider_from(values, handlebar_inertia), float(values[0]), handlebar_inertia)

    rows = rig_response().rows
    low, high = (np.array([getattr(row, side) for row in rows]) for side in ("min", "max"))
    x = np.log(found.values)
    here, step = at(x), 1e-5
    sides = [(at(x + step * e), at(x - step * e)) for e in np.eye(len(x))]
    result = {}
    for name, unit in DERIVED_UNITS.items():
        error = None
        if here[name] is not None and all(up[name] is not None and down[name] is not None for up, down in sides):
            slope = np.array([(up[name] - down[name]) / (2 * step) for up, down in sides])  # type: ignore[operator]
            error = float(np.sqrt(slope @ found.covariance @ slope))
        result[name] = {"value": here[name], "standard_error": error, "unit": unit}
    return result


def rider_toml(found: Identification, handlebar_inertia: float, description: str, source: str) -> str:
    """A rider's value file with standard errors and correlations, as `riders.load` and every command take it."""
    lines = [_values_text(found.values, handlebar_inertia, description, source, found.standard_error).rstrip()]
    for i, name in enumerate(VALUES[1:], 1):
        lines += [
            "",
            f"[correlation.{name}]",
            *(f"{other} = {float(found.correlation[i, j]):.4f}" for j, other in enumerate(VALUES[:i])),
        ]
    lines += ["", "[about]", f'handlebar_inertia = {{ value = {handlebar_inertia!r}, unit = "kg.m2" '
                             f'}}', f'method = "{found.method}"',
              f'radius_residual = {{ value = {found.residual["radius"]!r}, unit = "rad/s2/(N.m)" }}',
              f'phase_residual = {{ value = {found.residual["phase_deg"]!r}, unit = "deg" }}']  # fmt: skip
    return "\n".join(lines) + "\n"


def _values_text(values: np.ndarray, handlebar_inertia: float, description: str, source: str,
                 errors: np.ndarray | None = None) -> str:  # fmt: skip
    rider = rider_from(values, handlebar_inertia)
    known = [None] * len(VALUES) if errors is None else errors
    parameters = {n: (rider.values[n], error, rider.table[n].unit) for n, error in zip(VALUES, known, strict=True)}
    return value_file("PassiveRider", parameters, description, source)


def table_spread(count: int, seed: int = 0) -> np.ndarray:
    """Riders (count, 6) drawn from the population of the ten riders of 2011, log-normal, over PARAMETERS."""
    ten = [riders.load(f"{number}_2011") for number in range(1, 11)]
    return population(ten, VALUES, {"added_steer_inertia": HANDLEBAR_INERTIA}).draws(count, seed)


def write_population(draws: np.ndarray, handlebar_inertia: float, folder: Path, source: str) -> list[Path]:
    """One value file for each row of draws (n, 6): rider_001.toml and on. The paths."""
    paths = [folder / f"rider_{number:03d}.toml" for number in range(1, len(draws) + 1)]
    for path, row in zip(paths, draws, strict=True):
        write_text(path, _values_text(row, handlebar_inertia, "Drawn, not measured", source))
    return paths
