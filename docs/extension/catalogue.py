"""The effects and the published values that ship."""

from collections import defaultdict
from typing import Any

import motofmi
from extension import signatures, system_signatures
from extension.tables import table
from fmus.effects import Effect
from fmus.effects.added_terms import added_terms
from motofmi.workflows.components import EFFECTS as EFFECT_CLASSES

EFFECTS = """# Effects

The library of the gap workflow on riders, vehicles and measuring channels. A family is a phenomenon, a form its
equation. Laws of mechanics act on any component that is given with `--component`. Pictures show the torque that a
form adds to a spring and damper in a sinusoidal motion, over the deflection and relative to its largest value; of effects that are no
such law, how they change weave and wobble of Sharp's motorcycle over speed, or the response of the mean rider over frequency. The
signature is what the workflow recognises.

"""
# When a family matters: what of an experiment makes it visible.
MATTERS = {
    "added_inertia": "at high frequency, in proportion to its square",
    "aerodynamics": "at high speed, in proportion to its square",
    "asymmetry": "with an offset and even harmonics; in runs to both sides",
    "backlash": "at small amplitude, where the stiffness is lost",
    "channel_delay": "at high frequency: a phase in proportion to it; looks like negative damping",
    "coulomb_friction": "at small amplitude, where its torque is a large share; odd harmonics at any amplitude",
    "cross_inertia": "where the torso moves against the handlebar; needs a rate gyro on the torso to be identified",
    "damping_asymmetry": "with even harmonics in phase with the rate; in runs to both sides",
    "drift": "between the beginning and the end of a run; needs sweeps up and down, else it looks like a delay",
    "extra_mode": "around its own resonance",
    "frame_compliance": "in the wobble of a compliant frame at medium speed",
    "geometric_nonlinearity": "at large angles, from about half a radian",
    "hardening_stiffness": "at large amplitude; third harmonic in phase with the deflection",
    "hysteresis": "in the loop of torque over deflection at any rate; damping without frequency",
    "motor_gain": "in every run with the steer motor, in proportion to its command",
    "passive_rider": "in weave and wobble with the hands on the bar",
    "progressive_damping": "at high rates; third harmonic in phase with the rate",
    "reflex": "up to a few hertz, where the rider reacts with the delay of muscles",
    "rider_lean": "in capsize and weave, in the range of the upper body's roll resonance",
    "roll_inertia": "in weave",
    "saturation": "at large amplitude, where the torque no longer grows",
    "sensor_nonlinearity": "at large loads, in every run alike",
    "shaft_compliance": "at high frequency and large torque between servo and bar",
    "steer_damping": "in wobble; needs a sweep of the bare handlebar to be separated from the rider's damping",
    "steer_stiffness": "at low frequency; needs a sweep of the bare handlebar",
    "tyre_relaxation": "in wobble, and in weave at high speed",
    "viscoelastic_arm": "over a wide band: stiffness that rises with the frequency",
    "waist_friction": "at small motion of the torso",
}
VALUES = """# Riders, motorcycles, dampers

Every entry is a name for `--vehicle`, `--device` and `mf.component`; `motofmi list --json -` has all values.
"""


def effects() -> str:
    families = defaultdict(list)
    for entry in motofmi.catalogue().to_dict()["effects"]:
        families[entry["name"]].append(entry)
    drawn, terms = signatures.forms(), equations()
    named = [*families, *(family for family in drawn if family not in families)]
    return EFFECTS + "\n".join(_family(name, families[name], drawn.get(name, []), terms) for name in sorted(named))


def equations() -> dict[tuple[str, str], str]:
    """The equations of every form in words, by family and form."""
    laws = [law for found in signatures.forms().values() for law in found]
    every = [*laws, *(effect for found in EFFECT_CLASSES.values() for effect in found)]
    return {(each.family, each.form): "; ".join(f"`{line}`" for line in added_terms(each)) for each in every}


def _family(
    name: str, entries: list[dict[str, Any]], laws: list[type[Effect]], terms: dict[tuple[str, str], str]
) -> str:
    rows = [
        (
            f"`{e['form']}`",
            e["element"] or "",
            e["description"],
            terms.get((name, e["form"]), ""),
            ", ".join(f"`{n}` [{row['unit']}]" for n, row in e["parameters"].items()),
        )
        for e in entries
    ] or [
        (
            f"`{law.form}`",
            law.element,
            law.sentence(),
            terms.get((name, law.form), ""),
            ", ".join(f"`{n}` [{row.unit}]" for n, row in law.declared.items() if row.role == "parameter"),
        )
        for law in laws
    ]
    shown = "Added torque over deflection" if laws else "Change of the modes or of the response"
    image = f"![{shown}](signature_{name}.svg)"
    image = f"{system_signatures.WITHOUT_PICTURE.get(name, image)}\n\n"
    return f"## {name}\n\nMatters {MATTERS[name]}.\n\n{image}{table(('form', 'place', 'meaning', 'equation', 'parameters'), rows)}"


def values() -> str:
    found = motofmi.catalogue().to_dict()
    sections = [VALUES]
    for kind in ("motorcycles", "riders", "dampers", "mechanisms"):
        rows = [(f"`{e['name']}`", e["component"], e["description"], e["source"]) for e in found[kind]]
        sections.append(f"## {kind.capitalize()}\n\n{table(('name', 'component', 'description', 'source'), rows)}")
    return "\n".join(sections)
