"""Pictures of the signatures of effects: the torque that each form adds to a spring and damper in a sinusoidal
motion."""

from collections.abc import Sequence
from io import BytesIO
from typing import ClassVar

import numpy as np

from fmus.declaration.component import Component
from fmus.declaration.elements import Element
from fmus.declaration.variables import input, local, output, parameter
from fmus.effects import Effect
from fmus.effects.placement import laws_at
from fmus.expressions.functions import NUMERIC

DEFLECTION, FREQUENCY, SAMPLES, PERIODS = 0.1, 1.0, 240, 2  # rad, Hz, per period
CHANGE = 0.25  # added torque as a share of the base's at which a law without states is drawn
MOST_DOUBLINGS = 24


class SpringAndDamper(Component):
    """A spring and a damper whose motion is imposed."""

    stiffness = parameter("N.m/rad", "Stiffness", start=1000.0)
    damping = parameter("N.m.s/rad", "Damping", start=20.0)
    deflection = input("rad", "Deflection")
    rate = input("rad/s", "Rate of the deflection")
    spring_torque = local("N.m", "Torque against the deflection")
    torque = output("N.m", "Torque against the deflection")

    elements: ClassVar = {
        name: Element("spring_torque", "deflection", "rate", "stiffness", "damping") for name in ("spring", "rotation")
    }

    def equations(self, v, m):
        v.spring_torque = v.stiffness * v.deflection + v.damping * v.rate
        return {"torque": v.spring_torque}


def forms() -> dict[str, list[type[Effect]]]:
    """The laws of force elements by family, one for each form."""
    found: dict[str, dict[str, type[Effect]]] = {}
    for law in laws_at(SpringAndDamper("probe"), inputs={}):
        if law.element in SpringAndDamper.elements and not law.flexible:
            found.setdefault(law.family, {}).setdefault(law.form, law)
    return {family: list(laws.values()) for family, laws in found.items()}


def picture(laws: Sequence[type[Effect]]) -> str:
    """One figure of a family, as SVG: the added torque of each form over the deflection, in the second period."""
    from matplotlib.figure import Figure  # noqa: PLC0415 - no window, no state

    figure = Figure(figsize=(4.2, 2.8), layout="constrained")
    axes = figure.add_subplot()
    for law in laws:
        deflection, added = signature(law)
        if np.any(added):
            axes.plot(deflection, added / np.abs(added).max(), linewidth=1.2, label=law.form.replace("_", " "))
    axes.set(xlabel="deflection [rad]", ylabel="added torque over its largest [1]")
    axes.legend(fontsize="x-small")
    data = BytesIO()
    figure.savefig(data, format="svg", metadata={"Date": None})
    return data.getvalue().decode()


def signature(law: type[Effect]) -> tuple[np.ndarray, np.ndarray]:
    """Deflection [rad] and added torque [N.m] (n,) over the last period.

    The magnitude changes the torque by about a quarter; a law with states of its own is drawn at its starting
    magnitude.
    """
    time = np.arange(PERIODS * SAMPLES + 1) / SAMPLES / FREQUENCY
    angle = 2 * np.pi * FREQUENCY * time
    deflection, rate = DEFLECTION * np.sin(angle), DEFLECTION * 2 * np.pi * FREQUENCY * np.cos(angle)
    base = SpringAndDamper("base")
    alone = base.values["stiffness"] * deflection + base.values["damping"] * rate
    magnitude = next(iter(law.declared))
    joined = base.with_effects(law())
    values = {
        joined_name(joined, n): starting_value(law, n) for n in law.declared if law.declared[n].role == "parameter"
    }
    name = joined_name(joined, magnitude)
    added = np.zeros_like(time)
    for _ in range(MOST_DOUBLINGS):
        made = joined.with_values(**values)
        added = motion_of(made, time, deflection, rate) - alone
        size = np.sqrt(np.mean(added**2)) / np.sqrt(np.mean(alone**2))
        if made.states or size >= CHANGE or values[name] >= joined.table[name].max:
            break
        values[name] = min(max(2 * values[name], 1e-6), joined.table[name].max)
    return deflection[-SAMPLES - 1 :], added[-SAMPLES - 1 :]


def joined_name(component: Component, name: str) -> str:
    """The name of an effect's variable in the component's table."""
    return next(key for key in component.table if key == name or key.endswith(f".{name}"))


def starting_value(law: type[Effect], name: str) -> float:
    """The middle of the starting values of a fit, scaled to the motion; the declared start where there are none."""
    values = law.starts.get(name)
    if not values:
        return law.declared[name].start
    scale = (
        DEFLECTION
        if name in law.relative
        else 2 * np.pi * FREQUENCY * DEFLECTION
        if name in law.relative_to_rate
        else 1.0
    )
    return float(values[len(values) // 2] * scale)


def motion_of(component: Component, time: np.ndarray, deflection: np.ndarray, rate: np.ndarray) -> np.ndarray:
    """The torque (n,) in an imposed motion: states by the fourth-order Runge-Kutta method, linear inputs between
    samples."""
    x, torque, step = np.zeros(len(component.states)), np.zeros(len(time)), time[1]
    if not component.states:
        return (
            component.run({**component.start_values(), "time": time, "deflection": deflection, "rate": rate}, NUMERIC)[
                "torque"
            ]
            + 0 * time
        )

    def slope(state: np.ndarray, k: float) -> np.ndarray:
        at = [
            np.interp(k, (np.floor(k), np.floor(k) + 1), each[int(k) : int(k) + 2]) if k < len(time) - 1 else each[-1]
            for each in (deflection, rate)
        ]
        return component.derivatives(state, np.array(at), k * step)[0]

    for k in range(len(time)):
        torque[k] = component.derivatives(x, np.array([deflection[k], rate[k]]), time[k])[1][0]
        a = slope(x, k)
        b = slope(x + step / 2 * a, k + 0.5)
        c = slope(x + step / 2 * b, k + 0.5)
        x = x + step / 6 * (a + 2 * b + 2 * c + slope(x + step * c, min(k + 1, len(time) - 1)))
    return torque
