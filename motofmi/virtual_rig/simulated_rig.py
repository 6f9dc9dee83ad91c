"""The virtual rig: a rider on the servo-driven handlebar, recorded with the sensors of the real rig.

The rig and the rider are one linear system, integrated exactly (see `fmus.linear_analysis.exact_motion`); noise,
remnant and quantisation are added. The result is a Recording.
"""

from dataclasses import dataclass, replace

import numpy as np

from fmus import Component, System
from fmus.expressions.functions import NUMERIC
from fmus.linear_analysis.exact_motion import exact_response
from fmus.linear_analysis.linearisation import linearise
from motofmi.frequency_response.excitation import Excitation, stepped_sine
from motofmi.recordings.channels import BODY_POINTS, STEER_ANGLE, STEER_ANGLE_COMMAND, STEER_TORQUE, units_of
from motofmi.recordings.recording import Recording
from rider_fmu import RollRig, SteerRig, riders


@dataclass(frozen=True)
class Noise:
    """Standard deviations of the channels' white noise, of the rider's remnant, and the converters' steps."""

    angle: float = np.radians(0.03)  # rad
    torque: float = 0.2  # N.m
    remnant: float = 0.4  # N.m
    remnant_bandwidth: float = 2.0  # Hz, of two first-order filters
    angle_step: float = np.radians(40) / 4096  # rad, 12 bit over +-20 deg
    torque_step: float = 400 / 4096  # N.m, 12 bit over +-200 N.m


QUIET = Noise(0.0, 0.0, 0.0, 1.0, 0.0, 0.0)


def steer_test(rider: Component, steer_inertia: float, excitation: Excitation, noise: Noise = Noise(), seed: int = 0,
               rate: float = 128.0, oversampling: int = 4, rig: SteerRig | None = None) -> Recording:  # fmt: skip
    """The recording of one run: steer_angle_command, steer_angle, steer_torque at `rate` [Hz].

    Between the samples the motion is computed `oversampling` times finer, on which the command is a cubic.
    """
    bar = (rig or SteerRig("rig")).with_values(steer_inertia=steer_inertia)
    space = linearise(System("test", {"rig": bar, "rider": rider}))
    fine = rate * oversampling
    time = np.arange(round(excitation.duration * fine)) / fine
    rng = np.random.default_rng(seed)
    angle, angle_rate = excitation.motion(time)
    given = {"rig.steer_angle_command": (angle, angle_rate)}
    if noise.remnant:
        given["rig.remnant_torque"] = remnant_torque(noise.remnant, noise.remnant_bandwidth, time, rng)
    used = [space.inputs.index(name) for name in given]
    driven = replace(space, B=space.B[:, used], D=space.D[:, used], inputs=tuple(given))
    values, slopes = (np.column_stack(columns) for columns in zip(*given.values(), strict=True))
    states, _ = exact_response(driven, values, 1 / fine, slopes)
    return _recorded(bar, dict(zip(space.states, states[::oversampling].T, strict=True)), time[::oversampling],
                     angle[::oversampling], noise, rng, f"{excitation.name}_{rider.name}")  # fmt: skip


def roll_test(rider: Component | None = None, frequencies: np.ndarray | None = None, accelerometer_noise: float = 0.01,
              seed: int = 0, rate: float = 128.0, oversampling: int = 2, amplitude: float = np.radians(1),
              mockup_height: float = 0.5) -> tuple[Recording, np.ndarray]:  # fmt: skip
    """The recording of a roll test, and its single frequencies [Hz], in random order to avoid voluntary
    reactions.

    The rider is rider 3 of 2008 by default; accelerometer_noise [m/s2] is a standard deviation, mockup_height [m] the
    distance of the mock-up's accelerometer from the roll axis.
    """
    rng = np.random.default_rng(seed)
    levels = np.arange(0.5, 7.01, 0.25) if frequencies is None else np.asarray(frequencies, float)
    excitation = stepped_sine(rng.permutation(levels), seconds=20.0, amplitude=amplitude)
    space = linearise(System("test", {"rig": RollRig("rig"), "rider": rider or riders.load("roll_3_2008")}))
    fine = rate * oversampling
    time = np.arange(round(excitation.duration * fine)) / fine
    command = space.inputs.index("rig.roll_angle_command")
    driven = replace(space, B=space.B[:, [command]], D=space.D[:, [command]], inputs=("rig.roll_angle_command",))
    angle, angle_rate = (x[:, None] for x in excitation.motion(time))
    states, outputs = (x[::oversampling] for x in exact_response(driven, angle, 1 / fine, angle_rate))
    rates = (
        states @ driven.A.T + angle[::oversampling] @ driven.B.T
    ) @ driven.C.T  # of the outputs that are velocities
    channels = {"mockup_acceleration": mockup_height * outputs[:, space.outputs.index("rig.roll_acceleration")]}
    channels |= {
        f"{point}_acceleration": rates[:, space.outputs.index(f"rider.{point}_velocity")] for point in BODY_POINTS
    }
    noisy = {name: a + accelerometer_noise * rng.standard_normal(len(a)) for name, a in channels.items()}
    return Recording("roll_test", time[::oversampling], noisy, dict.fromkeys(noisy, "m/s2")), levels


def _recorded(rig, states, time, command, noise: Noise, rng, name: str) -> Recording:
    """The channels computed from the states by the equations of the rig, with noise and quantisation."""
    values = {**rig.start_values(), **{key[4:]: value for key, value in states.items() if key.startswith("rig.")}}
    values.update(angle_noise=noise.angle * rng.standard_normal(len(time)),
                  torque_noise=noise.torque * rng.standard_normal(len(time)), angle_step=noise.angle_step,
                  torque_step=noise.torque_step)  # fmt: skip
    results = rig.run(values, NUMERIC)
    columns = {
        STEER_ANGLE_COMMAND: command,
        STEER_ANGLE: results["measured_angle"],
        STEER_TORQUE: results["measured_torque"],
    }
    return Recording(name, time, columns, units_of(columns))


def remnant_torque(deviation: float, bandwidth: float, time: np.ndarray, rng) -> tuple[np.ndarray, np.ndarray]:
    """White Gaussian noise through two first-order filters of a bandwidth [Hz], and its rate."""
    grid = np.fft.rfftfreq(len(time), time[1])
    shape = 1 / (1 + (grid / bandwidth) ** 2) * (grid > 0)
    spectrum = shape * (rng.standard_normal(len(grid)) + 1j * rng.standard_normal(len(grid)))
    scale = deviation * len(time) / (2 * np.sqrt(np.sum(shape**2)))
    return np.fft.irfft(scale * spectrum, len(time)), np.fft.irfft(2j * np.pi * grid * scale * spectrum, len(time))
