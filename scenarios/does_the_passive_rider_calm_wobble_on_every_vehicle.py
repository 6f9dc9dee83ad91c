"""Does the passive rider calm wobble on every vehicle, and what does he do to weave? Writes docs/vehicles.md.

    python -m motofmi.scenarios.does_the_passive_rider_calm_wobble_on_every_vehicle

Each vehicle with the hands off, with the mean rider of 2011 and with an added steering damper of 7.5 N.m.s/rad; Sharp's
motorcycle of 1994 also with its own hands. For each the unstable intervals of speed and the least damping ratio of
weave and wobble are given.
"""

import argparse
from functools import partial
from pathlib import Path

import numpy as np

from fmus.composition.system import System
from fmus.expressions.functions import NUMERIC
from fmus.support.files import write_atomically
from motofmi.reports.report import Section, Table
from motofmi.scenarios.do_tyres_make_a_bicycle_wobble import run as run_bicycles
from motofmi.scenarios.do_tyres_make_a_bicycle_wobble import section as section_of_bicycles
from motofmi.scenarios.does_fork_bending_turn_the_trend_of_wobble_round import findings
from motofmi.scenarios.does_fork_bending_turn_the_trend_of_wobble_round import run as run_freedoms
from motofmi.scenarios.does_fork_bending_turn_the_trend_of_wobble_round import table as table_of_freedoms
from motofmi.scenarios.is_a_passive_rider_like_sharps_hands import run as run_hands
from motofmi.scenarios.is_a_passive_rider_like_sharps_hands import section as section_of_hands
from motofmi.scenarios.what_do_suspensions_do_to_weave_in_a_corner import run as run_suspensions
from motofmi.scenarios.what_do_suspensions_do_to_weave_in_a_corner import section as section_of_suspensions
from motofmi.scenarios.what_does_each_reading_do_to_sharp_1994 import run as run_readings
from motofmi.scenarios.what_does_each_reading_do_to_sharp_1994 import table as table_of_readings
from motofmi.scenarios.what_does_the_passive_rider_do_to_weave_in_a_corner import run as run_corners
from motofmi.scenarios.what_does_the_passive_rider_do_to_weave_in_a_corner import section as section_of_corners
from motofmi.scenarios.which_damper_serves_which_vehicle import run as run_dampers
from motofmi.scenarios.which_damper_serves_which_vehicle import section as section_of_dampers
from rider_fmu import riders
from vehicle_fmu import LinearDamper, Modes, modes, motorcycles, over_speed, ridden

BICYCLE = "benchmark_bicycle_on_tyres"
VEHICLES = ("sharp_1971", "reference_2011", "sharp_1994", "tum_2020", BICYCLE)
SPEEDS = np.arange(10.0, 70.25, 0.5)  # m/s: from where a motorcycle is ridden hands off; the top of its range
BICYCLE_SPEEDS = np.arange(4.0, 20.1, 0.5)  # m/s
DAMPING = 7.5  # N.m.s/rad, added in Fig. 14 of the 2011 paper
OFF, RIDER, DAMPER, HANDS = "hands off", "mean rider", f"damper {DAMPING:g} N.m.s/rad", "Sharp's hands"


def systems(vehicle: str) -> dict[str, System]:
    """The vehicle with each device, by words."""
    motorcycle = motorcycles.load(vehicle)
    found = {
        OFF: ridden(motorcycle),
        RIDER: ridden(motorcycle, riders.load("mean_2011")),
        DAMPER: ridden(motorcycle, LinearDamper("damper", damping=DAMPING)),
    }
    if "hands_on" in motorcycle.values:
        found[HANDS] = ridden(motorcycle.with_values(hands_on=1.0))
    return found


def run(vehicles: tuple[str, ...] = VEHICLES, speeds: np.ndarray = SPEEDS) -> dict[tuple[str, str], Modes]:
    """The modes by vehicle and device, over speeds [m/s]; of the bicycle over its own."""
    return {(vehicle, words): modes(over_speed(system), BICYCLE_SPEEDS if vehicle == BICYCLE else speeds)
            for vehicle in vehicles for words, system in systems(vehicle).items()}  # fmt: skip


def table(found: dict[tuple[str, str], Modes]) -> Table:
    """One row for each vehicle and device."""
    first = next(iter(found.values())).speed
    rows = [[vehicle, words, bands(one, "weave"), bands(one, "wobble"), least(one, "weave"), least(one, "wobble")]
            for (vehicle, words), one in found.items()]  # fmt: skip
    return Table(["vehicle", "at the handlebar", "weave unstable [m/s]", "wobble unstable [m/s]",
                  "least damping ratio of weave", "of wobble"], rows,
                 f"From {first[0]:g} to {first[-1]:g} m/s; the speed of the least damping in parentheses")  # fmt: skip


def bands(one: Modes, mode: str) -> str:
    """The unstable intervals of a mode in words."""
    return ", ".join(f"{low:.1f} to {high:.1f}" for low, high in one.unstable.get(mode, ())) or "none"


def least(one: Modes, mode: str) -> str:
    """The least damping ratio of a mode and the speed at which it occurs; real roots count as above 1."""
    ratio = one[mode].damping_ratio
    if np.isnan(ratio).all():
        return "overdamped"
    k = int(np.nanargmin(ratio))
    return f"{ratio[k]:.3f} ({one.speed[k]:g})"


def answer(found: dict[tuple[str, str], Modes]) -> str:
    """The answer in sentences, from the numbers."""
    lines = []
    for vehicle in dict.fromkeys(vehicle for vehicle, _ in found):
        off, rider = found[vehicle, OFF], found[vehicle, RIDER]
        more, worse = (float(np.nanmean(sign * (rider[m].eigenvalue.real - off[m].eigenvalue.real) > 0))
                       for m, sign in (("wobble", -1), ("weave", 1)))  # fmt: skip
        lines.append(f"On {vehicle} the mean rider makes wobble more stable at {more:.0%} of the speeds "
                     f"and weave less stable at {worse:.0%}.")  # fmt: skip
    return " ".join(lines)


def section(found: dict[tuple[str, str], Modes]) -> Section:
    """The answer with the table of all vehicles."""
    return Section("Does the passive rider calm wobble on every vehicle?", [answer(found)], [], [table(found)])


def markdown(table: Table) -> str:
    """A table as Markdown."""
    lines = [f"**{table.caption}**", "", "| " + " | ".join(table.headings) + " |", "|" + "---|" * len(table.headings)]
    return "\n".join([*lines, *("| " + " | ".join(row) + " |" for row in table.rows)])


def printed() -> Table:
    """What the model files of the touring motorcycle print, beside what is computed."""
    name = "tum_2020"
    motorcycle, expected = motorcycles.load(name), motorcycles.contents(name)["printed"]
    values = motorcycle.run({**motorcycle.start_values(), "speed": 0.1}, NUMERIC)
    front, rear = float(values["front_load"]), float(values["rear_load"])
    mass = (front + rear) / motorcycle.values["gravity"]
    computed = {"mass": mass, "front_load": front, "rear_load": rear}
    units = {"mass": "kg", "front_load": "N", "rear_load": "N"}
    rows = [[n.replace("_", " "), f"{expected[n]:g} {units[n]}", f"{x:.2f} {units[n]}", f"{x - expected[n]:+.2f}"]
            for n, x in computed.items()]  # fmt: skip
    return Table(["quantity", "printed", "computed", "difference"], rows, "Printed numbers of the model")


def page() -> str:
    """The text of docs/vehicles.md."""
    found, choices, freedoms = run(), run_readings(), run_freedoms()
    corners, suspensions = section_of_corners(run_corners()), section_of_suspensions(run_suspensions())
    hands, dampers, bicycles = section_of_hands(run_hands()), section_of_dampers(run_dampers()), section_of_bicycles(run_bicycles())
    return f"""# Vehicles

Rendered by `python -m motofmi.scenarios.does_the_passive_rider_calm_wobble_on_every_vehicle`. No value is tuned.

| vehicle | what it is |
|---|---|
| `sharp_1971` | rigid frames, two relaxing tyres; `reference_2011` is the same with the damper that the 2011 paper prints |
| `sharp_1994` | steering head with lateral and torsional compliance, rear frame that twists, rider's upper body in roll, tyres that depend on their load, aerodynamic and drive forces, hands on or off the bar |
| `tum_2020` | touring motorcycle of TU Munich and BMW: torsion of frame, fork and swingarm, bending of the fork, a rider who leans and slides, each free or locked; Magic Formula tyres with camber and relaxation, linear at their load in straight running; in corners (`motofmi trim`) complete, with longitudinal slip, and with suspensions and tyres that deflect, which straight running keeps locked |
| `benchmark_bicycle` | knife-edge wheels without slip; it has no wobble |
| `benchmark_bicycle_on_tyres` | the same bodies on tyres that slip and relax, with coefficients of published bicycle tyres |

## Does the passive rider calm wobble on every vehicle?

{answer(found)}

{markdown(table(found))}

Sharp's hands of 1994 are a spring, a damper and an inertia between front and rear frame (`--set hands_on=1`). The
passive rider is a body on springs: his torso moves against the bar, and the reaction goes to the frame through his waist.

## Is a passive rider like Sharp's hands?

{" ".join(hands.paragraphs)}

{markdown(hands.tables[0])}

## Which steering damper serves which vehicle?

{" ".join(dampers.paragraphs)}

{markdown(dampers.tables[0])}

## Do tyres make a bicycle wobble?

{" ".join(bicycles.paragraphs)}

{markdown(bicycles.tables[0])}

## What each reading of the values of 1994 does

The parameter file of `sharp_1994` leaves choices open. The shipped choices and their reasons are in its value file; every
other choice is a parameter. One of them is changed in each row.

{markdown(table_of_readings(choices))}

## What each freedom of `tum_2020` does

{markdown(findings(freedoms))}

{markdown(table_of_freedoms(freedoms))}

One freedom is free in each row; `--set fork_bending=0` locks one. The paper's curves are drawings: its text states the
trends above and no eigenvalues. The model of the paper also moves its suspensions; in straight running they are locked here, in corners free.

## What does the passive rider do to weave in a corner?

{" ".join(corners.paragraphs)}

{markdown(corners.tables[0])}

{markdown(corners.tables[1])}

`motofmi trim --vehicle tum_2020 --speed 30 --lean 30` finds the equilibrium of `tum_2020` in steady turning and the modes about it.
Its equations hold in large motion: eight rigid bodies in space, wheels as tori on a flat road, the complete Magic Formula
in side slip, longitudinal slip and camber. The steer torque is what the rider has to apply beside his passive springs, which are
free of load in the corner. Turn slip is left out.

The same motorcycle is an FMU in large motion, whose states are height, pitch and spins of the wheels in place of deflections and
slips, and which needs no Python. `motofmi build tum_2020 --lean 30 --speed 30` writes it with the steady turn as its start.
`motofmi cosimulate --vehicle tum_2020 --lean 30 --speed 30 --device rider:mean_2011 --initial steer_rate=0.5` couples it with the
rider from the same start, with the trim's drive torque and steer torque as constant inputs. The rider's steer angle and frame rate
are there relative to those of the trim, so that his springs are free of load in the steady turn, as in `motofmi trim`. Nothing
keeps the roll: the run shows the motion after a small change, for as long as capsize is slow. A wheel that leaves the road is
outside of the model. Generated code and compilation take about a minute, once.

## What do suspensions and acceleration do to weave in a corner?

{" ".join(suspensions.paragraphs)}

{markdown(suspensions.tables[0])}

{markdown(suspensions.tables[1])}

Published and used: springs, preloads and dampers of both suspensions, the rear linkage (rod, rocker, spring), lengthwise bending of
the fork, stiffness and damping of the tyres across the road, longitudinal and combined slip, and the brakes' distribution
(most in front). Readings: each damper has the mean of its slopes in compression and rebound (first harmonic of its force); r_By3 of combined
slip counts with the size of the slip angle, so that left and right turns are alike; the file's `d_kappa` is not used by the model.
The preloads that the model prints are those of equilibrium, to their rounding. Freedoms are locked one by one:
`--set front_suspension=0`, `rear_suspension`, `fork_lengthwise_bending`, `front_tyre_deflection`, `rear_tyre_deflection`,
`front_longitudinal_slip`, `rear_longitudinal_slip`.

Modes in the plane are named upright by where their kinetic energy is. The rear damper is so strong that the hop of the rear wheel is
overdamped: one of its two real roots has the name; the slow one, near -6 1/s, has none.

`--longitudinal-acceleration=-4` brakes, positive values drive: a quasi-equilibrium, in which only the speed changes. Modes there are
those at constant speed. The command says where it ends: at a wheelie, a stoppie, or the grip of a tyre.

Equilibria end where a tyre gives its greatest side force, near <!-- measured hosts.corners_end.5.equilibrium | .0f --><!-- end --> deg of lean at 5 m/s, <!-- measured hosts.corners_end.30.equilibrium | .0f --><!-- end --> at 30 m/s and <!-- measured hosts.corners_end.60.equilibrium | .0f --><!-- end --> at 60 m/s.
With tyres that deflect there are modes at every equilibrium. With rigid tyres side forces follow the loads at once, and at large lean
angles the motion no longer determines the loads; the command then says so.

What was checked: upright and with all freedoms in the plane locked, matrices and eigenvalues are those of straight running (1e-11 of the largest
entry in a row: rounding). Stiff suspensions and tyres recover the locked motorcycle, with an error that falls as 1/k. Exudyn, with its own
contacts, linkage and longitudinal forces (`exudyn_corner`), leaves accelerations of at most <!-- measured hosts.exudyn_corner.largest_rate | .0e --><!-- end --> m/s2 at the equilibria at eight speeds from 6 to 70 m/s and
0, 15, 30 and 45 deg of lean, and its eigenvalues agree within <!-- measured hosts.exudyn_corner.largest_error | .0e --><!-- end -->, hands off and with the mean rider; with -4 and 2 m/s2 likewise. The energy of the bodies, springs and tyres changes by the power of the forces to 1e-9. Left and right mirror each other. Public
sources print no equilibrium and no eigenvalue of this motorcycle in a corner.

## Printed numbers

The model files of `tum_2020` print mass, wheelbase, mass centre and static loads:

{markdown(printed())}

Public sources print eigenvalues of `sharp_1971` and of the benchmark bicycle, and features of the modes of the 2011 paper;
`motofmi tour` shows all of them beside the computed ones. For `sharp_1994` no printed eigenvalue was found in a public
source: its AutoSim model is published as parameters, and texts about it show root loci as drawings.
"""


def main(arguments: list[str] | None = None) -> None:
    parser = argparse.ArgumentParser(description="Write the page about the vehicles.")
    parser.add_argument("folder", nargs="?", default="docs", help="default: docs")
    folder = Path(parser.parse_args(arguments).folder)
    print(write_atomically(folder / "vehicles.md", partial(Path.write_text, data=page(), encoding="utf-8")))


if __name__ == "__main__":
    main()
