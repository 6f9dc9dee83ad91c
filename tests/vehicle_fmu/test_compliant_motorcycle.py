"""Sharp's motorcycle of 1994 against Kane's equations, its rigid limit, conservation of energy, and its names of modes."""

import csv
import re
from math import cos, sin

import numpy as np
import pytest
from scipy.linalg import expm

from fmus import linearise
from fmus.expressions.functions import NUMERIC
from motofmi.workflows import components
from rider_fmu import riders
from tests import ROOT
from tests.truth import compliant_motorcycle_by_kane, eigenvalues_by_kane
from vehicle_fmu import MODES, Motorcycle, modes, motorcycles, over_speed, ridden

SHARP = motorcycles.load("sharp_1994")
HANDS = {"hands off": 0.0, "hands on": 1.0}
TWENTY_SPEEDS = np.linspace(4.0, 80.0, 20)  # m/s

# The symbols of the published parameter file.
SYMBOLS = {
    "Mf": "front_mass", "Mr": "frame_mass", "Mb": "assembly_mass", "Mp": "upper_body_mass", "Ifx": "front_cross_inertia",
    "Ifz_hands_on": "hands_steer_inertia", "Ifz_hands_off": "front_steer_inertia", "Ifxz": "front_product_of_inertia",
    "Irx": "frame_roll_inertia", "Irz": "frame_yaw_inertia", "Irxz": "frame_product_of_inertia", "Ipx": "upper_body_roll_inertia",
    "Ipz": "upper_body_yaw_inertia", "Ipxz": "upper_body_product_of_inertia", "irwx": "assembly_inertia",
    "irwy": "rear_spin_inertia", "ifwy": "front_spin_inertia", "iry": "engine_spin_inertia", "aa": "rear_twist_distance",
    "bb": "rear_contact_distance", "bb_b": "assembly_mass_distance", "bb_p": "upper_body_distance", "ee": "front_mass_offset",
    "hh": "frame_mass_height", "hh_b": "assembly_mass_height", "hh_p": "upper_body_rise", "hh_s": "upper_body_joint_height",
    "jj": "front_mass_height", "ll": "front_contact_distance", "Rf": "front_wheel_radius", "Rr": "rear_wheel_radius",
    "ss": "head_height", "trail": "trail", "epsilon": "caster_angle", "epsilon1": "rear_twist_angle",
    "hh_cp": "pressure_height", "k_v": "head_lateral_stiffness", "D_v": "head_lateral_damping",
    "k_lamda": "assembly_twist_stiffness", "D_lamda": "assembly_twist_damping", "k_gamma": "head_twist_stiffness",
    "D_gamma": "head_twist_damping", "k_zita": "upper_body_stiffness", "D_zita": "upper_body_damping",
    "k_steer_hands_on": "hands_steering_stiffness", "D_steer_hands_on": "hands_steering_damping",
    "k_steer_hands_off": "steering_stiffness", "D_steer_hands_off": "steering_damping", "Crr1": "rolling_resistance",
    "Crr2": "rolling_resistance_rise", "Dc": "drag", "Lc": "lift", "g": "gravity",
}  # fmt: skip
READINGS = {"epsilon_I": "front_inertia_inclination", "epsilon_t": "rear_twist_inclination",
            "eta": "head_twist_inclination", "share": "moment_relaxes"}  # fmt: skip
SIGNALS = {
    "v": "lateral_velocity", "r": "yaw_rate", "p": "roll_rate", "dd": "head_slide_rate", "b": "head_twist_rate",
    "s": "steer_rate", "q": "assembly_twist_rate", "w": "upper_body_rate", "phi": "roll_angle", "d": "head_slide",
    "gamma": "head_twist", "delta": "steer_angle", "lamda": "assembly_twist", "zeta": "upper_body_angle",
    "Y_f": "front_side_force", "Y_r": "rear_side_force", "M_f": "front_relaxed_moment", "M_r": "rear_relaxed_moment",
    "T_h": "handlebar_torque", "T_f": "frame_torque", "T_d": "steer_torque", "T_phi": "roll_torque", "F": "lateral_force",
}  # fmt: skip
TYRES = {"Cfv{}": "cornering_stiffness", "C{}1": "camber_stiffness", "Cmv{}": "aligning_stiffness",
         "C{}2": "camber_moment_stiffness", "C{}3": "overturning_stiffness", "sigma{}": "relaxation_length"}  # fmt: skip


def at_speed(motorcycle, speed):
    """The locals of the equations at a speed."""
    return motorcycle.run({**motorcycle.start_values(), "speed": speed}, NUMERIC)


@pytest.fixture(scope="module")
def published():
    """The rows of the published parameter file by symbol."""
    path = ROOT.parent / "shared" / "data" / "vehicles" / "sharp_1994.csv"
    if not path.exists():
        pytest.skip(f"{path} is absent")
    with path.open(encoding="utf-8") as file:
        return {row["symbol"]: row["value"] for row in csv.DictReader(file)}


def test_the_values_are_the_published_ones(published):
    assert {s: SHARP.values[n] for s, n in SYMBOLS.items()} == {s: float(published[s]) for s in SYMBOLS}


@pytest.mark.parametrize("speed", [1.0, 30.0, 70.0])
def test_loads_and_tyre_coefficients_are_those_of_the_published_formulas(published, speed):
    names = {s: float(x) for s, x in published.items() if re.fullmatch(r"[-+.\de]+", x)}
    names |= {"V": speed, "cos": cos, "sin": sin, "wheelbase": names["bb"] + names["ll"]}
    names["kk"] = names["ll"] + (names["ee"] + names["trail"] - names["jj"] * sin(names["epsilon"])) / cos(names["epsilon"])
    computed = at_speed(SHARP, speed)
    words = {"Cornering": "cornering_stiffness", "Camber": "camber_stiffness", "Aligning": "aligning_stiffness",
             "Aligning_camber": "camber_moment_stiffness", "Overturning": "overturning_stiffness", "relaxation": "relaxation_length"}
    for symbol, name in [("Zf", "front_load"), ("Zr", "rear_load"),
                         *((f"{word}_{end[0]}", f"{end}_{n}") for word, n in words.items() for end in ("front", "rear"))]:  # fmt: skip
        names[symbol] = eval(published[symbol].replace("^", "**"), {}, names)
        assert computed[name] == pytest.approx(names[symbol], rel=1e-12), symbol


def test_bodies_are_possible_and_loads_positive():
    v = SHARP.values
    for body, upright in [("frame", "frame_yaw_inertia"), ("upper_body", "upper_body_yaw_inertia")]:
        assert v[f"{body}_roll_inertia"] * v[upright] > v[f"{body}_product_of_inertia"] ** 2, body
    for speed in TWENTY_SPEEDS:
        computed = at_speed(SHARP, speed)
        assert min(computed["front_load"], computed["rear_load"]) > 0


# A second derivation ------------------------------------------------------------------------------


@pytest.fixture(scope="module")
def kane():
    return compliant_motorcycle_by_kane.derive()


def arguments(motorcycle, speed):
    """The values of the second derivation's parameters."""
    v, computed = motorcycle.values, at_speed(motorcycle, speed)

    def steer(off, on):
        return v[off] + v["hands_on"] * (v[on] - v[off])

    names = {s: v[n] for s, n in {**SYMBOLS, **READINGS}.items()}
    names |= {"V": speed, "Ifz": steer("front_steer_inertia", "hands_steer_inertia"),
              "k_steer": steer("steering_stiffness", "hands_steering_stiffness"),
              "D_steer": steer("steering_damping", "hands_steering_damping"), "lift": v["lift"] * speed**2,
              "drag": v["longitudinal_forces"] * v["drag"] * speed**2,
              "resistance": v["longitudinal_forces"] * computed["front_load"]
                            * (v["rolling_resistance"] + v["rolling_resistance_rise"] * speed**2)}  # fmt: skip
    for end in ("front", "rear"):
        names |= {s.format(end[0]): computed[f"{end}_{n}"] for s, n in TYRES.items()}
        names[f"Z{end[0]}"] = computed[f"{end}_load"]
    return [names[str(p)] for p in compliant_motorcycle_by_kane.PARAMETERS]


@pytest.mark.parametrize("hands", HANDS)
def test_eigenvalues_are_those_of_kanes_equations_at_twenty_speeds(hands):
    speeds, expected = eigenvalues_by_kane.stored(f"sharp_1994, {hands}")
    space = linearise(SHARP.with_values(hands_on=HANDS[hands]), speed=speeds)
    for wanted, found in zip(expected, np.linalg.eigvals(space.A), strict=True):
        # Rounding of two eigensolutions; 1e-3 is asked for.
        assert max(np.abs(found - w).min() / abs(w) for w in wanted) < 1e-8


@pytest.mark.study
@pytest.mark.parametrize("hands", HANDS)
def test_the_stored_eigenvalues_are_those_of_kanes_equations(kane, hands):
    motorcycle = SHARP.with_values(hands_on=HANDS[hands])
    speeds, stored = eigenvalues_by_kane.stored(f"sharp_1994, {hands}")
    for speed, eigenvalues in zip(speeds, stored, strict=True):
        matrices = compliant_motorcycle_by_kane.linearised(kane, arguments(motorcycle, speed))
        wanted = np.linalg.eigvals(matrices[:, : len(motorcycle.states)])
        assert max(np.abs(eigenvalues - w).min() / abs(w) for w in wanted) < 1e-8


@pytest.mark.study
@pytest.mark.parametrize("seed", range(20))
def test_kanes_equations_give_the_same_matrices_with_every_value_changed(kane, seed):
    generator = np.random.default_rng(seed)
    changed = {n: np.clip(x * generator.uniform(0.6, 1.4), SHARP.table[n].min, SHARP.table[n].max)
               for n, x in SHARP.values.items()}  # fmt: skip
    changed |= {"hands_on": generator.uniform(), "front_product_of_inertia": generator.uniform(-0.1, 0.1)}
    skewed = SHARP.with_values(**changed)
    normal = skewed.with_values(head_twist_inclination=changed["caster_angle"])
    for motorcycle, inputs in [(normal, compliant_motorcycle_by_kane.INPUTS), (skewed, ())]:
        speed = generator.uniform(3, 80)
        expected = compliant_motorcycle_by_kane.linearised(kane, arguments(motorcycle, speed))
        space = linearise(motorcycle, speed=speed)
        states = [space.states.index(SIGNALS[n]) for n in compliant_motorcycle_by_kane.STATES]
        columns = [space.inputs.index(SIGNALS[n]) for n in inputs]
        computed = np.hstack([space.A[np.ix_(states, states)], space.B[np.ix_(states, columns)]])
        expected = expected[:, : computed.shape[1]]
        # Against the largest entry of each row, whose terms cancel to rounding where an entry is small.
        assert (np.abs(computed - expected) <= 1e-9 * np.abs(expected).max(axis=1, keepdims=True)).all()


# The rigid limit ----------------------------------------------------------------------------------

PLAIN_TYRES = {f"{end}_{name}_{power}": 0.0 for end in ("front", "rear") for power in range(5)
               for name in ("cornering_stiffness", "camber_stiffness", "aligning_stiffness", "camber_moment_stiffness",
                            "overturning_stiffness", "relaxation_length")
               if f"{end}_{name}_{power}" in SHARP.values}  # fmt: skip
STIFFNESSES = ("head_lateral_stiffness", "head_twist_stiffness", "assembly_twist_stiffness", "upper_body_stiffness")
SPRING_DAMPERS = ("head_lateral_damping", "head_twist_damping", "assembly_twist_damping", "upper_body_damping")


def stiff(factor):
    """The motorcycle with tyres as in 1971 and with that factor on its stiffnesses."""
    values = {n: factor * SHARP.values[n] for n in STIFFNESSES} | dict.fromkeys(SPRING_DAMPERS, 0.0)
    return SHARP.with_values(**{**PLAIN_TYRES, **values, **SIMPLE})


SIMPLE = {"front_cornering_stiffness_0": 2e4, "front_camber_stiffness_0": 1.2e3, "rear_cornering_stiffness_0": 2.5e4,
          "rear_camber_stiffness_0": 1.5e3, "front_relaxation_length_0": 0.2, "rear_relaxation_length_0": 0.25,
          "longitudinal_forces": 0.0, "drag": 0.0, "lift": 0.0}  # fmt: skip


def rigid():
    """The motorcycle of 1971 with the same bodies: rear frame, wheel assembly and upper body as one."""
    v, c, S = SHARP.values, cos(SHARP.values["caster_angle"]), sin(SHARP.values["caster_angle"])
    places = [(v["frame_mass"], 0.0, v["frame_mass_height"]),
              (v["assembly_mass"], -v["assembly_mass_distance"], v["assembly_mass_height"]),
              (v["upper_body_mass"], -v["upper_body_distance"], v["upper_body_joint_height"] + v["upper_body_rise"])]  # fmt: skip
    mass, x, height = (np.array(column) for column in zip(*places, strict=True))
    X, H = x @ mass / mass.sum(), height @ mass / mass.sum()
    own = ("frame_{}_inertia", "upper_body_{}_inertia")
    foot = v["front_contact_distance"] + v["trail"] / c - X  # steer axis on the ground, ahead of the common mass centre
    front_x = v["front_contact_distance"] + (v["front_mass_offset"] + v["trail"] - v["front_mass_height"] * S) / c - X
    load = at_speed(stiff(1.0), 30.0)["front_load"]
    return Motorcycle(
        front_mass=v["front_mass"], rear_mass=mass.sum(), front_tyre_load=-load,
        rear_roll_inertia=sum(v[n.format("roll")] for n in own) + v["assembly_inertia"] + mass @ (height - H) ** 2,
        rear_yaw_inertia=sum(v[n.format("yaw")] for n in own) + v["assembly_inertia"] + mass @ (x - X) ** 2,
        rear_product_of_inertia=v["frame_product_of_inertia"] + v["upper_body_product_of_inertia"] - mass @ ((x - X) * (height - H)),
        front_cross_inertia=v["front_cross_inertia"], front_steer_inertia=v["front_steer_inertia"],
        front_spin_inertia=v["front_spin_inertia"], rear_spin_inertia=v["rear_spin_inertia"] + v["engine_spin_inertia"],
        front_wheel_radius=v["front_wheel_radius"], rear_wheel_radius=v["rear_wheel_radius"], steer_axis_distance=foot * c,
        rear_contact_distance=v["rear_contact_distance"] + X, front_mass_offset=v["front_mass_offset"],
        front_mass_rise=v["front_mass_height"] * c - front_x * S, rear_mass_height=H, trail=v["trail"],
        caster_angle=v["caster_angle"], front_cornering_stiffness=SIMPLE["front_cornering_stiffness_0"],
        front_camber_stiffness=SIMPLE["front_camber_stiffness_0"], rear_cornering_stiffness=SIMPLE["rear_cornering_stiffness_0"],
        rear_camber_stiffness=SIMPLE["rear_camber_stiffness_0"], front_relaxation_length=SIMPLE["front_relaxation_length_0"],
        rear_relaxation_length=SIMPLE["rear_relaxation_length_0"], steering_damping=v["steering_damping"], gravity=v["gravity"],
    )  # fmt: skip


@pytest.mark.parametrize("speed", [5.0, 20.0, 50.0])
def test_stiff_frames_give_the_motorcycle_of_1971(speed):
    wanted = np.linalg.eigvals(linearise(rigid(), speed=speed).A)
    wanted = wanted[np.abs(wanted) > 1e-6]
    errors = []
    for factor in (1e3, 1e4, 1e5):
        found = np.linalg.eigvals(linearise(stiff(factor), speed=speed).A)
        errors.append(max(np.abs(found - w).min() / abs(w) for w in wanted))
    assert errors[-1] < 1e-5
    # The error falls as 1/k: a tenth for ten times the stiffness, with terms in 1/k^2 far below these bounds.
    assert np.divide(errors[1:], errors[:-1]) == pytest.approx(0.1, rel=0.02)


# Energy and symmetry ------------------------------------------------------------------------------


def test_without_tyres_and_dampers_energy_is_conserved():
    """Kinetic energy of the motion beside V, elastic energy and that of weights and loads, over one second."""
    free = dict.fromkeys((*PLAIN_TYRES, *SPRING_DAMPERS, "steering_damping", "longitudinal_forces"), 0.0)
    motorcycle = SHARP.with_values(**{**free, "front_relaxation_length_0": 0.2, "rear_relaxation_length_0": 0.2})
    speed, space = 25.0, linearise(motorcycle, speed=25.0)
    names = [SIGNALS[n] for n in compliant_motorcycle_by_kane.STATES]
    rates, angles = ([space.states.index(n) for n in each] for each in (names[:8], names[8:14]))
    entries = motorcycle.mass_entries({**motorcycle.start_values(), "speed": speed}, NUMERIC)
    mass = np.array([[entries[a, b] for b in names[:8]] for a in names[:8]])
    stiffness = -(mass @ space.A[np.ix_(rates, angles)])[2:]
    assert np.abs(stiffness - stiffness.T).max() < 1e-9 * np.abs(stiffness).max()  # forces with a potential
    state = np.zeros(18)
    state[rates] = 0.1 * np.random.default_rng(1).normal(size=8)
    heading = np.zeros((1, 18))
    heading[0, rates[1]] = 1.0  # the heading is the integral of the yaw rate
    over_one_step = expm(1e-3 * np.block([[space.A, np.zeros((18, 1))], [heading, np.zeros((1, 1))]]))
    state, energies = np.append(state, 0.0), []
    for _ in range(1000):
        motion, elastic = state[rates], state[angles]
        motion[0] += speed * state[18]  # lateral velocity along a fixed direction
        energies.append(motion @ mass @ motion / 2 + elastic @ stiffness @ elastic / 2)
        state = over_one_step @ state
    assert np.ptp(energies) < 1e-9 * np.mean(energies)  # rounding


def test_left_and_right_are_alike():
    generator = np.random.default_rng(0)
    state, inputs = generator.normal(size=18), generator.normal(size=len(SHARP.inputs))
    mirrored = np.where(np.array(SHARP.inputs) == "speed", inputs, -inputs)
    inputs[SHARP.inputs.index("speed")] = mirrored[SHARP.inputs.index("speed")] = 25.0
    for left, right in zip(SHARP.derivatives(state, inputs), SHARP.derivatives(-state, mirrored), strict=True):
        assert left == pytest.approx(-right, rel=1e-12)


# Hands and riders ---------------------------------------------------------------------------------


def test_a_riders_share_of_the_steer_inertia_is_that_of_the_hands():
    """0.2 kg.m2 by the switch and at the port are the same, wherever the inertia appears."""
    share = SHARP.values["hands_steer_inertia"] - SHARP.values["front_steer_inertia"]
    steer = {"hands_steering_stiffness": 0.0, "hands_steering_damping": SHARP.values["steering_damping"]}
    by_switch = linearise(SHARP.with_values(hands_on=1.0, **steer), speed=30.0).A
    at_the_port = linearise(SHARP.with_values(added_steer_inertia=share), speed=30.0).A
    assert np.abs(by_switch - at_the_port).max() < 1e-12 * np.abs(by_switch).max()


# Names of modes -----------------------------------------------------------------------------------

SPEEDS = np.arange(1.0, 70.5, 0.5)
RIDERS = ["none", *(f"rider:{n}" for n in riders.names() if riders.contents(n)["component"] == "PassiveRider")]


@pytest.mark.slow
@pytest.mark.parametrize("device", RIDERS)
def test_every_name_is_one_eigenvalue_in_the_band_of_its_mode(device):
    found = modes(over_speed(ridden(SHARP, components.device(device))), SPEEDS)
    frequency = {mode: found[mode].frequency for mode in MODES}
    assert ("rider_wobble" in found.unstable) == (device != "none")
    for k in range(len(SPEEDS)):
        present = [mode for mode in found.unstable if not np.isnan(found[mode].eigenvalue[k])]
        places = [int(np.argmin(np.abs(found.eigenvalues[k] - found[mode].eigenvalue[k]))) for mode in present]
        assert len(set(places)) == len(places), SPEEDS[k]
    assert (frequency["capsize"] == 0).all()
    assert (frequency["weave"] < 4.5).all()  # the usual band, with a rider on compliant frames at 70 m/s
    assert (frequency["weave"][SPEEDS < 20] < 1.5).all()  # below the veering with rear wobble
    assert (frequency["rear_wobble"] < 6.5).all()
    unstable = [mode for mode, bands in found.unstable.items() if bands]
    assert set(unstable) <= {"weave", "capsize"}  # topples at low speed, weaves at high speed
    if device == "none":
        assert ((frequency["wobble"] > 6) & (frequency["wobble"] < 9)).all()


@pytest.mark.slow
def test_hands_and_rider_calm_wobble_and_unsettle_weave():
    """2011, Sect. 5, on another motorcycle; Sharp's hands do the same."""
    off = modes(over_speed(ridden(SHARP)), SPEEDS)
    for other in (ridden(SHARP.with_values(hands_on=1.0)), ridden(SHARP, riders.load("mean_2011"))):
        found = modes(over_speed(other), SPEEDS)
        low, high = SPEEDS < 50, SPEEDS > 40
        assert (found["wobble"].eigenvalue.real < off["wobble"].eigenvalue.real)[low].all()
        assert (found["weave"].eigenvalue.real > off["weave"].eigenvalue.real)[high].all()
