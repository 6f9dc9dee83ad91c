"""The modes of many riders at once against those of each rider by itself, which are found on a finer grid."""

import numpy as np
import pytest

from fmus.linear_analysis.linearisation import linearise
from rider_fmu import riders
from vehicle_fmu import MODES, LinearDamper, modes, motorcycles, over_speed, ridden
from vehicle_fmu.stacked_modes import stacked_modes

SPEEDS = np.arange(1.0, 60.1, 1.0)
MEMBERS = [riders.load(f"{number}_2011") for number in range(1, 6)]


def both(vehicle: str, damping: float):
    system = ridden(motorcycles.load(vehicle), MEMBERS[0], LinearDamper("damper", "", damping=damping))
    values = {f"device.{n}": np.array([rider.values[n] for rider in MEMBERS]) for n in MEMBERS[0].values}
    found = stacked_modes(lambda member, speed: linearise(system, **{"vehicle.speed": speed},
                                                          **{n: x[member] for n, x in values.items()}),
                          len(MEMBERS), SPEEDS)  # fmt: skip
    alone = [modes(over_speed(system.with_values(**{n: float(x[k]) for n, x in values.items()})), SPEEDS)
             for k in range(len(MEMBERS))]  # fmt: skip
    return found, alone


@pytest.mark.slow
@pytest.mark.parametrize("vehicle", ["sharp_1971", "reference_2011"])
@pytest.mark.parametrize("damping", [0.0, 7.5])
def test_the_modes_of_many_riders_are_those_of_each(vehicle, damping):
    found, alone = both(vehicle, damping)
    for member, one in enumerate(alone):
        for k, mode in enumerate(MODES):
            ours, theirs = found.eigenvalue[member, k], one[mode].eigenvalue
            same = np.isclose(ours, theirs, rtol=1e-9) | (np.isnan(ours) & np.isnan(theirs))
            # `modes` rounds the speed at which two modes exchange their names up to 0.1 m/s: one of 60 speeds may be
            # there.
            assert (~same).sum() <= 1
            bands = found.unstable[(found.unstable[:, 0] == member) & (found.unstable[:, 1] == k), 2:]
            # Both locate ends by false position to 0.01 m/s.
            np.testing.assert_allclose(bands, np.reshape(one.unstable.get(mode, []), (-1, 2)), atol=0.02)


@pytest.mark.slow
def test_names_do_not_depend_on_the_requested_speeds():
    found, _ = both("sharp_1971", 0.0)
    system = ridden(motorcycles.load("sharp_1971"), MEMBERS[0], LinearDamper("damper", "", damping=0.0))
    few = stacked_modes(lambda member, speed: linearise(system, **{"vehicle.speed": speed}), 1, np.array([20.0, 45.0]))
    np.testing.assert_allclose(few.eigenvalue[0], found.eigenvalue[0][:, [19, 44]], rtol=1e-9)
