"""Free swings of a pendulum with dry friction and drag, from one turning point to the next by scipy.

    J q'' = -k q - c q' - T_c sign(q') - c_2 |q'| q'

Between two turning points the sign of the rate is constant and the equation is smooth. The pendulum stays where gravity
does not overcome dry friction.
"""

import numpy as np
from scipy.integrate import solve_ivp

from motofmi.recordings.recording import Recording


def swing(
    name: str,
    released: float,
    duration: float,
    rate: float,
    values: dict[str, float],
    eccentricity: float = 0.0,
    noise: float = 1e-4,
    seed: int = 0,
) -> Recording:
    """The angle [rad] of a release at `released` rad, over so many seconds at so many samples per second.

    values are J, k, c, T_c and c_2 in SI units. The sensor has white noise (standard deviation, rad) and an error that
    repeats with every turn, eccentricity times sin(9 q) [rad].
    """
    time = np.arange(0, duration, 1 / rate)
    angle = np.full(len(time), np.nan)
    J, k, c, friction, drag = (values[n] for n in ("J", "k", "c", "T_c", "c_2"))
    begin, q = 0.0, released
    while begin < time[-1]:
        if abs(k * q) <= friction:
            angle[time >= begin] = q
            break
        sign = -np.sign(q)

        def motion(t, x, sign=sign):
            return [x[1], (-k * x[0] - c * x[1] - friction * sign - drag * abs(x[1]) * x[1]) / J]

        def turns(t, x, sign=sign):
            return x[1] * sign

        turns.terminal, turns.direction = True, -1
        half = solve_ivp(motion, (begin, duration), [q, 0.0], "DOP853", dense_output=True, events=turns, rtol=1e-9, atol=1e-10)
        here = (time >= begin) & (time <= half.t[-1])
        angle[here] = half.sol(time[here])[0]
        begin, q = float(half.t[-1]), float(half.y[0, -1])
    recorded = angle + eccentricity * np.sin(9 * angle) + noise * np.random.default_rng(seed).standard_normal(len(time))
    return Recording(name, time, {"angle": recorded}, {"angle": "rad"})
