"""The numbers of docs/hosts.md: the errors of every host that is installed, and where corners end for docs/vehicles.md.

All hosts have to be installed (docs/hosts.md); one that is not is left out, and the page then lacks its numbers.
"""

from collections.abc import Callable, Mapping
from contextlib import suppress
from dataclasses import asdict, is_dataclass
from importlib.util import find_spec
from itertools import product
from typing import Any

import numpy as np

from fmus import linearise
from fmus.support.errors import InputError
from motofmi.scenarios.hosts import exudyn_bicycle, exudyn_corner, exudyn_motorcycle, hosts
from rider_fmu import riders
from vehicle_fmu import motorcycles
from vehicle_fmu.large_motion.equations import LargeMotion
from vehicle_fmu.large_motion.steady_turning import SteadyTurning

ON_THE_BAR = ("fmpy_bar", "plain_c_bar", "runge_kutta_bar", "libcosim_bar", "container_bar", "cofmpy_bar", "mujoco_bar")
SPEEDS = np.linspace(5.0, 80.0, 20)  # m/s, of straight running
CORNERS = ((6.0, 10.0, 20.0, 30.0, 40.0, 50.0, 60.0, 70.0), (0.0, 15.0, 30.0, 45.0), (0.0,))  # m/s, deg, m/s2
ACCELERATED = ((10.0, 30.0, 50.0), (0.0, 15.0, 30.0), (-4.0, 2.0))
ENDS = (5.0, 10.0, 20.0, 30.0, 60.0, 65.0, 70.0)  # m/s


def run(progress: Callable) -> dict:
    """By host the errors of modes as shares, of trajectories as shares of the largest value, lags in steps."""
    parts: dict[str, tuple[str, Callable[[], Any]]] = {
        **{name: (hosts()[name].PACKAGE, hosts()[name].run) for name in ON_THE_BAR},
        "exudyn_bicycle": ("exudyn", bicycle),
        "exudyn_motorcycle": ("exudyn", motorcycle),
        "exudyn_corner": ("exudyn", corner),
        "corners_end": ("numpy", corners_end),
    }
    found = {name: _run(*parts[name]) for name in progress(list(parts), "hosts")}
    return {name: each for name, each in found.items() if each is not None}


def _run(package: str, part: Callable[[], Any]) -> Any:
    """The results of a host; None where its package, or one that it needs, is not installed."""
    try:
        return plain(part()) if find_spec(package) else None
    except ModuleNotFoundError:
        return None


def plain(found: Any) -> Any:
    """The results as JSON: eigenvalues with their errors as shares and in 1/s, everything else as it is."""
    if is_dataclass(found) and not isinstance(found, type):
        return plain(asdict(found))
    if isinstance(found, Mapping) and set(found) == {"exact", "error"}:
        exact, error = complex(found["exact"]), abs(found["error"])
        return {"real": exact.real, "imag": exact.imag, "error": float(error), "share": float(error / abs(exact))}
    if isinstance(found, Mapping):
        inside = {name: plain(value) for name, value in found.items()}
        shares = [each["share"] for each in inside.values() if isinstance(each, dict) and "share" in each]
        return inside | ({"largest_share": max(shares)} if shares else {})
    return float(found)


def bicycle() -> dict:
    """The bicycle at 5 m/s and 1 ms."""
    return exudyn_bicycle.run(speed=5.0, step=1e-3)


def motorcycle() -> dict[str, float]:
    """The largest error of an eigenvalue over speed, and of the motion with the rider's FMU at 30 m/s and 0.5 ms."""
    touring = motorcycles.load("tum_2020")
    shares = []
    for speed in SPEEDS:
        theirs = exudyn_motorcycle.eigenvalues(touring, float(speed))
        ours = np.linalg.eigvals(linearise(touring, speed=float(speed)).A)
        shares += [float(np.abs(theirs - z).min() / abs(z)) for z in ours]
    found = exudyn_motorcycle.run()
    return {"speeds": len(SPEEDS), "largest_share": max(shares),
            "roll_with_rider": found["roll_error_with_rider"], "steer_with_rider": found["steer_error_with_rider"]}  # fmt: skip


def corner() -> dict[str, float]:
    """The largest rate at an equilibrium, and the largest error of an eigenvalue as a share, hands off and with the
    mean rider, at constant speed and accelerated.
    """
    touring, left, errors = motorcycles.load("tum_2020"), [], []
    for points in (CORNERS, ACCELERATED):
        found = [exudyn_corner.compared(touring, *point, devices) for point in product(*points)
                 for devices in ((), (riders.load("mean_2011"),))]  # fmt: skip
        left.append(max(rate for rate, _ in found))
        errors.append(max(float(each.max()) for _, each in found))
    return {"largest_rate": max(left), "largest_error": errors[0], "accelerated": errors[1]}


def corners_end() -> dict[str, dict[str, float]]:
    """The largest lean angle [deg] of an equilibrium and of modes, by speed [m/s]."""
    motion = LargeMotion(motorcycles.load("tum_2020"))
    return {f"{speed:g}": {"equilibrium": _last(turning, False), "modes": _last(turning, True)}
            for speed in ENDS for turning in [SteadyTurning(motion, speed)]}  # fmt: skip


def _last(turning: SteadyTurning, with_modes: bool) -> float:
    """The lean angle [deg] at which equilibria end; of modes the last whole one."""
    with suppress(InputError):
        turning.at(np.radians(89.0))
    end = float(np.degrees(max(each.lean for each in turning.known)))
    if not with_modes:
        return end
    for lean in range(1, int(end) + 1):
        try:
            turning.linearised(turning.at(np.radians(lean)))
        except InputError:
            return lean - 1.0
    return end
