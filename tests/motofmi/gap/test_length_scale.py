"""A spring with hysteresis in motions of micrometres and of kilometres: the effect named does not depend on the scale.

    q'' + 2 z q' + q = u - F h,   w h' = q' - |q'| h,   2 z = 0.1, F = 0.8, w = 0.5                    (Dahl's model)

in the time in which the mass has the natural frequency 1, integrated with an explicit Runge-Kutta method of order 5(4).
"""

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import motofmi as mf
from motofmi.recordings.recording import Recording
from tests.few_laws import only_families

STIFFNESS, FREQUENCY = 1e4, 2 * np.pi * 5  # N/m, rad/s


def record(seed: int, length: float, samples: int = 1600) -> Recording:
    """A mass under a multisine, with sensor noise of 1 %; its displacement is in units of `length` [m]."""
    rng, step = np.random.default_rng(seed), 2 * np.pi / 40
    lines, phases = np.linspace(0.1, 2.5, 60), rng.uniform(0, 2 * np.pi, 60)

    def force(t):
        return 2 * np.cos(np.outer(np.atleast_1d(t), lines) + phases).sum(1) / np.sqrt(30)

    def rates(t, x):
        return [x[1], force(t)[0] - x[0] - 0.1 * x[1] - 0.8 * x[2], (x[1] - abs(x[1]) * x[2]) / 0.5]

    time = np.arange(samples) * step
    found = solve_ivp(rates, (0, time[-1]), [0, 0, 0], t_eval=time, rtol=1e-8, atol=1e-9).y[0]
    noisy = found + 1e-2 * found.std() * rng.standard_normal(samples)
    columns = {"force": STIFFNESS * length * force(time), "displacement": length * noisy}
    return Recording(f"run_{seed}", time / FREQUENCY, columns, {"force": "N", "displacement": "m"})


@pytest.mark.slow
@pytest.mark.parametrize("length", [1e-6, 1e3])
def test_hysteresis_is_named_at_any_scale_of_length(length, monkeypatch):
    """With widths of at least a micrometre, friction and a delay were named in a motion of micrometres."""
    only_families(monkeypatch, ("hysteresis", "channel_delay", "coulomb_friction"))
    found = mf.find_gap(
        record(1, length), validation=record(2, length), component=mf.mechanism("mass_spring_damper", mass=10.0)
    )
    (effect,) = found.effects
    assert (effect["name"], effect["form"]) == ("hysteresis", "dahl")
    force, width = (effect["parameters"][name] for name in ("force", "width"))
    assert force["value"] == pytest.approx(0.8 * STIFFNESS * length, abs=4 * force["standard_error"])
    assert width["value"] == pytest.approx(0.5 * length, abs=4 * width["standard_error"])
    assert width["standard_error"] < 0.02 * width["value"]
