"""Measures, masses and inertias of a rider from height and mass, and the posture on the test rig.

The trunk's three parts are between suprasternale, xiphion, omphalion and the midpoint of the hips.
Source of the segments: de Leva, Adjustments to Zatsiorsky-Seluyanov's segment inertia parameters, J. Biomech. 29(9)
(1996) 1223-1230, Table 4, males (mean height 1.741 m). Lengths are between joint centres (trunk: midpoint of the
shoulders to midpoint of the hips; head: vertex to cervicale; hand: wrist to third metacarpale).
Source of the posture: Cossalter, Doria, Lot, Massaro, Meccanica 46 (2011), Sect. 3.1: saddle and steering head.
The values in `ASSUMED` are not in the papers; they are assumptions of this model.
"""

from dataclasses import dataclass

from fmus.support.errors import InputError

MEAN_HEIGHT = 1.741  # m
HANDLEBAR = {"grip_setback": 0.2, "grip_half_width": 0.34, "grip_rise": 0.0, "elbow_spread": 0.6}
SADDLE = {"saddle_distance": 0.6, "saddle_drop": 0.35}
ASSUMED = {
    "steer_tilt": "the caster angle of Sharp's motorcycle; the mock-up's is not printed",
    "grip_setback": "not printed; a touring handlebar",
    "grip_half_width": "not printed; a touring handlebar",
    "grip_rise": "not printed; a touring handlebar",
    "elbow_spread": "not printed; elbows down and out",
    "hip_rise": "hip joints above the saddle, sitting",
    "shoulder_half_width": "half of a biacromial breadth of 0.23 of the height",
}


@dataclass(frozen=True)
class Segment:
    """Length [m], mass [kg], mass centre from the upper end [m], and inertias about the mass centre [kg.m2].

    The axes of the inertias are the long axis, a transverse axis (mean of two), and the sagittal axis (roll).
    """

    length: float
    mass: float
    centre: float
    along: float
    across: float
    roll: float


HELMET = 1.4  # kg
ARMS_AT = (
    0.33,
    0.25,
)  # m: mass centre of an arm above the hips and beside the spine, at the mean height, hands on the bar
NECK = 603.3  # mm: midpoint of the hips to cervicale

# name: length [mm], mass [% of the body], mass centre [% of the length], radii of gyration [% of the length]:
# sagittal, transverse, longitudinal
TABLE_4 = {
    "head": (242.9, 6.94, 50.02, 30.3, 31.5, 26.1),
    "upper_trunk": (170.7, 15.96, 29.99, 71.6, 45.4, 65.9),
    "middle_trunk": (215.5, 16.33, 45.02, 48.2, 38.3, 46.8),
    "lower_trunk": (145.7, 11.17, 61.15, 61.5, 55.1, 58.7),
    "trunk": (515.5, 43.46, 43.10, 38.4, 35.8, 19.7),
    "upper_arm": (281.7, 2.71, 57.72, 28.5, 26.9, 15.8),
    "forearm": (268.9, 1.62, 45.74, 27.6, 26.5, 12.1),
    "hand": (86.2, 0.61, 79.00, 62.8, 51.3, 40.1),
}


def segments(height: float, mass: float) -> dict[str, Segment]:
    """The body segments by name for a height [m] and a mass [kg].

    Raises InputError outside 1 to 2.5 m and 20 to 250 kg.
    """
    for name, value, low, high, unit in (("height", height, 1.0, 2.5, "m"), ("mass", mass, 20.0, 250.0, "kg")):
        if not low <= value <= high:
            raise InputError(f"rider's {name} = {value:g} {unit} is outside [{low:g}, {high:g}]")
    found = {}  # the radii are about the mass centre
    for name, (length_mm, percent, centre, sagittal, transverse, along) in TABLE_4.items():
        length, share = length_mm / 1000 * height / MEAN_HEIGHT, percent / 100 * mass
        across = (sagittal**2 + transverse**2) / 2
        found[name] = Segment(
            length,
            share,
            centre / 100 * length,
            *(share * length**2 * square / 1e4 for square in (along**2, across, sagittal**2)),
        )
    return found


def full_rider_values(height: float, mass: float, inclination: float) -> dict[str, float]:
    """Parameters of the full rider, except those of its joints, from height [m], mass [kg] and torso inclination
    [rad].
    """
    body = segments(height, mass)
    hand = body["hand"]
    ahead = hand.centre - HANDLEBAR["grip_setback"]
    values = {"steer_tilt": 0.4715, "torso_inclination": inclination, **SADDLE, "hip_rise": 0.08, **HANDLEBAR,
              "torso_length": body["trunk"].length, "shoulder_half_width": 0.115 * height, "hand_mass": hand.mass,
              "hands_inertia": 2 * (hand.mass * (ahead**2 + HANDLEBAR["grip_half_width"] ** 2) + hand.across),
              "trunk_inertia": body["trunk"].along + body["head"].along}  # fmt: skip
    for limb in ("upper_arm", "forearm"):
        part = body[limb]
        values |= {
            f"{limb}_length": part.length,
            f"{limb}_mass": part.mass,
            f"{limb}_centre": part.centre,
            f"{limb}_inertia": part.across,
        }
    return values


def roll_values(height: float, mass: float) -> dict[str, float]:
    """Masses, heights and roll inertias of the rider in roll, with helmet, from height [m] and mass [kg]."""
    body, scale = segments(height, mass), height / MEAN_HEIGHT
    upper, middle, lower, head = (body[name] for name in ("upper_trunk", "middle_trunk", "lower_trunk", "head"))
    hips = lower.length + middle.length + upper.length
    arms = 2 * sum(body[name].mass for name in ("upper_arm", "forearm", "hand"))
    parts = ((upper.mass, hips - upper.centre, 0.0, upper.roll),
             (middle.mass, hips - upper.length - middle.centre, 0.0, middle.roll),
             (arms, ARMS_AT[0] * scale, ARMS_AT[1] * scale, 0.0))  # fmt: skip
    torso = sum(m for m, *_ in parts)
    centre = sum(m * z for m, z, *_ in parts) / torso
    return {"pelvis_mass": lower.mass, "torso_mass": torso, "torso_centre": centre,
            "torso_roll_inertia": sum(m * ((z - centre) ** 2 + y**2) + J for m, z, y, J in parts),
            "neck_height": NECK / 1000 * scale, "head_mass": head.mass + HELMET,
            "head_centre": head.length - head.centre,
            "head_roll_inertia": head.roll * (head.mass + HELMET) / head.mass}  # fmt: skip
