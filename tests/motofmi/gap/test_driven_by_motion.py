"""A mass on a spring and a damper whose foot is moved: no input is a force, and laws act per unit of mass."""

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import motofmi as mf
from fmus import Component, input, parameter, state
from motofmi.recordings.recording import Recording
from tests.few_laws import FAMILIES, only_families

NOISE = 1e-5  # m


class Isolator(Component):
    """A mass on a spring and a damper whose foot is moved."""

    stiffness = parameter("1/s2", "Stiffness over mass", min=0, start=300.0)
    damping = parameter("1/s", "Damping over mass", min=0, start=3.0)
    foot = input("m", "Displacement of the foot")
    position = state("m", "Displacement of the mass", exposed=True)
    velocity = state("m/s", "Velocity of the mass")

    def equations(self, v, m):
        pull = v.stiffness * (v.foot - v.position) - v.damping * v.velocity
        return {"der(position)": v.velocity, "der(velocity)": pull}


def recorded(seed, friction=0.0, drag=0.0):
    """40 s of the mass with 400 1/s2 and 4 1/s, friction [N/kg] and drag [N.s2/m2 per kg], by a variable-step solver."""
    rng, time = np.random.default_rng(seed), np.arange(0, 40, 0.01)
    frequency, phase = 2 * np.pi * rng.uniform(0.3, 5, 12), rng.uniform(0, 2 * np.pi, 12)
    size = 0.02 * rng.uniform(0.5, 1, 12)

    def foot(t):
        return np.sin(np.multiply.outer(t, frequency) + phase) @ size

    def change(t, x):
        resistance = friction * np.tanh(x[1] / 1e-3) + drag * x[1] * abs(x[1])
        return [x[1], 400 * (foot(t) - x[0]) - 4 * x[1] - resistance]

    made = solve_ivp(change, (0, 40), [0, 0], t_eval=time, max_step=0.01, rtol=1e-8, atol=1e-10, method="LSODA").y[0]
    columns = {"foot": foot(time), "position": made + NOISE * rng.standard_normal(len(time))}
    return Recording(f"run_{seed}", time, columns, {"foot": "m", "position": "m"})


def found(**hidden):
    return mf.find_gap([recorded(1, **hidden)], validation=[recorded(2, **hidden)], component=Isolator())


@pytest.mark.slow
@pytest.mark.parametrize(
    ("hidden", "family", "name", "unit"),
    [
        ({"drag": 3.0}, "progressive_damping", "coefficient", "N.s2/m2.kg"),
        pytest.param({"friction": 2.0}, "coulomb_friction", "friction_torque", "N/kg", marks=pytest.mark.study),
    ],
)
def test_what_a_mass_that_a_motion_drives_lacks_is_named_per_unit_of_mass(monkeypatch, hidden, family, name, unit):
    only_families(monkeypatch, (*FAMILIES, "damping_asymmetry"))
    (effect,) = (result := found(**hidden)).effects
    assert (result.verdict, effect["name"], effect["parameters"][name]["unit"]) == ("named", family, unit)
    (true,), value = hidden.values(), effect["parameters"][name]
    # four standard errors, and 1e-3 of the value: between its samples the foot is interpolated
    assert value["value"] == pytest.approx(true, abs=4 * value["standard_error"] + 1e-3 * true)


@pytest.mark.study
def test_nothing_is_named_where_the_mass_that_a_motion_drives_lacks_nothing():
    assert found().verdict == "none"
