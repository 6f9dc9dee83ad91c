"""Exudyn: a multibody bicycle on rolling knife-edge wheels, alone and with the FMU of a rider or of
a damper at its steer.

Rear frame, front frame and two wheels are rigid bodies in space, joined by three hinges; the wheels roll without slip
(ObjectJointRollingDisc). Nothing is linearised: the bicycle is struck so lightly that the squares of its angles do not
show, and its eigenvalues are read off the free motion. They are held to Carvallo and Whipple's, which were derived by
hand: Meijaard et al., Proc. R. Soc. A 463 (2007), Table 2.

Exudyn's axes are x forward, y left, z up. Its pre-step function is called with the time of the step's END and the state
at its START; its load functions run two to six times a step, so the FMU steps in the former and is only asked in the
latter (see `motofmi.scenarios.hosts.device`).
"""

from collections.abc import Mapping
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np

from fmus import Component, linearise
from fmus.export.build import build
from fmus.expressions.functions import NUMERIC
from fmus.support.progress import track
from motofmi.scenarios.hosts.device import Device
from motofmi.scenarios.hosts.rider_on_a_bar import measured_eigenvalues
from motofmi.scenarios.hosts.table import main
from rider_fmu import riders
from vehicle_fmu import motorcycles, ridden
from vehicle_fmu.components.dampers import LinearDamper

HOST, PACKAGE = "Exudyn", "exudyn"
STRIKE = 1e-4  # rad/s, roll rate and steer rate at the start; what is not linear is this squared
SAMPLING = 0.01  # s
DAMPING = 0.5  # N.m.s/rad, of the damper
TURNED = np.diag([1.0, -1.0, -1.0])  # from x forward, y right, z down to Exudyn's axes
LEFT = np.array([0.0, 1.0, 0.0])


def run(speed: float = 5.0, step: float = 1e-3, duration: float = 1.0, rider: str = "mean_2011") -> dict:
    """Eigenvalues [1/s] of the multibody bicycle, alone, ridden, and with a damper, beside the exact ones, at a
    speed [m/s] and step [s].

    Raises ModuleNotFoundError without Exudyn.
    """
    bicycle, device = motorcycles.load("benchmark_bicycle"), riders.load(rider)
    heavier = bicycle.with_values(added_steer_inertia=device.run(device.start_values(), NUMERIC)["port_inertia"])
    exact = linearise(ridden(bicycle, device), **{"vehicle.speed": speed}).A
    found = {"alone": compared(free_motion(bicycle, speed, step, duration), linearise(bicycle, speed=speed).A)}
    with TemporaryDirectory() as folder:
        path = build(device, folder).path
        for name in track(("ridden", "ridden_with_held_torque"), "Exudyn"):
            holding = Device(path, Path(folder, name), follows=name == "ridden")
            found[name] = compared(free_motion(heavier, speed, step, duration, holding), exact)
            holding.close()
        damper = LinearDamper("damper", damping=DAMPING)
        holding = Device(build(damper, folder).path, Path(folder, "damper"))
        damped = linearise(ridden(bicycle, damper), **{"vehicle.speed": speed}).A
        found["with_damper"] = compared(free_motion(bicycle, speed, step, duration, holding), damped)
        holding.close()
    return found


def compared(samples: np.ndarray, exact: np.ndarray) -> dict[str, dict[str, complex]]:
    """The slowest modes first: exact eigenvalue and error of the measured one."""
    eigenvalues = np.linalg.eigvals(exact)
    eigenvalues = eigenvalues[eigenvalues.imag >= 0]
    eigenvalues = eigenvalues[np.argsort(-eigenvalues.real)]
    measured = measured_eigenvalues(samples, SAMPLING, eigenvalues)
    return {
        f"mode_{k}": {"exact": e, "error": m - e}
        for k, (e, m) in enumerate(zip(eigenvalues, measured, strict=True), start=1)
    }


def free_motion(
    vehicle: Component, speed: float, step: float, duration: float, device: Device | None = None
) -> np.ndarray:
    """Samples (n, 4 or 6) every 10 ms after a strike: roll and steer angle, their rates, angle
    and rate of the torso."""
    import exudyn as exu  # noqa: PLC0415 - an optional package

    exu.config.suppressWarnings = True  # of what it costs that functions are written in Python
    container = exu.SystemContainer()
    mbs = container.AddSystem()
    bicycle = Bicycle(mbs, vehicle.values, speed, STRIKE, STRIKE)
    rows: list[list[float]] = []
    every = round(SAMPLING / step)
    count = [0]

    def at_start_of_step(mbs: Any, end_of_step: float) -> bool:
        now, motion = count[0] * step, bicycle.motion()
        if device is not None:
            device.meet(now, motion)
        if count[0] % every == 0:
            torso = device.get("torso_angle", "torso_rate") if device is not None and device.has("torso_angle") else []
            rows.append([*bicycle.roll(), *motion[:2], *torso])
        count[0] += 1
        return True

    mbs.SetPreStepUserFunction(at_start_of_step)
    if device is not None:
        bicycle.hold(device)
    mbs.Assemble()
    settings = exu.SimulationSettings()
    settings.timeIntegration.numberOfSteps = round(duration / step)
    settings.timeIntegration.endTime = duration
    settings.timeIntegration.verboseMode = 0
    settings.timeIntegration.adaptiveStep = False  # a step taken again would meet the FMU in its future
    settings.timeIntegration.newton.relativeTolerance = 1e-10
    settings.timeIntegration.newton.absoluteTolerance = 1e-12
    settings.timeIntegration.generalizedAlpha.spectralRadius = (
        0.7  # to the tenth: what is the solver's own dies within a sample
    )
    settings.solution.file.write = False
    mbs.SolveDynamic(settings, solverType=exu.DynamicSolverType.GeneralizedAlpha)
    return np.array(rows)


class Bicycle:
    """The bodies of a Carvallo-Whipple bicycle in an Exudyn system, rolling upright and straight ahead, just struck."""

    def __init__(self, mbs: Any, p: Mapping[str, float], speed: float, roll_rate: float, steer_rate: float):
        """p are the parameters of `vehicle_fmu.Bicycle`; speed [m/s], rates [rad/s]."""
        from exudyn import OutputVariableType  # noqa: PLC0415 - an optional package
        from exudyn.rigidBodyUtilities import RigidBodyInertia  # noqa: PLC0415 - an optional package

        self._mbs, self._type = mbs, OutputVariableType
        c, S = np.cos(p["caster_angle"]), np.sin(p["caster_angle"])
        self.axis = np.array([S, 0.0, -c])  # of the steer; a turn to the right is positive
        foot = np.array([p["wheelbase"] + p["ground_trail"], 0.0, 0.0])  # where it meets the ground
        yaw_rate = p["ground_trail"] * c / p["wheelbase"] * steer_rate  # so that the front wheel does not slip
        rear_rate = np.array([roll_rate, 0.0, -yaw_rate])
        front_rate = rear_rate + steer_rate * self.axis
        ahead = np.array([speed, 0.0, 0.0])  # of the rear contact, the origin

        def body(name: str, at: np.ndarray, tensor: np.ndarray, rate: np.ndarray, spin: float = 0.0) -> Any:
            velocity = ahead + np.cross(rear_rate, at) + np.cross(rate - rear_rate, at - foot)
            inertia = RigidBodyInertia(mass=p[f"{name}_mass"], inertiaTensor=TURNED @ tensor @ TURNED)
            return mbs.CreateRigidBody(name, at, inertia=inertia, initialVelocity=velocity,
                                       initialAngularVelocity=rate + spin * LEFT,
                                       gravity=[0.0, 0.0, -p["gravity"]])  # fmt: skip

        def frame(name: str, rate: np.ndarray, added: np.ndarray) -> Any:
            xx, zz, xz = (p[f"{name}_{axes}"] for axes in ("xx", "zz", "xz"))
            tensor = np.array([[xx, 0, xz], [0, xx + zz, 0], [xz, 0, zz]])  # its pitch inertia plays no part
            return body(name, np.array([p[f"{name}_x"], 0.0, -p[f"{name}_z"]]), tensor + added, rate)

        def wheel(end: str, carrier: Any, x: float, rate: np.ndarray) -> None:
            across, polar, radius = p[f"{end}_wheel_inertia"], p[f"{end}_spin_inertia"], p[f"{end}_wheel_radius"]
            hub = np.array([x, 0.0, radius])
            disc = body(f"{end}_wheel", hub, np.diag([across, polar, across]), rate, speed / radius)
            mbs.CreateRevoluteJoint(itemNumbers=[carrier, disc], position=hub, axis=LEFT)
            mbs.CreateRollingDisc(
                bodyNumbers=[ground, disc], axisPosition=[0, 0, 0], axisVector=LEFT, discRadius=radius
            )

        ground = mbs.CreateGround()
        rider = p["added_steer_inertia"] * np.outer([S, 0, c], [S, 0, c])
        self.rear, self.front = (
            frame("rear_frame", rear_rate, np.zeros((3, 3))),
            frame("front_frame", front_rate, rider),
        )
        mbs.CreateRevoluteJoint(itemNumbers=[self.rear, self.front], position=foot, axis=self.axis)
        wheel("rear", self.rear, 0.0, rear_rate)
        wheel("front", self.front, p["wheelbase"], front_rate)

    def _attitude(self, body: Any) -> tuple[np.ndarray, np.ndarray]:
        """Rotation matrix (3, 3) and angular velocity (3,) of a body, in Exudyn's axes."""
        rotation, rate = (self._mbs.GetObjectOutputBody(body, kind, [0.0, 0.0, 0.0])
                          for kind in (self._type.RotationMatrix, self._type.AngularVelocity))  # fmt: skip
        return np.reshape(rotation, (3, 3)), np.asarray(rate)

    def motion(self) -> np.ndarray:
        """Steer angle, steer rate and frame rate (3,)."""
        (rear, rear_rate), (front, front_rate) = self._attitude(self.rear), self._attitude(self.front)
        turned = rear.T @ front @ LEFT
        angle = np.arctan2(self.axis @ np.cross(LEFT, turned), LEFT @ turned)
        axis = rear @ self.axis
        return np.array([angle, axis @ (front_rate - rear_rate), axis @ rear_rate])

    def roll(self) -> tuple[float, float]:
        """Roll angle and roll rate."""
        rotation, rate = self._attitude(self.rear)
        return float(np.arcsin(rotation[2, 1])), float(rotation[:, 0] @ rate)

    def hold(self, device: Device) -> None:
        """The device's torques on the two frames, about the steer axis as it lies in each."""
        for k, body in enumerate((self.front, self.rear)):

            def torque(mbs: Any, time: float, _: Any, k: int = k) -> np.ndarray:
                return device.torques(time, self.motion())[k] * self.axis

            self._mbs.CreateTorque(
                itemNumber=body, loadVector=[0.0, 0.0, 1.0], bodyFixed=True, loadVectorUserFunction=torque
            )


if __name__ == "__main__":
    main(run)
