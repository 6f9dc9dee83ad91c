"""A device at the handlebar as an effect: the vehicle with a rider or a damper whose parameters are not known.

    T_h(x, s, w) and T_f(x, s, w) of the device are added to the inputs `handlebar_torque` and `frame_torque` of the
    vehicle, `port_inertia` to its `added_steer_inertia`, and the states x of the device to its states.

The vehicle with the effect equals the vehicle with the device as a system (`vehicle_fmu.ridden`), but is one
component. The law is that of the device's class; so a new class needs no effect of its own.
"""

import re
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import replace
from functools import partial
from typing import Any, ClassVar

import numpy as np

from fmus.declaration.component import Component
from fmus.effects import Effect
from fmus.effects.prior import LogNormalPrior
from fmus.interfaces.handlebar import TORQUES, HandlebarDevice
from fmus.interfaces.posture_inertia import POSTURE
from fmus.support.errors import InputError, NotApplicableError

MOTION = ("steer_angle", "steer_rate")  # states of the vehicle; it calculates the frame rate
INERTIA = {"added_steer_inertia": "port_inertia"}  # of the vehicle, and of the device


class DeviceEffect(Effect):
    """A device at the handlebar. `kind` is its class, of which `device` is an instance with any values; linear says
    that its torques are linear in its motion."""

    kind: ClassVar[type[HandlebarDevice]]
    device: ClassVar[HandlebarDevice]
    linear: ClassVar[bool]
    bare: Component  # the vehicle without effects

    def join(self, component: Component) -> None:
        """Add the device. Raises InputError for a component that has no handlebar port."""
        missing = [n for n in TORQUES if n not in component.inputs]
        if missing:
            raise NotApplicableError(f"{component.title} has no handlebar port: {', '.join(missing)} is missing")
        self.bare = type(component)(component.name)
        super().join(component)

    def additions(self) -> Iterator[tuple[str, Callable]]:
        """The rates of the device's states, its torques, and its inertia."""
        for name in self.device.states:
            yield f"der({name})", partial(self.result, name=f"der({name})")
        for name in TORQUES:
            yield name, partial(self.result, name=name)
        for target, name in INERTIA.items():
            if name in self.device.table:
                yield target, partial(self.result, name=name)

    @classmethod
    def reads(cls) -> set[str]:
        """The motion of the handlebar, and the device's own parameters and states."""
        return {*MOTION, "frame_rate", *cls.device.values, *cls.device.states}

    def result(self, v: Any, m: Any, name: str) -> Any:
        """A result of the device at the motion of the vehicle's handlebar."""
        known = {n: getattr(v, n) for n in (*self.bare.rows("parameter", "state", "input"), "time")}
        motion = {n: known[n] for n in MOTION}
        motion["frame_rate"] = self.bare.run(known, m)["frame_rate"]
        own = {n: getattr(v, n) for n in (*self.device.values, *self.device.states)}
        return self.device.run({**own, **motion, "time": v.time}, m)[name]

    @classmethod
    def with_values(cls, values: Mapping[str, float], name: str = "", source: str = "") -> Component:
        """The device with values of the effect's parameters."""
        return cls.kind(name, source, (), **{**cls.device.values, **values})


def device_effect(device: HandlebarDevice, prior: LogNormalPrior) -> type[DeviceEffect]:
    """The effect of a device with the prior of its free parameters; others keep the values of the device.

    Raises InputError for a device whose inertia changes with posture, or that has a mass matrix.
    """
    kind = type(device)
    if set(POSTURE) <= device.table.keys():
        raise InputError(f"{device.title} has an inertia that changes with posture, which no effect adds to a vehicle")
    median = dict(zip(prior.names, prior.median, strict=True))
    lowest = {n: 1e-3 * x - o for n, x, o in zip(prior.names, prior.median + prior.offset, prior.offset, strict=True)}
    parameters = {n: replace(row, start=float(median.get(n, device.values[n])),
                             min=max(row.min, lowest.get(n, row.min)))
                  for n, row in device.rows("parameter").items()}  # fmt: skip
    body: dict[str, Any] = {
        "__doc__": kind.__doc__,
        "__module__": kind.__module__,
        "family": kind.family or _words(kind.__name__),
        "form": kind.form,
        "kind": kind,
        "device": device,
        "linear": _is_linear(device),
        "prior": prior,
        "declared": {**parameters, **device.rows("state")},
        "given": tuple(n for n in parameters if n not in prior.names),
    }
    return type(f"{kind.__name__}AtHandlebar", (DeviceEffect,), body)


def distinct(effects: Sequence[type[Effect]]) -> list[type[Effect]]:
    """The effects, of several with one family and form the first: they are one law."""
    found: dict[tuple[str, str], type[Effect]] = {}
    for effect in effects:
        found.setdefault((effect.family, effect.form), effect)
    return list(found.values())


def _is_linear(device: Component) -> bool:
    """Whether rates and torques double with the motion."""
    motion = np.arange(1.0, 1.0 + len(device.states)), np.arange(1.0, 1.0 + len(device.inputs))
    once, twice = (device.derivatives(scale * motion[0], scale * motion[1]) for scale in (1.0, 2.0))
    return all(np.allclose(2 * a, b) for a, b in zip(once, twice, strict=True))


def _words(name: str) -> str:
    """`PassiveRider` as passive_rider."""
    return re.sub(r"(?<!^)(?=[A-Z])", "_", name).lower()
