"""Components of a user's own whose states are no deflection and rate, and recordings of what they describe, by scipy's
`solve_ivp` from equations that share no code with the components."""

from collections.abc import Callable

import numpy as np
from scipy.integrate import solve_ivp

from fmus import Component, input, parameter, state
from motofmi.recordings.recording import Recording


class Tanks(Component):
    """Two tanks in cascade: a pump fills the upper one, whose outflow fills the lower one."""

    pump_gain = parameter("m/s/V", "Rise of the upper level per voltage", min=0, start=0.001)
    upper_outflow = parameter("m/s", "Fall of the upper level at 1 m", min=0, start=0.01)
    lower_outflow = parameter("m/s", "Fall of the lower level at 1 m", min=0, start=0.01)
    pump = input("V", "Voltage of the pump")
    upper_level = state("m", "Level of the upper tank", start=0.1)
    level = state("m", "Level of the lower tank", start=0.1, exposed=True)

    def equations(self, v, m):
        upper, lower = (m.sqrt(m.where(h > 1e-6, h, 1e-6 + 0 * h)) for h in (v.upper_level, v.level))
        return {
            "der(upper_level)": v.pump_gain * v.pump - v.upper_outflow * upper,
            "der(level)": v.upper_outflow * upper - v.lower_outflow * lower,
        }


def steps(rng: np.random.Generator, duration: float, hold: float, low: float, high: float) -> Callable:
    """A function of time that takes a random value between two limits every `hold` seconds, with linear transitions of
    a tenth of that time."""
    edges = np.arange(0.0, duration + 2 * hold, hold)
    values = rng.uniform(low, high, len(edges))
    time = np.column_stack([edges, edges + 0.9 * hold]).ravel()
    return lambda t: np.interp(t, time, np.repeat(values, 2))


def tanks_run(
    name: str, seed: int, overflow: float = np.inf, share: float = 0.0, limit: float = np.inf, noise: float = 0.0005
) -> Recording:
    """An hour of the tanks: 0.0004 m/s per volt, outflows of 0.008 and 0.0075 m/s at 1 m.

    Above the level `overflow` [m] the upper tank loses 0.5 1/s of the excess, of which a share reaches the lower one.
    The sensor of the lower level stops at `limit`.
    """
    rng, time = np.random.default_rng(seed), np.arange(0.0, 3600.0, 4.0)
    pump = steps(rng, time[-1], 120.0, 1.0, 9.0)

    def rates(t: float, h: np.ndarray) -> list[float]:
        upper, lower = 0.008 * np.sqrt(max(h[0], 0.0)), 0.0075 * np.sqrt(max(h[1], 0.0))
        over = 0.5 * max(h[0] - overflow, 0.0)
        return [0.0004 * float(pump(t)) - upper - over, upper + share * over - lower]

    found = solve_ivp(rates, (0.0, time[-1]), [0.06, 0.07], t_eval=time, rtol=1e-8, atol=1e-10, max_step=4.0)
    level = np.minimum(found.y[1] + noise * rng.standard_normal(len(time)), limit)
    return Recording(name, time, {"pump": pump(time), "level": level}, {"pump": "V", "level": "m"})
