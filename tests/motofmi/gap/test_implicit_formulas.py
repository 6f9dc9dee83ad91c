"""The implicit formulas of simulations against exact solutions: a damped oscillation, a fast decay, a sudden force."""

import numpy as np
import pytest

from fmus.mechanisms import MassSpringDamper
from motofmi.gap.models.collocation import Motion, inner_times
from motofmi.gap.models.equations import Equations
from motofmi.gap.models.implicit_formulas import HERMITE_SIMPSON, RADAU, formula_for
from motofmi.gap.models.simulation import simulate

FREQUENCY, DECAY = 20.0, 2.0  # rad/s, 1/s


def states(formula, steps, duration, initial, force=0.0, **values):
    """The states (n, 2) of a mass of 1 kg under a constant force."""
    mass = MassSpringDamper().with_values(mass=1.0, **values)
    equations = Equations(mass, ["displacement"], [])
    time = np.linspace(0, duration, steps + 1)
    at, between = ({"force": np.full(len(t), force)} for t in (time, inner_times(time, formula)))
    motion = Motion(time, at, between, formula=formula)
    start = np.repeat(np.array([initial]), len(time), axis=0)
    return simulate(equations, mass.start_values(), motion, start, np.array(initial)).states


@pytest.mark.parametrize(("formula", "order"), [(HERMITE_SIMPSON, 4), (RADAU, 3)])
def test_errors_fall_with_the_order_of_the_formula(formula, order):
    """x = exp(-d t) (cos w t + d / w sin w t), for m = 1, c = 2 d, k = w^2 + d^2."""
    spring = {"spring_stiffness": FREQUENCY**2 + DECAY**2, "spring_damping": 2 * DECAY}
    exact = np.exp(-DECAY) * (np.cos(FREQUENCY) + DECAY / FREQUENCY * np.sin(FREQUENCY))
    errors = [abs(states(formula, n, 1.0, [1.0, 0.0], **spring)[-1, 0] - exact) for n in (800, 1600)]
    # 0.05: terms of the next order at steps of 1/40 rad
    assert np.log2(errors[0] / errors[1]) == pytest.approx(order, abs=0.05)


def test_a_fast_decay_ends_only_with_the_formula_of_radau():
    """x' = v, v' = -c v with h c = 1000: after a step the exact rate is e^-1000; |R| is 0.99 and 0.002."""
    damped = {"spring_stiffness": 0.0, "spring_damping": 1e5}
    after = {f: states(f, 10, 0.1, [0.0, 1.0], **damped)[1, 1] for f in (HERMITE_SIMPSON, RADAU)}
    assert abs(after[HERMITE_SIMPSON]) > 0.9 and abs(after[RADAU]) < 0.01


def test_an_overdamped_mass_follows_a_force_at_once_with_the_formula_of_radau():
    """A constant force on a mass at rest with h c / m = 100: the rate is F / c from the first step on."""
    damped = {"spring_stiffness": 0.0, "spring_damping": 1e4}
    rates = {f: states(f, 10, 0.1, [0.0, 0.0], 1.0, **damped)[1:, 1] * 1e4 for f in (HERMITE_SIMPSON, RADAU)}
    assert rates[RADAU] == pytest.approx(1.0, rel=0.05) and rates[HERMITE_SIMPSON][0] < 0.2


def test_the_formula_follows_the_decay_of_rates_only():
    slopes = {(0, 1): 1.0, (1, 1): -2000.0, (2, 2): -1e6}
    assert formula_for(slopes, [1], 0.01) is RADAU
    assert formula_for(slopes, [1], 0.001) is HERMITE_SIMPSON
    assert formula_for(slopes, [], 0.01) is HERMITE_SIMPSON
