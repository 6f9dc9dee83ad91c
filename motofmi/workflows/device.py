"""Transfer functions of a device at its port, from the steer or roll angle to its torques and forces, with the
vehicle's other motion held at zero."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from fmus.interfaces.handlebar import TORQUES
from fmus.interfaces.roll import FLOWS
from fmus.linear_analysis.linearisation import StateSpace, linearise
from fmus.support.errors import InputError, unknown
from fmus.support.notebook import html, new_axes
from motofmi.reports.bode import bode
from motofmi.reports.shown import Interactive
from motofmi.workflows.components import ComponentLike, with_settings
from motofmi.workflows.components import device as device_of

PORTS = (("steer", tuple(TORQUES)), ("roll", FLOWS))
FREQUENCY = np.arange(0.5, 12.01, 0.5)  # Hz


@dataclass(frozen=True, repr=False)
class TransferFunctions:
    """Torques and forces per angle of the device, complex (n,) by name, at frequencies (n,) in Hz; units
    holds theirs by name.

        >>> found = mf.transfer_functions("rider:mean_2011", [1.0, 2.0, 4.0])
        >>> found["handlebar_torque"].shape, found.units["handlebar_torque"]
        ((3,), 'N.m/rad')
        >>> list(found.to_dataframe().columns), found.to_xarray().frequency.units
        (['handlebar_torque', 'frame_torque'], 'Hz')
        >>> axes, page = found.plot(), found.show().save("bode.html")
        >>> sorted(found.to_dict())
        ['assumed', 'device', 'frame_torque', 'frequency', 'handlebar_torque']
    """

    device: str
    frequency: np.ndarray
    responses: Mapping[str, np.ndarray]
    units: Mapping[str, str]
    assumed: Mapping[str, str]

    def __getitem__(self, output: str) -> np.ndarray:
        if output not in self.responses:
            raise unknown(f"output of {self.device}", output, self.responses)
        return self.responses[output]

    def __repr__(self) -> str:
        return f"TransferFunctions({self.device!r}: {', '.join(self.responses)} at {len(self.frequency)} frequencies)"

    def _repr_html_(self) -> str:
        rows = [(name, self.units[name], f"{abs(z[0]):.4g}", f"{abs(z[-1]):.4g}") for name, z in self.responses.items()]
        ends = (f"magnitude at {f:g} Hz" for f in (self.frequency[0], self.frequency[-1]))
        return html(f"{self.device}: torque or force per angle", ("output", "unit", *ends), rows, self._magnitudes)

    def plot(self, axes: Any = None) -> Any:
        """Bode diagram: magnitude above phase, a line for each output; the two axes of matplotlib."""
        magnitude, phase = axes = new_axes(2, sharex=True) if axes is None else axes
        self._magnitudes(magnitude)
        for z in self.responses.values():
            phase.semilogx(self.frequency, np.degrees(np.angle(z)))
        magnitude.set_xlabel("")
        phase.set(xlabel="frequency [Hz]", ylabel="phase [deg]")
        return axes

    def show(self) -> Interactive:
        """The Bode diagram, interactive in a notebook."""
        return Interactive(bode(self.frequency, self.responses, self.units), self.device)

    def _magnitudes(self, axes: Any) -> None:
        for name, z in self.responses.items():
            axes.loglog(self.frequency, np.abs(z), label=f"{name.replace('_', ' ')} [{self.units[name]}]")
        axes.set(xlabel="frequency [Hz]", ylabel="magnitude", title=self.device)
        axes.legend()

    def to_dict(self) -> dict[str, Any]:
        """The keys of `motofmi device --json`."""
        return {"device": self.device, "assumed": dict(self.assumed), "frequency": self.frequency, **self.responses}

    def to_dataframe(self) -> Any:
        """Complex responses by frequency (pandas.DataFrame with the index `frequency`)."""
        import pandas as pd  # noqa: PLC0415 - imported on use

        return pd.DataFrame(dict(self.responses), index=pd.Index(self.frequency, name="frequency"))

    def to_xarray(self) -> Any:
        """Complex responses over `frequency`, with units as attributes (xarray.Dataset)."""
        import xarray as xr  # noqa: PLC0415 - imported on use

        return xr.Dataset({name: ("frequency", z, {"units": self.units[name]}) for name, z in self.responses.items()},
                          {"frequency": ("frequency", self.frequency, {"units": "Hz"})},
                          {"device": self.device})  # fmt: skip


def transfer_functions(
    device: ComponentLike, frequency: ArrayLike = FREQUENCY, *, set: Mapping[str, float] | None = None
) -> TransferFunctions:
    """Torques and forces of a device per angle at its port [N.m/rad, N/rad] at `frequency` (n,) [Hz],
    with the port's signs.

        T(i w) = T_angle(i w) + i w T_rate(i w)

    the sum of the responses to the angle and to its rate (Cossalter, Doria, Lot, Massaro, Meccanica 46 (2011), eqs 10
    to 14). set replaces parameters by name, in SI units. Raises InputError for a component that is no device, and for
    frequencies that are not finite and positive.

        >>> abs(mf.transfer_functions("damper:7.5", [1.0])["handlebar_torque"] / (2 * np.pi * 7.5)).round(6)
        array([1.])
    """
    found = device_of(device)
    if found is None:
        raise InputError("device 'none' has no transfer functions (valid: rider:NAME, damper:NAME, damper:VALUE)")
    (found,) = with_settings({"device": found}, set or {})
    assert found is not None
    frequencies = np.atleast_1d(np.asarray(frequency, float))
    if not (np.isfinite(frequencies).all() and (frequencies > 0).all()):
        raise InputError(
            f"frequencies must be finite and positive [Hz], not {np.array2string(frequencies, threshold=6)}"
        )
    responses = at_the_port(linearise(found), 2 * np.pi * frequencies)
    return TransferFunctions(
        found.name, frequencies, responses, {n: f"{found.table[n].unit}/rad" for n in responses}, found.assumed
    )


def at_the_port(space: StateSpace, omega: np.ndarray) -> dict[str, np.ndarray]:
    """The responses of a linearised device to the angle of its port, at omega [rad/s], by the names of its outputs."""
    motion, outputs = next(port for port in PORTS if port[1][0] in space.outputs)
    return {n: space.frequency_response(omega, n, f"{motion}_angle")
            + 1j * omega * space.frequency_response(omega, n, f"{motion}_rate") for n in outputs}  # fmt: skip
