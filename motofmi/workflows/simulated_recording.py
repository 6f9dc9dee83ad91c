"""A simulated steer test as a file: what a rig would record of a rider, to plan and to try out an evaluation."""

from collections.abc import Callable
from pathlib import Path

import numpy as np

from fmus.support.errors import InputError, unknown
from motofmi.frequency_response.excitation import Excitation, multisine, stepped_sine, sweep
from motofmi.recordings.reading import write_recording
from motofmi.virtual_rig.simulated_rig import steer_test
from motofmi.workflows.components import ComponentLike
from motofmi.workflows.components import rider as rider_of
from rider_fmu.rigs.handlebar import HANDLEBAR_INERTIA

EXCITATIONS: dict[str, Callable[..., Excitation]] = {
    "sweep": sweep, "stepped_sine": stepped_sine, "multisine": multisine,
}  # fmt: skip
SHORTEST = 10.0  # s: the fades at both ends take 4 s


def simulate_steer_test(
    rider: ComponentLike, path: str | Path, *, excitation: str = "sweep", duration: float = 60.0,
    amplitude: float = 2.0, steer_inertia: float = HANDLEBAR_INERTIA, seed: int = 0,
) -> str:  # fmt: skip
    r"""Simulate the steer test on a rider and write its recording; the path as text.

    A servo turns the handlebar of steer_inertia [kg.m2] by at most amplitude [deg] for duration [s], and 2 s without
    motion. excitation is a sweep from 0.5 to 12 Hz, a stepped_sine over 0.5 to 8.5 Hz (the tests of the papers of 2011
    and 2008), or a multisine. The recording has the commanded and the measured steer angle [rad] and the torque [N.m]
    at 128 Hz, with the noise and the converters of a rig and the rider's own torque; seed selects the noise.

    Raises InputError for an unknown excitation, for times or amplitudes that are not positive, and for what is no
    rider.

        >>> from pathlib import Path
        >>> path = mf.simulate_steer_test("rider:5_2011", "sweep.csv", duration=20.0, seed=1)
        >>> Path(path).read_text().partition("\n")[0]
        'time [s],steer_angle_command [rad],steer_angle [rad],steer_torque [N.m]'
        >>> len(mf.estimate_frf([path]).runs)
        1
    """
    if excitation not in EXCITATIONS:
        raise unknown("excitation", excitation, EXCITATIONS)
    given = {"duration": (duration, SHORTEST), "amplitude": (amplitude, 0.0), "steer_inertia": (steer_inertia, 0.0)}
    for name, (value, least) in given.items():
        if not (np.isfinite(value) and value >= least and value > 0):
            raise InputError(f"{name} = {value:g} is not possible (valid: {f'from {least:g}' if least else 'above 0'})")
    motion = _motion(excitation, duration, np.radians(amplitude))
    write_recording(steer_test(rider_of(rider), steer_inertia, motion, seed=seed), path)
    return str(path)


def _motion(excitation: str, duration: float, amplitude: float) -> Excitation:
    if excitation == "stepped_sine":
        levels = np.arange(0.5, 8.51, 0.5)
        return stepped_sine(levels, duration / len(levels), amplitude)
    return EXCITATIONS[excitation](duration=duration, amplitude=amplitude)
