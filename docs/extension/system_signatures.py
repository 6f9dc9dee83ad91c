"""Pictures of the signatures of effects that are no law of a force element: how they change the modes of a motorcycle
over speed, or the response of a rider over frequency. Where neither shows them, a sentence says so."""

from collections.abc import Sequence
from functools import partial
from io import BytesIO

import numpy as np

import motofmi
from extension import signatures
from fmus.declaration.component import Component
from fmus.effects import Effect
from fmus.linear_analysis.linearisation import linearise
from motofmi.workflows.components import EFFECTS

VEHICLE, SPEED = "sharp_1971", np.arange(5.0, 61.0, 2.5)  # m/s
RIDER, FREQUENCY = "rider:mean_2011", np.arange(0.5, 12.01, 0.1)  # Hz
MODES = {"weave": "-", "wobble": "--"}
WITHOUT_PICTURE = {
    "channel_delay": "A delayed channel leaves the motion as it is: it turns the phase of that channel by 360 degrees times "
    "frequency times delay and keeps its modulus, so that there is no law to draw.",
    "motor_gain": "A wrong gain of the motor scales what the command explains by one factor at every frequency, so that "
    "there is no law to draw.",
    "sensor_nonlinearity": "The error of the sensor is a function of the load alone, whatever the motion: its square or its "
    "cube, as the form says. The motion stays as it is, so that there is no law of the motion to draw.",
    "shaft_compliance": "The bar lags behind the servo by the torque times the compliance. The law of the rider stays as it "
    "is; what changes is the angle at which it acts.",
    "waist_friction": "The law is that of `coulomb_friction`, over the angle of the torso; its picture is shown there.",
}


def forms() -> dict[str, list[type[Effect]]]:
    """The effects by family that are drawn here, one for each form."""
    found: dict[str, dict[str, type[Effect]]] = {}
    for kind in ("Motorcycle", "PassiveRider"):
        for effect in EFFECTS[kind]:
            if effect.family not in {*WITHOUT_PICTURE, *signatures.forms()}:
                found.setdefault(effect.family, {}).setdefault(effect.form, effect)
    return {family: list(effects.values()) for family, effects in found.items()}


def picture(effects: Sequence[type[Effect]]) -> str:
    """One figure of a family, as SVG, relative to the largest change of each form."""
    from matplotlib.figure import Figure  # noqa: PLC0415 - no window, no state

    figure = Figure(figsize=(4.2, 2.8), layout="constrained")
    axes = figure.add_subplot()
    on_vehicle = effects[0] in EFFECTS["Motorcycle"]
    for colour, effect in enumerate(effects):
        curves = change_of_modes(effect) if on_vehicle else change_of_response(effect)
        largest = max(np.abs(values).max() for values in curves.values())
        for (label, values), style in zip(curves.items(), MODES.values(), strict=True):
            axes.plot(SPEED if on_vehicle else FREQUENCY, values / largest, style, color=f"C{colour}", linewidth=1.2,
                      label=f"{effect.form.replace('_', ' ')}, {label}")  # fmt: skip
    axes.axhline(0, color="grey", linewidth=0.6)
    axes.set(xlabel="speed [m/s]" if on_vehicle else "frequency [Hz]",
             ylabel=f"change of {'the real part' if on_vehicle else 'T_h / steer angle'} over its largest [1]")  # fmt: skip
    axes.legend(fontsize="x-small")
    data = BytesIO()
    figure.savefig(data, format="svg", metadata={"Date": None})
    return data.getvalue().decode()


def change_of_modes(effect: type[Effect]) -> dict[str, np.ndarray]:
    """The change of the real part of weave and wobble (n,) [1/s] over the speeds, at the effect's starting values."""
    vehicle = motofmi.vehicle(VEHICLE)
    before, after = (motofmi.modes(each, speed=SPEED) for each in (vehicle, _with_effect(vehicle, effect)))
    return {name: after[name].eigenvalue.real - before[name].eigenvalue.real for name in MODES}


def change_of_response(effect: type[Effect]) -> dict[str, np.ndarray]:
    """The change of the handlebar torque per steer angle of the rider, real and imaginary part (n,) [N.m/rad]."""
    rider = motofmi.component(RIDER)
    response = partial(_response, omega=2 * np.pi * FREQUENCY)
    change = response(_with_effect(rider, effect)) - response(rider)
    return {"real": change.real, "imaginary": change.imag}


def _with_effect(component: Component, effect: type[Effect]) -> Component:
    """The component with an effect at its starting values."""
    joined = component.with_effects(effect())
    own = [n for n, row in effect.declared.items() if row.role == "parameter"]
    return joined.with_values(**{signatures.joined_name(joined, n): _starting(effect, n) for n in own})


def _response(component, omega: np.ndarray) -> np.ndarray:
    """Torque per steer angle with the rate that belongs to it (n,)."""
    space = linearise(component)
    by_angle, by_rate = (
        space.frequency_response(omega, "handlebar_torque", name) for name in ("steer_angle", "steer_rate")
    )
    return by_angle + 1j * omega * by_rate


def _starting(effect: type[Effect], name: str) -> float:
    """The middle of the starting values of a fit, else the declared start."""
    values = effect.starts.get(name)
    return float(values[len(values) // 2]) if values else effect.declared[name].start
