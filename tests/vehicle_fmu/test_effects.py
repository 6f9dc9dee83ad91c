"""The vehicle's effects against a second derivation, limits that everybody knows, and the commands that take them."""

from pathlib import Path

import numpy as np
import pytest

import vehicle_fmu.effects
from fmus import linearise
from fmus.effects import effects_in
from fmus.effects.library import applicable_effects
from motofmi.workflows import components
from tests.simulators.hidden_vehicle import kane
from tests.truth import flexible_motorcycle_by_kane
from tests.vehicle_fmu.test_motorcycle import KANE_NAMES, random_motorcycle
from vehicle_fmu import modes, motorcycles, over_speed, ridden
from vehicle_fmu.effects.frame_compliance import FrameCompliance
from vehicle_fmu.effects.rider_lean import RiderLean

NAMES = {
    **KANE_NAMES,
    **{symbol: f"frame_compliance.{n}" for symbol, n in {"C": "compliance", "d": "damping", "z_t": "height"}.items()},
    **{
        symbol: f"rider_lean.{n}"
        for symbol, n in {
            "m_u": "mass",
            "rho": "gyration",
            "h_s": "hinge_height",
            "c_r": "centre",
            "x_r": "advance",
        }.items()
    },
}
SIGNALS = {
    "v": "lateral_velocity", "r": "yaw_rate", "p": "roll_rate", "s": "steer_rate", "phi": "roll_angle", "delta": "steer_angle",
    "Y_f": "front_side_force", "Y_r": "rear_side_force", "b": "frame_compliance.twist_rate", "beta": "frame_compliance.twist",
    "q": "rider_lean.lean_rate", "theta": "rider_lean.lean",
}  # fmt: skip


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(30))
def test_kanes_equations_of_twist_and_lean_give_the_same_matrices(seed):
    generator = np.random.default_rng(seed)
    rigid = random_motorcycle(generator).with_values(added_steer_inertia=0.0)
    motorcycle = rigid.with_effects(FrameCompliance(), RiderLean()).with_values(**{
        "frame_compliance.compliance": generator.uniform(1e-6, 1e-3), "frame_compliance.height": generator.uniform(-0.5, 1),
        "frame_compliance.damping": generator.uniform(0, 100), "rider_lean.mass": generator.uniform(0, 60),
        "rider_lean.frequency": generator.uniform(0.5, 10), "rider_lean.advance": generator.uniform(-0.5, 0.5)})  # fmt: skip
    values, speed = motorcycle.values, generator.uniform(1, 80)
    inertia = values["rider_lean.mass"] * (values["rider_lean.gyration"] ** 2 + values["rider_lean.centre"] ** 2)
    w = 2 * np.pi * values["rider_lean.frequency"]
    others = {"V": speed, "k_u": inertia * w**2, "d_u": 2 * inertia * values["rider_lean.damping_ratio"] * w}
    arguments = [
        others[str(p)] if str(p) in others else values[NAMES[str(p)]] for p in flexible_motorcycle_by_kane.PARAMETERS
    ]
    mass, slopes = (matrix(*arguments) for matrix in kane())
    expected = np.linalg.solve(mass, slopes)
    space = linearise(motorcycle, speed=speed)
    places = [space.states.index(SIGNALS[n]) for n in flexible_motorcycle_by_kane.STATES]
    # Against the largest entry of each row, whose terms cancel to rounding where an entry is small.
    scale = np.abs(expected).max(axis=1, keepdims=True)
    assert (np.abs(space.A[np.ix_(places, places)] - expected) <= 1e-9 * scale).all()


@pytest.mark.slow
def test_a_stiff_head_and_a_light_body_change_nothing():
    rigid = motorcycles.load("sharp_1971")
    flexible = rigid.with_effects(FrameCompliance(), RiderLean()).with_values(
        **{"frame_compliance.compliance": 1e-8, "rider_lean.mass": 0.0}
    )
    space = linearise(flexible, speed=30.0)
    known = [
        np.abs(np.linalg.eigvals(space.A) - x).min() / abs(x)
        for x in np.linalg.eigvals(linearise(rigid, speed=30.0).A)
        if abs(x) > 1e-6
    ]
    assert max(known) < 1e-3  # the twist of 1e-8 rad/(N.m) is left


def test_a_bicycle_takes_the_effects_for_which_it_has_words():
    families = {
        e.family for e in applicable_effects(motorcycles.load("benchmark_bicycle"), effects_in(vehicle_fmu.effects))
    }
    assert families == {
        "coulomb_friction",
        "steer_damping",
        "steer_stiffness",
        "added_inertia",
        "roll_inertia",
        "channel_delay",
        "motor_gain",
    }


@pytest.mark.slow
def test_a_vehicle_with_effects_is_a_file_that_every_command_takes(tmp_path):
    file = tmp_path / "twisting.toml"
    text = (Path(vehicle_fmu.__file__).parent / "motorcycles" / "sharp_1971.toml").read_text("utf-8")
    values = '[parameters]\n"frame_compliance.compliance" = 3e-5\n"frame_compliance.damping" = 20.0\n'
    file.write_text(
        text.replace("[parameters]\n", values).replace(
            "description", 'effects = ["frame_compliance.twist"]\ndescription', 1
        ),
        "utf-8",
    )
    twisting = components.vehicle(str(file))
    rigid, soft = (
        modes(over_speed(ridden(m)), np.array([20.0, 50.0]))["wobble"]
        for m in (motorcycles.load("sharp_1971"), twisting)
    )
    # A front frame that twists lowers the frequency of wobble and takes from its damping at moderate speed (Spierings
    # 1981).
    assert (soft.frequency < rigid.frequency).all()
