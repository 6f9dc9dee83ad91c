"""The names of the modes: against an independent tracker, for every published rider, on any grid of speeds."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.optimize import brentq, linear_sum_assignment

from fmus import InputError
from motofmi.workflows import components
from rider_fmu import riders
from rider_fmu.effects.head import Reflex
from vehicle_fmu import MODES, modes, motorcycles, over_speed, ridden

RIDERS = [n for n in riders.names() if riders.contents(n)["component"] == "PassiveRider"]
SPEEDS = np.arange(1.0, 60.25, 0.25)  # m/s
DEVICES = ["none", "rider:mean_2011", "damper:7.5"]


def linearised(device, vehicle="sharp_1971"):
    return over_speed(ridden(motorcycles.load(vehicle), components.device(device)))


# An independent tracker ---------------------------------------------------------------------------


def track(linearised_at):
    """Branches (n, nx) from 60 down to 1 m/s in steps of 5 mm/s, each matched to where its last two values point."""
    speeds = np.round(np.arange(60.0, 0.9975, -0.005), 6)
    spectra = np.linalg.eigvals(linearised_at(speeds).A).astype(complex)
    branches = spectra.copy()
    for k in range(1, len(speeds)):
        expected = 2 * branches[k - 1] - branches[k - 2] if k > 1 else branches[0]
        branches[k] = spectra[k, linear_sum_assignment(np.abs(expected[:, None] - spectra[k]))[1]]
    return speeds, branches


def side_force_ratio(linearised_at, speed, eigenvalue):
    """|Y_r / Y_f| in the mode with that eigenvalue."""
    space = linearised_at(np.array([speed]))
    values, vectors = np.linalg.eig(space.A[0])
    shape = vectors[:, np.argmin(np.abs(values - eigenvalue))]
    rear, front = (abs(shape[space.states.index(f"vehicle.{end}_side_force")]) for end in ("rear", "front"))
    return rear / front


def named_by_tracking(linearised_at):
    """Speeds and a dict of eigenvalue curves: names at 60 m/s by frequency, then by continuation.

    Below the birth of rear wobble, that and the rider-wobble are distinguished by |Y_r / Y_f|.
    """
    speeds, branches = track(linearised_at)
    upper = sorted(np.flatnonzero(branches[0].imag > 0), key=lambda i: branches[0, i].imag)
    found = dict(
        zip(("weave", "wobble") if len(upper) == 2 else ("weave", "rider_wobble", "wobble"), upper, strict=True)
    )
    columns = {mode: [i, int(np.argmin(np.abs(branches[0] - branches[0, i].conj())))] for mode, i in found.items()}
    columns["capsize"] = [min(np.flatnonzero(branches[0].imag == 0), key=lambda i: abs(branches[0, i]))]
    free = [i for i in range(branches.shape[1]) if not any(i in own for own in columns.values())]
    columns["rear_wobble"] = [i for i in free if (branches[:, i].imag != 0).any()]
    curves = {mode: np.array([least_stable(row[own]) for row in branches]) for mode, own in columns.items()}
    if "rider_wobble" in curves:
        first, second = curves["rear_wobble"], curves["rider_wobble"]
        for k in range(len(speeds)):
            if k % 50 == 0 and first[k].imag > 0 and second[k].imag > 0:
                ratios = [side_force_ratio(linearised_at, speeds[k], z[k]) for z in (first, second)]
                exchanged = ratios[1] > ratios[0]
                if exchanged:
                    first[k], second[k] = second[k], first[k]
    return speeds, curves


def least_stable(values):
    """The oscillatory eigenvalue of a mode's branches, or the least stable real one."""
    oscillatory = values[values.imag > 0]
    return oscillatory[0] if len(oscillatory) else values[np.argmax(values.real)]


@pytest.mark.slow
@pytest.mark.parametrize("device", DEVICES)
def test_an_independent_tracker_gives_the_same_names(device):
    tracked, curves = named_by_tracking(linearised(device))
    at = np.arange(0, len(tracked), 50)[::-1]  # every 0.25 m/s, ascending
    found = modes(linearised(device), SPEEDS)
    assert tracked[at] == pytest.approx(SPEEDS)
    assert set(found.unstable) == set(curves)
    for mode, curve in curves.items():
        # The same matrices: rounding, of double roots its square root.
        assert found[mode].eigenvalue == pytest.approx(curve[at], abs=1e-6), mode


# Any grid -----------------------------------------------------------------------------------------


@pytest.mark.slow
@settings(max_examples=30)
@given(rider=st.sampled_from(["none", "damper:7.5", *(f"rider:{n}" for n in RIDERS)]),
       speeds=st.lists(st.floats(0.5, 80), min_size=2, max_size=6, unique=True), which=st.integers(0, 5))  # fmt: skip
def test_names_do_not_depend_on_the_grid(rider, speeds, which):
    speeds = np.unique(np.round(speeds, 4))
    together = modes(linearised(rider), speeds)
    k = which % len(speeds)
    alone = modes(linearised(rider), speeds[k : k + 1])
    for mode in MODES:
        # Rounding, of double roots its square root.
        assert alone[mode].eigenvalue[0] == pytest.approx(together[mode].eigenvalue[k], abs=1e-5, nan_ok=True), mode


# Every published rider ----------------------------------------------------------------------------


@pytest.fixture(scope="module", params=RIDERS)
def rider_modes(request):
    return request.param, modes(linearised(f"rider:{request.param}"), SPEEDS)


def test_every_mode_is_one_eigenvalue_and_no_two_modes_share_one(rider_modes):
    _, found = rider_modes
    for k in range(len(SPEEDS)):
        places = [int(np.argmin(np.abs(found.eigenvalues[k] - found[mode].eigenvalue[k]))) for mode in MODES]
        assert len(set(places)) == len(MODES)
        assert all(
            abs(found.eigenvalues[k, i] - found[mode].eigenvalue[k]) < 1e-9
            for i, mode in zip(places, MODES, strict=True)
        )


def test_modes_of_every_rider_are_in_their_bands(rider_modes):
    """Frequencies [Hz] where Sharp and the papers put the modes; real roots count as 0."""
    _, found = rider_modes
    frequency = {mode: found[mode].frequency for mode in MODES}
    assert (frequency["capsize"] == 0).all()
    assert (frequency["weave"] < 4).all()
    assert (np.diff(frequency["weave"][SPEEDS >= 6]) > -0.01).all()  # it rises with speed all along
    assert 5 < frequency["rider_wobble"][0] < 7.5
    assert 4 < frequency["rider_wobble"][-1] < 6.5
    assert 6.5 < frequency["rear_wobble"][0] < 6.65  # the rear tyre's, hardly the rider's
    assert (frequency["rear_wobble"][SPEEDS > 20] == 0).all()
    assert found["rear_wobble"].eigenvalue.real.max() < 0
    # The rider calms the wobble at every speed: the paper's conclusion, for every one of the riders.
    reference = modes(linearised("none"), SPEEDS)["wobble"].eigenvalue.real
    assert (found["wobble"].eigenvalue.real < reference).all()


def test_with_the_mean_rider_the_torso_opposes_the_bar_in_wobble_alone():
    """2011, Sect. 5: almost in opposition in wobble, almost in phase in rider-wobble; not where names are mixed."""
    linear = linearised("rider:mean_2011")
    speeds = np.array([1.0, 4.0, 20.0, 40.0, 60.0])
    found, space = modes(linear, speeds), linear(speeds)
    theta, delta = (space.states.index(n) for n in ("device.torso_angle", "vehicle.steer_angle"))
    for k in range(len(speeds)):
        values, vectors = np.linalg.eig(space.A[k])
        angle = {}
        for mode in ("wobble", "rider_wobble"):
            shape = vectors[:, np.argmin(np.abs(values - found[mode].eigenvalue[k]))]
            angle[mode] = abs(np.degrees(np.angle(shape[theta] / shape[delta])))
        assert angle["wobble"] > 130 and angle["rider_wobble"] < 90


# Bands and errors ---------------------------------------------------------------------------------


@pytest.mark.parametrize("device, mode, end", [("none", "weave", 1), ("none", "wobble", 0), ("none", "capsize", 0),
                                               ("rider:mean_2011", "weave", 0), ("rider:mean_2011", "weave", 1)])  # fmt: skip
def test_unstable_bands_end_where_the_real_part_is_zero(device, mode, end):
    linear = linearised(device)
    found = modes(linear, SPEEDS)
    (band,) = found.unstable[mode]
    k = int(np.argmin(np.abs(SPEEDS - band[end])))

    def real_part(speed):
        values = np.linalg.eigvals(linear(np.array([speed])).A[0])
        return values[np.argmin(np.abs(values - found[mode].eigenvalue[k]))].real

    exact = brentq(real_part, band[end] - 0.3, band[end] + 0.3)
    assert band[end] == pytest.approx(exact, abs=0.01)  # the step of the refinement; 0.1 m/s is asked for


def test_bands_are_clipped_to_the_range_and_stable_modes_have_none():
    found = modes(linearised("rider:mean_2011"), np.linspace(40, 50, 11))
    assert found.unstable["weave"] == [[40.0, 50.0]]
    assert found.unstable["wobble"] == []


def test_absent_modes_are_not_a_number():
    found = modes(linearised("none"), SPEEDS)
    absent = found["rider_wobble"]
    assert np.isnan([absent.eigenvalue.real, absent.frequency, absent.damping_ratio]).all()
    assert "rider_wobble" not in found.unstable


def test_an_overdamped_mode_has_no_frequency_and_no_damping_ratio():
    found = modes(linearised("rider:9_2011"), [5.0])["wobble"]
    assert found.eigenvalue[0].imag == 0 and found.frequency[0] == 0 and np.isnan(found.damping_ratio[0])


@pytest.mark.parametrize("speeds", [[-0.5, 1.0], [-3.0], [np.nan], [2.0, 1.0], [5.0, 5.0], [np.inf]])
def test_speeds_that_make_no_sense_are_refused(speeds):
    with pytest.raises(InputError, match="speeds must be finite, not negative and ascending"):
        modes(linearised("none"), speeds)


@pytest.mark.slow
@pytest.mark.parametrize("gain", [0.0, 1e-6])
def test_what_a_device_brings_besides_takes_no_name(gain):
    """A reflex without gain adds the modes of its delay and changes nothing: every name stays where it was."""
    motorcycle, rider = motorcycles.load("sharp_1971"), riders.load("mean_2011")
    delayed = rider.with_effects(Reflex()).with_values(**{"reflex.gain": gain, "reflex.delay": 0.1})
    speeds = np.array([5.0, 15.0, 30.0, 50.0])
    plain, more = (modes(over_speed(ridden(motorcycle, device)), speeds) for device in (rider, delayed))
    assert more.eigenvalues.shape[1] > plain.eigenvalues.shape[1]
    for mode in MODES:
        # 1e-6: the gain of 1e-6 N.m/rad beside arms of 1e3 moves eigenvalues by less.
        np.testing.assert_allclose(more[mode].eigenvalue, plain[mode].eigenvalue, rtol=1e-6)


# A rider who leans, and the full rider ---------------------------------------------------------------


def leaning(turning=None, **joints):
    """The motorcycle with the rider in roll instead of his part of its rear frame, and a turning rider."""
    return over_speed(ridden(motorcycles.load("sharp_1971"), turning, riders.load("roll_1971", **joints)))


@pytest.mark.slow
def test_a_rider_who_hardly_leans_leaves_the_names_where_they_were():
    """Stiff joints bring fast modes of their own and the eigenvalues of the rigid rider's motorcycle return."""
    speeds = np.array([3.0, 8.0, 15.0, 30.0, 50.0])
    stiff = leaning(
        saddle_stiffness=1e6,
        lean_stiffness=1e6,
        neck_roll_stiffness=1e5,
        saddle_damping=3e4,
        lean_damping=3e4,
        neck_roll_damping=3e3,
    )
    plain, more = modes(linearised("none"), speeds), modes(stiff, speeds)
    assert set(more.unstable) == set(plain.unstable)
    for mode in ("weave", "wobble", "capsize", "rear_wobble"):
        # 500 N on 1e6 N/m: the frame's compliance of half a millimetre in 0.75 m moves eigenvalues by less than a
        # percent.
        np.testing.assert_allclose(more[mode].eigenvalue, plain[mode].eigenvalue, rtol=1e-2, atol=2e-2)


@pytest.mark.slow
@pytest.mark.parametrize("turning", [None, riders.load("mean_2011")], ids=["leaning", "leaning and turning"])
def test_a_leaning_riders_own_modes_take_no_name(turning):
    found, space = modes(leaning(turning), SPEEDS), leaning(turning)(SPEEDS)
    assert ("rider_wobble" in found.unstable) == (turning is not None)
    own = riders.load("roll_1971").states
    foreign = np.array([n.partition(".")[2] in own for n in space.states])
    for k in range(len(SPEEDS)):
        values, right = np.linalg.eig(space.A[k])
        part = np.abs(np.linalg.inv(right).T * right)
        share = part[foreign].sum(axis=0) / part.sum(axis=0)
        for mode in found.unstable:
            # Weave and the lean share their motion where they veer.
            assert share[np.argmin(np.abs(values - found[mode].eigenvalue[k]))] < 0.55, (mode, SPEEDS[k])


@pytest.mark.study
def test_with_the_full_rider_the_torso_opposes_the_bar_in_wobble_alone():
    """2011, Sect. 5, as for the linear rider; his wobble is so well damped that the steer takes a larger part in the
    other.
    """
    linear = over_speed(ridden(motorcycles.load("sharp_1971"), riders.load("full_mean_2011")))
    speeds = np.array([1.0, 20.0, 30.0, 60.0])
    found, space = modes(linear, speeds), linear(speeds)
    theta, delta = (space.states.index(n) for n in ("device.torso_angle", "vehicle.steer_angle"))
    for k in range(len(speeds)):
        values, vectors = np.linalg.eig(space.A[k])
        angle = {mode: abs(np.degrees(np.angle(np.divide(*vectors[[theta, delta], np.argmin(np.abs(values - found[mode].eigenvalue[k]))]))))
                 for mode in ("wobble", "rider_wobble")}  # fmt: skip
        assert angle["wobble"] > 130 and angle["rider_wobble"] < 90
    assert 8 < found["wobble"].frequency[2] < 11 > found["rider_wobble"].frequency[2]
