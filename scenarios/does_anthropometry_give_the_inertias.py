"""Does anthropometry give the inertias that were identified? Rider by rider, the ten of 2011.

Height, mass and torso inclination of the paper's Table 1 give the segments (de Leva 1996) and the posture;
the full rider in it, reduced to the two freedoms, gives I_t, I_cc and the share I_s of the rider's inertia at
the steer. The paper's Table 2 has what the FRFs gave. How well the identified stiffnesses spread over the
joints is in the last column.
"""

import numpy as np

from fmus.declaration.units import convert
from motofmi.reports.charts import Axis, Chart, Curve, Panel
from motofmi.reports.report import Section, Table
from motofmi.workflows.scenarios import InReport
from rider_fmu import riders
from rider_fmu.anthropometry import full_rider_values
from rider_fmu.components.full_rider import FullRider
from rider_fmu.full_rider.reduction import joint_values, reduce

REPORT = InReport("full rider", 10, "inertias from anthropometry")

KINDS = {"stiffness": "N.m/rad", "damping": "N.m.s/rad"}
RIDERS = tuple(f"{k}_2011" for k in range(1, 11))


def run() -> list[dict]:
    """One row for every rider: inertias [kg.m2] from anthropometry and as identified; an `error`
    where he cannot reach."""
    rows = []
    for name in RIDERS:
        about, linear = riders.contents(name)["about"], riders.load(name)
        height, mass, lean = (
            convert(about[k]["value"], about[k]["unit"], unit)
            for k, unit in (("height", "m"), ("mass", "kg"), ("torso_inclination", "rad"))
        )
        full = FullRider(f"full_{name}", "", (), **full_rider_values(height, mass, lean))
        r, joints = reduce(full), joint_values(full, linear)
        rows.append({"rider": name, "torso_inertia": r.torso_inertia, "steer_inertia": r.steer_inertia,
                     "cross_inertia": r.cross_inertia, "identified_torso_inertia": linear.values["torso_inertia"],
                     "identified_steer_inertia": linear.values["added_steer_inertia"], "spread": joints})  # fmt: skip
    return rows


def chart(rows: list[dict]) -> Chart:
    """Identified against anthropometric inertia of the torso."""
    own, found = (np.array([r[k] for r in rows]) for k in ("torso_inertia", "identified_torso_inertia"))
    names = [f"rider {row['rider'].split('_')[0]}" for row in rows]
    curves = [
        Curve("equal", [0.2, 0.8], [0.2, 0.8], "measured", "dotted"),
        Curve("riders", own, found, "found", "points", text=names, size=8),
    ]
    return Chart(
        [
            Panel(
                Axis("torso inertia from anthropometry", "kg.m2", low=0.2, high=0.8),
                Axis("torso inertia identified", "kg.m2", low=0.2, high=1.2),
                curves,
                hover="point",
                height=340,
            )
        ]
    )


def section(rows: list[dict]) -> Section:
    """The table, and where the two disagree."""
    ratio = np.array([r["identified_torso_inertia"] / r["torso_inertia"] for r in rows])
    correlation = np.corrcoef([r["torso_inertia"] for r in rows], [r["identified_torso_inertia"] for r in rows])[0, 1]
    shares = np.array([r["steer_inertia"] for r in rows])
    text = [f"Torso: the identified inertia is {ratio.min():.2f} to {ratio.max():.2f} times that of the segments (mean "
            f"{ratio.mean():.2f}); across riders the two correlate by {correlation:+.2f}.",
            f"Steer: hands held fast on the grips, with the arms that follow them, are {shares.min():.2f} to "
            f"{shares.max():.2f} kg.m2. The FRFs gave next to nothing (0 to 0.003 kg.m2, rider 10: 0.143). This is a "
            "disagreement of the model with the measurement, not of two measurements: hands that are fixed to the "
            "grips and limbs that are rigid carry their whole mass to 12 Hz, flesh and a loose grip do not. The bar's "
            "geometry is assumed; no plausible one brings the share near zero, because the hands alone have 0.09 to "
            "0.14 kg.m2."]  # fmt: skip
    headings = [
        "rider",
        "I_t [kg.m2]",
        "identified",
        "I_s without bar [kg.m2]",
        "identified",
        "I_cc [kg.m2]",
        "stiffness not spread",
        "damping not spread",
    ]
    cells = [[r["rider"], f"{r['torso_inertia']:.3f}", f"{r['identified_torso_inertia']:.3f}",
              f"{r['steer_inertia']:.3f}", f"{r['identified_steer_inertia']:.4f}",
              f"{r['cross_inertia']:+.3f}", *(f"{100 * r['spread'][kind].residual:.2g} %" for kind in KINDS)]
             for r in rows]  # fmt: skip
    outside = [[r["rider"], f"{kind} [{unit}]",
                *(", ".join(f"{x:.4g}" for x in numbers) for numbers in (s.wanted, s.reached)), ", ".join(s.at_zero)]
               for r in rows for kind, unit in KINDS.items() if (s := r["spread"][kind]).at_zero]  # fmt: skip
    text.append("Four joints make three coefficients: one direction is free, and the middle of what it allows is "
                "taken. Not every fitted rider is within what springs of positive stiffness can make: bent arms that "
                "couple bar and torso stiffen the torso as well, by more than the waist of the riders in the second "
                "table has been given by the fit, whose equations know no stiffness of the steer.")  # fmt: skip
    tables = [
        Table(headings, cells),
        Table(["rider", "of", "k_a, k_t, k_s wanted", "nearest reached", "joints that would be negative"], outside),
    ]
    return Section(
        "Does anthropometry give the inertias?", text, [(chart(rows), "Torso inertia, rider by rider")], tables
    )
