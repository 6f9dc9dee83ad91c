"""The steer test on the full rider: his compiled FMU with an imposed steer angle, recorded with the sensors of the rig.

    M_s = I_0 delta'' - T_h
    T_h = handlebar_torque - [R delta'' + inertia_torque],    R = port_inertia + inertia_change

The steer angle is imposed, as by the servo of the virtual rig and in both papers. Sensor noise, rider remnant and
analogue-digital converters are added.
"""

import tempfile

import numpy as np

from fmus.cosimulation.subsystems.fmu_subsystem import FmuSubsystem
from fmus.declaration.component import Component
from fmus.export.build import build
from fmus.support.progress import track
from motofmi.frequency_response.excitation import Excitation
from motofmi.recordings.channels import STEER_ANGLE, STEER_ANGLE_COMMAND, STEER_TORQUE, units_of
from motofmi.recordings.recording import Recording
from motofmi.virtual_rig.simulated_rig import Noise, remnant_torque

RATE = 128  # Hz; sampling rate of the recording
FINER = 4  # integration steps per sample
MOMENT = 1e-5  # s; time step of the finite difference for the bar's acceleration
USUAL = Noise()
ANSWERED = ("handlebar_torque", "inertia_change", "inertia_torque")


def steer_test(
    rider: Component, bar_inertia: float, excitation: Excitation, noise: Noise = USUAL, seed: int = 0
) -> Recording:
    """The recording of one run: steer_angle_command, steer_angle, steer_torque; bar_inertia in kg.m2.

    Raises SimulationError if the arms cannot follow the grips.
    """
    fine = RATE * FINER
    time = np.arange(round(excitation.duration * RATE) * FINER + 1) / fine
    angle, rate = excitation.motion(time)
    later, before = (excitation.motion(time + t)[1] for t in (MOMENT, -MOMENT))
    torque = _torque(rider, bar_inertia, angle, rate, (later - before) / (2 * MOMENT), 1 / fine)[:-1:FINER]
    rng = np.random.default_rng(seed)
    n = len(torque)
    shown = time[:-1:FINER]
    if noise.remnant:
        torque = torque + remnant_torque(noise.remnant, noise.remnant_bandwidth, shown, rng)[0]
    columns = {
        STEER_ANGLE_COMMAND: angle[:-1:FINER],
        STEER_ANGLE: _converted(angle[:-1:FINER] + noise.angle * rng.standard_normal(n), noise.angle_step),
        STEER_TORQUE: _converted(torque + noise.torque * rng.standard_normal(n), noise.torque_step),
    }
    return Recording(f"{excitation.name}_{rider.name}", shown, columns, units_of(columns))


def _torque(
    rider: Component, bar_inertia: float, angle: np.ndarray, rate: np.ndarray, acceleration: np.ndarray, step: float
) -> np.ndarray:
    """The servo's torque (n,) [N.m]; between the instants the angle is the cubic through angles and rates."""
    with tempfile.TemporaryDirectory() as folder:
        subsystem = FmuSubsystem(build(rider, folder).path, values={"steer_angle": angle[0], "steer_rate": rate[0]})
    answered = np.empty((len(angle), len(subsystem.outputs)))
    inputs = np.zeros((len(angle), len(subsystem.inputs)))
    place = {name: subsystem.inputs.index(name) for name in ("steer_angle", "steer_rate")}
    inputs[:, place["steer_angle"]], inputs[:, place["steer_rate"]] = angle, rate
    polynomials = np.zeros((len(angle) - 1, 4, len(subsystem.inputs)))  # in the share of the step
    polynomials[:, :, place["steer_angle"]] = cubic = _hermite(angle, rate * step)
    polynomials[:, :3, place["steer_rate"]] = cubic[:, 1:] * np.array([1, 2, 3]) / step
    answered[0] = subsystem.exchange(inputs[0])
    for k in track(range(len(polynomials)), "steer test"):
        subsystem.step(polynomials[k], step)
        answered[k + 1] = subsystem.exchange(inputs[k + 1])
    reflected = subsystem.get("port_inertia")
    subsystem.close()
    torque, change, fed = (answered[:, subsystem.outputs.index(name)] for name in ANSWERED)
    return (bar_inertia + reflected + change) * acceleration + fed - torque


def _hermite(value: np.ndarray, slope: np.ndarray) -> np.ndarray:
    """Coefficients (n - 1, 4) of the cubics through values and slopes (n,) at both ends of every step."""
    a, b, da, db = value[:-1], value[1:], slope[:-1], slope[1:]
    return np.column_stack([a, da, 3 * (b - a) - 2 * da - db, 2 * (a - b) + da + db])


def _converted(signal: np.ndarray, step: float) -> np.ndarray:
    return step * np.round(signal / step) if step else signal
