"""Do tyres make a bicycle wobble?

The benchmark bicycle on knife edges and on tyres, at bicycle speeds: with relaxation lengths of published bicycle tyres
(about 0.1 m in earlier measurements, 0.2 to 0.3 m in VTI Rapport 952), and with a steering damper.
"""

import numpy as np

from fmus.composition.system import System
from motofmi.reports.charts import SEQUENCE, Axis, Chart, Curve, Panel, Shade
from motofmi.reports.report import Section, Table
from vehicle_fmu import LinearDamper, Modes, modes, motorcycles, over_speed, ridden

SPEEDS = np.arange(2.0, 20.1, 0.5)  # m/s
RELAXATION = (0.1, 0.2, 0.3)  # m
DAMPING = 0.5  # N.m.s/rad
KNIFE = "knife edges"


def systems(vehicle: str = "benchmark_bicycle_on_tyres", rigid: str = "benchmark_bicycle") -> dict[str, System]:
    """The bicycles by words."""
    found = {KNIFE: ridden(motorcycles.load(rigid))}
    for length in RELAXATION:
        bicycle = motorcycles.load(vehicle, front_relaxation_length=length, rear_relaxation_length=length)
        found[f"relaxation length {length:g} m"] = ridden(bicycle)
    found[f"shipped tyres, damper {DAMPING:g} N.m.s/rad"] = ridden(motorcycles.load(vehicle), LinearDamper("damper", damping=DAMPING))
    return found


def run(speeds: np.ndarray = SPEEDS, **given: str) -> dict[str, Modes]:
    """The modes of each bicycle over speeds (n,) in m/s."""
    return {words: modes(over_speed(system), speeds) for words, system in systems(**given).items()}


def chart(found: dict[str, Modes]) -> Chart:
    """Damping ratio of wobble and real part of weave over speed."""
    wobble = [Curve(words, one.speed, one["wobble"].damping_ratio, SEQUENCE[k])
              for k, (words, one) in enumerate(found.items()) if "wobble" in one.unstable]  # fmt: skip
    weave = [Curve(words, one.speed, one["weave"].eigenvalue.real, SEQUENCE[k]) for k, (words, one) in enumerate(found.items())]
    speed = Axis("speed", "m/s")
    return Chart([Panel(speed, Axis("damping ratio of wobble", "1", low=-0.1, high=1.0), wobble),
                  Panel(speed, Axis("real part of weave", "1/s"), weave, shades=[Shade(0.0, 5.0, "unstable", across="y")])],
                 columns=2)  # fmt: skip


def section(found: dict[str, Modes]) -> Section:
    """Least damping of wobble and the instability of weave, by bicycle."""
    rows, text = [], []
    for words, one in found.items():
        bands = ", ".join(f"{a:.1f} to {b:.1f}" for a, b in one.unstable["weave"]) or "none"
        ratio = one["wobble"].damping_ratio
        if np.isnan(ratio).all():
            rows.append([words, bands, "no wobble", ""])
            continue
        k = int(np.nanargmin(ratio))
        rows.append([words, bands, f"{ratio[k]:.3f} at {one.speed[k]:g}", f"{one['wobble'].frequency[k]:.1f}"])
    unstable = [words for words, one in found.items() if one.unstable.get("wobble")]
    text.append(f"On {KNIFE} the bicycle has no wobble. On tyres it has one, "
                + (f"unstable for: {', '.join(unstable)}." if unstable else "and it is stable in every case tried.")
                + " A flexible frame, which wobble of bicycles also depends on (Ploechl et al., Vehicle System Dynamics 50 (2012) 415-429), is not in this model.")  # fmt: skip
    table = Table(["bicycle", "weave unstable [m/s]", "least damping ratio of wobble, at [m/s]", "frequency [Hz]"], rows,
                  f"From {SPEEDS[0]:g} to {SPEEDS[-1]:g} m/s")  # fmt: skip
    return Section("Do tyres make a bicycle wobble?", text, [(chart(found), "Wobble and weave over speed.")], [table])
