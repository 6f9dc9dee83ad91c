"""MuJoCo: a frame on a spring that turns about the steer axis, a handlebar hinged to it, a rider's FMU between the two.

    (I_f + I_b) w' + I_b s' + k psi + c w = T_h + T_f,   I_b (w' + s') = T_h,   psi' = w,   delta' = s

MuJoCo calls `mjcb_passive` in every stage of a step, so the FMU is only asked there and steps between MuJoCo's steps
(see `motofmi.scenarios.hosts.device`). Torque is power-conjugate to MuJoCo's hinge rates w and s: T_h + T_f and T_h.
"""

from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np
from scipy.linalg import expm

from fmus import Component, StateSpace, System, linearise, parameter, state
from fmus.export.build import build
from fmus.interfaces.handlebar import port_input, port_state
from motofmi.scenarios.hosts.device import Device
from motofmi.scenarios.hosts.rider_on_a_bar import measured_eigenvalues
from motofmi.scenarios.hosts.table import main
from rider_fmu import riders

HOST, PACKAGE = "MuJoCo", "mujoco"
STRIKE = 1.0  # rad/s, steer rate at the start
SHOWN = (
    "vehicle.frame_angle",
    "vehicle.steer_angle",
    "vehicle.frame_rate",
    "vehicle.steer_rate",
    "device.torso_angle",
    "device.torso_rate",
)


class SprungFrame(Component):
    """The mechanism as equations, for the exact solution."""

    frame_inertia = parameter(
        "kg.m2", "Inertia of the frame about the steer axis", symbol="I_f", min=1e-3, max=1e3, start=3.0
    )
    bar_inertia = parameter(
        "kg.m2", "Inertia of the bar about the steer axis", symbol="I_b", min=1e-3, max=1e3, start=0.6
    )
    frame_stiffness = parameter("N.m/rad", "Stiffness that holds the frame", symbol="k", min=0, max=1e6, start=800.0)
    frame_damping = parameter("N.m.s/rad", "Damping that holds the frame", symbol="c", min=0, max=1e4, start=4.0)
    handlebar_torque = port_input("handlebar_torque")
    frame_torque = port_input("frame_torque")
    frame_angle = state("rad", "Angle of the frame", symbol=r"\psi", exposed=True)
    steer_angle = port_state("steer_angle")
    frame_rate = port_state("frame_rate")
    steer_rate = port_state("steer_rate")

    def mass(self, v, m):
        return {("frame_rate", "frame_rate"): v.frame_inertia + v.bar_inertia,
                ("frame_rate", "steer_rate"): v.bar_inertia, ("steer_rate", "frame_rate"): v.bar_inertia,
                ("steer_rate", "steer_rate"): v.bar_inertia}  # fmt: skip

    def equations(self, v, m):
        held = v.frame_stiffness * v.frame_angle + v.frame_damping * v.frame_rate
        return {
            "der(frame_angle)": v.frame_rate,
            "der(steer_angle)": v.steer_rate,
            "der(frame_rate)": v.handlebar_torque + v.frame_torque - held,
            "der(steer_rate)": v.handlebar_torque,
        }


# Gravity along the axis, so that it plays no part; MuJoCo wants a mass, which on the axis has no inertia about it.
MODEL = """
<mujoco>
  <option timestep="{step!r}" integrator="RK4"/>
  <worldbody>
    <body name="frame">
      <inertial pos="0 0 0" mass="10" diaginertia="{frame_inertia!r} {frame_inertia!r} {frame_inertia!r}"/>
      <joint name="frame" type="hinge" axis="0 0 1" stiffness="{frame_stiffness!r}" damping="{frame_damping!r}"/>
      <body name="bar">
        <inertial pos="0 0 0" mass="2" diaginertia="{bar_inertia!r} {bar_inertia!r} {bar_inertia!r}"/>
        <joint name="steer" type="hinge" axis="0 0 1"/>
      </body>
    </body>
  </worldbody>
</mujoco>
"""


def run(step: float = 1e-3, duration: float = 1.0, rider: str = "mean_2011") -> dict:
    """Errors of modes [1/s] and trajectory at a step [s], with the torque that follows the motion and with a held one.

    Raises ModuleNotFoundError without MuJoCo.
    """
    device = riders.load(rider)
    mechanism = SprungFrame("sprung_frame")
    space = linearise(System("ridden", {"vehicle": mechanism, "device": device}))
    found = {}
    with TemporaryDirectory() as folder:
        path = build(device, folder).path
        for name, follows in (("following_torque", True), ("held_torque", False)):
            holding = Device(path, Path(folder, name), follows)
            samples = free_motion(MODEL.format(step=step, **mechanism.values), round(duration / step), holding)
            holding.close()
            found[name] = compared(samples, space, step)
    return found


def free_motion(model: str, count: int, device: Device) -> np.ndarray:
    """Samples (count, 6) at every step after a strike: the columns of SHOWN."""
    import mujoco  # noqa: PLC0415 - an optional package

    mechanism = mujoco.MjModel.from_xml_string(model)
    data = mujoco.MjData(mechanism)
    data.qvel[1] = STRIKE

    def motion(data) -> np.ndarray:
        return np.array([data.qpos[1], data.qvel[1], data.qvel[0]])

    def passive(_, data) -> None:
        on_bar, on_frame = device.torques(data.time, motion(data))
        data.qfrc_passive[:] += on_bar + on_frame, on_bar

    rows = []
    mujoco.set_mjcb_passive(passive)
    try:
        for _ in range(count):
            device.meet(data.time, motion(data))
            rows.append([*data.qpos, *data.qvel, *device.get("torso_angle", "torso_rate")])
            mujoco.mj_step(mechanism, data)
    finally:
        mujoco.set_mjcb_passive(None)
    return np.array(rows)


def compared(samples: np.ndarray, space: StateSpace, step: float) -> dict:
    """Each oscillatory mode: exact eigenvalue and error of the measured one; the largest error of the steer angle."""
    eigenvalues = np.linalg.eigvals(space.A)
    modes = np.sort_complex(eigenvalues[eigenvalues.imag > 0])[::-1]
    found: dict = {f"mode_{k}": {"exact": e, "error": m - e}
                   for k, (e, m) in enumerate(zip(modes, measured_eigenvalues(samples, step, modes), strict=True),
                                              start=1)}  # fmt: skip
    start = np.zeros(len(space.states))
    start[space.states.index("vehicle.steer_rate")] = STRIKE
    transition, true = expm(space.A * step), []
    for _ in samples:
        true.append(start[space.states.index("vehicle.steer_angle")])
        start = transition @ start
    steer = samples[:, SHOWN.index("vehicle.steer_angle")]
    found["trajectory_error"] = float(np.abs(steer - true).max() / np.abs(true).max())
    return found


if __name__ == "__main__":
    main(run)
