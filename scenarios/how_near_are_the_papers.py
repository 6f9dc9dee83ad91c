"""How near does the model come to what was printed? Every number, with its residual, the misses included.

A computed value is `met` where it rounds to what is printed, `within tolerance` where it is as near as the
tolerance that goes with the table, else `missed`. No parameter is tuned. The tolerances:

  Sharp 1971, eigenvalues     one unit of the last printed digit
  2011, modes                 1 % of a wobble's or rider-wobble's frequency, 3.5 % of a weave's, 1 m/s at the ends of
                              the rider's weave band, 4 m/s for the speed at which the reference's wobble turns unstable
  2011, riders                what the rounding of the printed inputs can change, plus half a unit of the last digit
  2008, riders                one unit of the last printed digit

The dampings of the riders of 2008 are not printed but worked out from their zeta1 and zeta2: those rows carry a note,
because only nu1 and nu2 are evidence there. Sharp's steering damper is 6.78 N.m.s/rad, the 2011 paper prints 6.7 for
it: its modes are compared with both.
"""

from collections import Counter
from itertools import product
from math import inf, nan
from typing import Any

import numpy as np
from rich.console import Console
from rich.table import Table
from scipy.optimize import brentq

from fmus import Component, System, linearise
from fmus.support.published import last_digit, table
from motofmi.reports.report import Section
from motofmi.reports.report import Table as ReportTable
from motofmi.workflows.scenarios import InReport
from rider_fmu import Handlebar, riders
from rider_fmu.components.passive_rider import locked_steer_mode
from vehicle_fmu import LinearDamper, Modes, modes, motorcycles, over_speed, ridden
from vehicle_fmu.published import MODES_2011, SHARP_1971_EIGENVALUES

REPORT = InReport("tour", 60, "printed against computed")

FOOT = 0.3048  # m
SPEEDS = np.linspace(1, 60, 591)  # m/s
TOLERANCES = ("Tolerances: one unit of the last printed digit for Sharp's eigenvalues and the riders of 2008; what the "
              "rounding of the printed inputs allows for the riders of 2011; for the modes of 2011 1 % of a wobble's "
              "or rider-wobble's frequency, 3.5 % of a weave's, 1 m/s at the ends of the weave band, 4 m/s for the "
              "reference's wobble.")  # fmt: skip
MODE_TOLERANCE = {
    ("wobble", "frequency"): 0.01,
    ("rider_wobble", "frequency"): 0.01,
    ("weave", "frequency"): 0.035,
}  # of the value
SPEED_TOLERANCE = {("rider", "weave"): 1.0, ("reference", "wobble"): 4.0}  # m/s, at the ends of unstable bands
# One unit of the last digit in the tables of riders.
DIGITS_2011 = {"torso_inertia": 1e-4, "arm_stiffness": 0.1, "waist_stiffness": 0.1, "arm_damping": 0.01,
               "waist_damping": 0.01, "nu_t": 0.01, "zeta_t": 0.001}  # fmt: skip
DIGITS_2008 = {"nu1": 0.01, "nu2": 0.1, "zeta1": 0.01, "zeta2": 0.01}


def run() -> dict[str, Any]:
    """`rows`: one per printed number; `counts`: how many are met, within tolerance and missed."""
    rows = sharp_1971() + modes_2011("sharp_1971") + modes_2011("reference_2011") + riders_2011() + riders_2008()
    return {"rows": rows, "counts": dict(Counter(row["met"] for row in rows))}


def compared(computed: float, lo: float, hi: float, tolerance: float, note: str = "", **about: Any) -> dict[str, Any]:
    """One row of the table. residual is what the computed value lies off the middle of [lo, hi],
    or off its one bound."""
    middle = (lo + hi) / 2 if np.isfinite([lo, hi]).all() else (hi if np.isinf(lo) else lo)
    # Printed bounds are decimal numbers: what lies on one to rounding is not a miss.
    slack = 1e-9 * max(1.0, abs(middle))
    met = (
        "met"
        if lo - slack <= computed <= hi + slack
        else "within tolerance"
        if abs(computed - middle) <= tolerance + slack
        else "missed"
    )
    return {
        **about,
        "lo": lo,
        "hi": hi,
        "computed": computed,
        "residual": computed - middle,
        "tolerance": tolerance,
        "met": met,
        "note": note,
    }


def sharp_1971() -> list[dict[str, Any]]:
    """The eigenvalues that Sharp printed, by mode."""
    rows = []
    printed = table(SHARP_1971_EIGENVALUES)
    speeds = np.array([float(row["speed_ft_per_s"]) for row in printed]) * FOOT
    found = modes(over_speed(ridden(motorcycles.load("sharp_1971"))), speeds)
    for k, row in enumerate(printed):
        for column, text in row.items():
            if column == "speed_ft_per_s":
                continue
            mode, _, part = column.partition("_")
            value = found[mode].eigenvalue[k]
            unit = last_digit(text)
            rows.append(compared(value.imag if part == "imag" else value.real, float(text) - unit / 2,
                                 float(text) + unit / 2, unit, source="Sharp 1971", vehicle="sharp_1971",
                                 model="reference", mode=mode, feature=f"{part or 'real'} part", speed=speeds[k],
                                 unit="1/s", printed=text))  # fmt: skip
    return rows


def modes_2011(vehicle: str) -> list[dict[str, Any]]:
    """The features of the modes that the 2011 paper prints, for one of the two values of the steering damper."""
    motorcycle = motorcycles.load(vehicle)
    devices = {"reference": None, "rider": riders.load("mean_2011"), "damper": LinearDamper(damping=7.5)}
    models = {name: modes(over_speed(ridden(motorcycle, device)), SPEEDS) for name, device in devices.items()}
    rows = []
    for row in table(MODES_2011):
        model, mode, feature = row["model"], row["mode"], row["feature"]
        speed = float(row["speed_m_per_s"] or nan)
        computed, unit = computed_feature(models, model, mode, feature, speed)
        if feature in BOUNDS:
            lo, hi = BOUNDS[feature]
        else:
            lo, hi = float(row["lo"]), float(row["hi"])
        tolerance = 0.0
        if unit == "Hz":
            tolerance = MODE_TOLERANCE[mode, feature] * (lo + hi) / 2
        elif feature in ("unstable_from", "restabilised_from"):
            tolerance = SPEED_TOLERANCE.get((model, mode), 0.0)
        rows.append(compared(computed, lo, hi, tolerance, source="Cossalter et al. 2011", vehicle=vehicle, model=model,
                             mode=mode, feature=feature, speed=speed, unit=unit, printed=row["printed"]))  # fmt: skip
    return rows


# Features that are printed as a sentence: the bounds of the number that decides them.
BOUNDS = {
    "stable_everywhere": (-inf, 0.0),
    "unstable_everywhere": (0.0, inf),
    "more_stable_than_reference": (-inf, 0.0),
    "more_stable_than_rider": (-inf, 0.0),
}


def computed_feature(models: dict[str, Modes], model: str, mode: str, feature: str, speed: float) -> tuple[float, str]:
    """The number that decides a feature, and its unit; real parts [1/s] for what is printed as a sentence."""
    found = models[model]
    growth, bands = found[mode].eigenvalue.real, found.unstable[mode]
    at = int(np.argmin(np.abs(SPEEDS - speed))) if np.isfinite(speed) else 0
    match feature:
        case "frequency":
            return float(found[mode].frequency[at]), "Hz"
        case "damping_ratio":  # printed for the whole range: the value farthest from it
            ratio = found[mode].damping_ratio
            return float(ratio[np.nanargmax(np.abs(ratio - 0.5))]), "1"
        case "unstable_from":
            return (bands[0][0] if bands else nan), "m/s"
        case "stable_from" | "restabilised_from":
            return (bands[0][1] if bands else nan), "m/s"
        case "oscillatory_from":
            real = np.flatnonzero(found[mode].frequency == 0)
            return float(SPEEDS[real[-1] + 1]), "m/s"
        case "most_stable_at":
            return float(SPEEDS[np.argmin(growth)]), "m/s"
        case "stable_everywhere":
            return float(growth.max()), "1/s"
        case "unstable_everywhere":
            return float(growth.min()), "1/s"
        case "more_stable_than_reference":
            return float((growth - models["reference"][mode].eigenvalue.real).max()), "1/s"
        case "more_stable_than_rider":
            return float(growth[at] - models["rider"][mode].eigenvalue.real[at]), "1/s"
    raise AssertionError(f"no way to compute {feature}")


def passive_riders(year: str) -> list[str]:
    """The names of the passive riders that were published in a year."""
    return [n for n in riders.names() if n.endswith(year) and riders.contents(n)["component"] == "PassiveRider"]


def riders_2011() -> list[dict[str, Any]]:
    """nu_t and zeta_t of the eleven riders. The tolerance is what half units of the printed inputs can change."""
    rows = []
    for name in passive_riders("2011"):
        rider, printed = riders.load(name), riders.contents(name)["printed"]
        inputs = {k: rider.values[k] for k in DIGITS_2011 if k in rider.values}
        # Both are monotonic in every input, so the corners of the box of half units bound them.
        corners = np.array([locked_steer_mode(rider.with_values(**{k: x + sign * DIGITS_2011[k] / 2
                                                                   for (k, x), sign in zip(inputs.items(), signs,
                                                                                           strict=True)}))
                            for signs in product((-1, 1), repeat=len(inputs))])  # fmt: skip
        for i, (feature, computed) in enumerate(zip(("nu_t", "zeta_t"), locked_steer_mode(rider), strict=True)):
            value, half = printed[feature]["value"], DIGITS_2011[feature] / 2
            tolerance = half + np.abs(corners[:, i] - computed).max()
            rows.append(compared(computed, value - half, value + half, float(tolerance), source="Cossalter et al. 2011",
                                 vehicle="", model=f"rider {name}", mode="torso", feature=feature, speed=nan,
                                 unit=printed[feature]["unit"], printed=f"{value:g}"))  # fmt: skip
    return rows


def riders_2008() -> list[dict[str, Any]]:
    """nu1, nu2, zeta1, zeta2 of the five riders on the rig. An overdamped pair is printed as a zeta2 above 1."""
    rows = []
    for name in passive_riders("2008"):
        rider, printed = riders.load(name), riders.contents(name)["printed"]
        steer_inertia = printed["steer_inertia"]["value"]
        computed = rig_modes(rider, steer_inertia)
        for feature in (f for f in DIGITS_2008 if f in printed):
            value, digit = printed[feature]["value"], DIGITS_2008[feature]
            lo, hi = (1.0, inf) if value == "overdamped" else (value - digit / 2, value + digit / 2)
            note = "the dampings follow from it" if feature.startswith("zeta") else ""
            if feature == "zeta1" and "arm_damping" in rider.assumed:
                bound, least, most = range_of_zeta1(rider, steer_inertia)
                note += f"; {least:.3f} to {most:.3f} for every arm damping from {bound:.1f} N.m.s/rad up"
            rows.append(compared(computed[feature], lo, hi, digit if np.isfinite(hi) else 0.0,
                                 source="Cossalter et al. 2008", vehicle="", model=f"rider {name}", mode="rig",
                                 feature=feature, speed=nan, unit=printed[feature]["unit"],
                                 printed=value if isinstance(value, str) else f"{value:g}", note=note))  # fmt: skip
    return rows


def range_of_zeta1(rider: Component, steer_inertia: float) -> tuple[float, float, float]:
    """The least arm damping that overdamps a rider's second pair, and the range of zeta1 from there on."""

    def ratio(arm_damping: float, which: str) -> float:
        return rig_modes(rider.with_values(arm_damping=arm_damping), steer_inertia)[which]

    bound = float(brentq(lambda c: ratio(c, "zeta2") - 1, 1.0, rider.values["arm_damping"]))
    ratios = [ratio(c, "zeta1") for c in np.geomspace(bound, rider.table["arm_damping"].max, 60)]
    return bound, min(ratios), max(ratios)


def rig_modes(rider: Component, steer_inertia: float) -> dict[str, float]:
    """nu1, nu2 [Hz] (undamped) and zeta1, zeta2 [1] of a rider at the rig's bar; zeta2 > 1 for two real roots."""

    def eigenvalues(who: Component) -> np.ndarray:
        rig = System("rig", {"bar": Handlebar(steer_inertia=steer_inertia), "rider": who})
        return np.linalg.eigvals(linearise(rig).A)

    undamped = np.sort(np.abs(eigenvalues(rider.with_values(arm_damping=0, waist_damping=0))))[::2]
    damped = eigenvalues(rider)
    damped = damped[np.lexsort((np.abs(damped), damped.imag == 0))].reshape(
        2, 2
    )  # the slow pair first, real roots last
    zeta = -damped.sum(axis=1).real / (2 * np.sqrt(damped.prod(axis=1).real))
    return {"nu1": undamped[0] / (2 * np.pi), "nu2": undamped[1] / (2 * np.pi), "zeta1": zeta[0], "zeta2": zeta[1]}


def section(found: dict[str, Any]) -> Section:
    """Every row, what is missed marked."""
    rows = found["rows"]
    cells = [[row["source"].replace("Cossalter et al.", "Cossalter"),
              ", ".join(filter(None, (row["model"], row["vehicle"]))),
              f"{row['mode'].replace('_', '-')}: "
              f"{row['feature'].replace('_', ' ')}", "" if np.isnan(row["speed"]) else f"{row['speed']:.4g}",
              row["printed"], *(f"{row[key]:.4g}" for key in ("computed", "residual", "tolerance")), row["unit"],
              ", ".join(filter(None, (row["met"], row["note"])))]
             for row in rows]  # fmt: skip
    marks = [{"met": "met", "within tolerance": "near", "missed": "missed"}[row["met"]] for row in rows]
    counts = ", ".join(f"{count} {word}" for word, count in found["counts"].items())
    text = f"Of {len(rows)} printed numbers: {counts}. No parameter was tuned; what is missed is shown as missed."
    headings = (
        "source",
        "model",
        "number",
        "at [m/s]",
        "printed",
        "computed",
        "residual",
        "tolerance",
        "unit",
        "verdict",
    )
    return Section(
        "How near are the papers?",
        [text, TOLERANCES],
        (),
        [ReportTable(headings, cells, "Printed against computed", marks)],
    )


def show(rows: list[dict[str, Any]], console: Console) -> None:
    """The table on a console, misses in red."""
    view = Table(title="printed against computed", box=None)
    for heading in (
        "source",
        "vehicle",
        "model",
        "mode",
        "feature",
        "at [m/s]",
        "printed",
        "computed",
        "residual",
        "tolerance",
        "unit",
        "",
        "note",
    ):
        view.add_column(
            heading, justify="right" if heading in ("at [m/s]", "computed", "residual", "tolerance") else "left"
        )
    styles = {"met": "", "within tolerance": "yellow", "missed": "red"}
    for row in rows:
        speed = "" if np.isnan(row["speed"]) else f"{row['speed']:.4g}"
        numbers = [f"{row[key]:.4g}" for key in ("computed", "residual", "tolerance")]
        words = [
            row[key].replace("_", " ") if key != "vehicle" else row[key]
            for key in ("source", "vehicle", "model", "mode", "feature")
        ]
        view.add_row(
            *words, speed, row["printed"], *numbers, row["unit"], row["met"], row["note"], style=styles[row["met"]]
        )
    console.print(view)
