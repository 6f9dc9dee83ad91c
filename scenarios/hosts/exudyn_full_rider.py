"""Exudyn: the full rider once more, as six rigid bodies in space with joints, springs and dampers.

Handlebar, torso, two upper arms, two forearms; hinges at steer axis, waist and elbows, ball joints at the shoulders,
and a wrist of two revolutes: one about an axis h fixed in the hand, one parallel to the elbow's n, which is the one
condition h . n = 0 (GenericJoint with one rotation held: x axis of its first frame on the y axis of its second).
Nothing of the closed form enters but the rest posture: the solver closes the loops.

Axes of the steer axis as in `rider_fmu.full_rider.arm_loop`.
"""

from types import SimpleNamespace
from typing import Any

import numpy as np

from fmus.declaration.component import Component
from fmus.expressions.functions import NUMERIC
from rider_fmu.full_rider.arm_loop import arm, pelvis, span

STEER_AXIS = np.array([0.0, 0.0, 1.0])
TINY = 1e-9  # kg.m2: inertia that the model leaves out, for a solver that needs a regular tensor


def response(
    rig: Component, amplitude: float, frequency: float, step: float, duration: float, along: float = TINY
) -> np.ndarray:
    """Rows (time [s], steer angle, torso angle [rad]) from rest under a servo torque amplitude sin(2 pi
    frequency t) [N.m, Hz].

    along is the arms' inertia about their own length [kg.m2]. Raises ModuleNotFoundError without Exudyn.
    """
    import exudyn  # noqa: PLC0415 - an optional package

    mbs = exudyn.SystemContainer().AddSystem()
    bodies = _bodies(exudyn, mbs, rig, along)
    omega = 2 * np.pi * frequency
    mbs.CreateTorque(itemNumber=bodies["bar"], loadVector=list(amplitude * STEER_AXIS),
                     loadVectorUserFunction=lambda _, t, vector: [np.sin(omega * t) * c for c in vector])  # fmt: skip
    sensors = [_rotation(exudyn, mbs, bodies[name]) for name in ("bar", "torso")]
    mbs.Assemble()
    settings = exudyn.SimulationSettings()
    settings.timeIntegration.numberOfSteps = round(duration / step)
    settings.timeIntegration.endTime = duration
    settings.timeIntegration.verboseMode = 0
    settings.timeIntegration.newton.relativeTolerance = 1e-10
    settings.timeIntegration.newton.absoluteTolerance = 1e-10
    settings.timeIntegration.newton.useModifiedNewton = False
    settings.solution.file.write = False
    settings.solution.sensors.writePeriod = step
    settings.linearSolver.solverType = exudyn.LinearSolverType.EigenDense
    mbs.SolveDynamic(settings, solverType=exudyn.DynamicSolverType.TrapezoidalIndex2)
    recorded = [np.asarray(mbs.GetSensorStoredData(sensor)) for sensor in sensors]
    angles = [
        _angle(data[:, 1:].reshape(-1, 3, 3), axis)
        for data, axis in zip(recorded, (STEER_AXIS, waist_axis(rig)), strict=True)
    ]
    return np.column_stack([recorded[0][:, 0], *angles])


def waist_axis(rig: Component) -> np.ndarray:
    tilt = rig.values["steer_tilt"] + rig.values["torso_inclination"]
    return np.array([-np.sin(tilt), 0.0, np.cos(tilt)])


def _rotation(exudyn: Any, mbs: Any, body: int) -> int:
    from exudyn.itemInterface import SensorBody  # noqa: PLC0415 - an optional package

    return mbs.AddSensor(
        SensorBody(bodyNumber=body, storeInternal=True, outputVariableType=exudyn.OutputVariableType.RotationMatrix)
    )


def _angle(matrices: np.ndarray, axis: np.ndarray) -> np.ndarray:
    """The angle of rotations (n, 3, 3) about a fixed unit axis, by what they do to a vector across it."""
    across = np.array([0.0, 1.0, 0.0])
    turned = matrices @ across
    return np.arctan2(turned @ np.cross(axis, across), turned @ across)


def _bodies(exudyn: Any, mbs: Any, rig: Component, along: float) -> dict[str, int]:
    """The six bodies with their joints and springs, at rest."""
    from exudyn.rigidBodyUtilities import RigidBodyInertia  # noqa: PLC0415 - an optional package

    v = SimpleNamespace(**rig.values)
    gravity = [-v.gravity * np.sin(v.steer_tilt), 0.0, v.gravity * np.cos(v.steer_tilt)]
    ground = mbs.CreateGround()

    def body(mass: float, inertia: np.ndarray, centre: np.ndarray, falls: bool = True) -> int:
        return mbs.CreateRigidBody(inertia=RigidBodyInertia(mass=mass, inertiaTensor=inertia),
                                   referencePosition=list(centre),
                                   gravity=gravity if falls else [0.0, 0.0, 0.0])  # fmt: skip

    hips, axis = np.array(pelvis(v, NUMERIC), float), waist_axis(rig)
    # Masses on their hinges' axes: only the inertia about the axis matters, and no weight turns them.
    bodies = {"bar": body(1.0, np.eye(3) * (v.bar_inertia + v.hands_inertia), np.zeros(3), falls=False),
              "torso": body(1.0, np.eye(3) * v.trunk_inertia, hips, falls=False)}  # fmt: skip
    mbs.CreateRevoluteJoint(
        itemNumbers=[ground, bodies["bar"]], position=[0, 0, 0], axis=list(STEER_AXIS), useGlobalFrame=True
    )
    mbs.CreateRevoluteJoint(
        itemNumbers=[ground, bodies["torso"]], position=list(hips), axis=list(axis), useGlobalFrame=True
    )
    mbs.CreateTorsionalSpringDamper(itemNumbers=[ground, bodies["torso"]], position=list(hips), axis=list(axis),
                                    stiffness=v.waist_stiffness, damping=v.waist_damping,
                                    useGlobalFrame=True)  # fmt: skip
    for side, word in ((1, "right"), (-1, "left")):
        at = arm(v, NUMERIC, side, 0.0, 0.0)
        S, E, W = (np.array([float(c.f) for c in point]) for point in (at.shoulder, at.elbow, at.wrist))
        h = np.array([float(c.f) for c in span(v, NUMERIC, side, 0.0, 0.0)[1]])
        n = np.cross(W - S, h)
        n /= np.linalg.norm(n)
        upper = _rod(body, v.upper_arm_mass, v.upper_arm_centre, v.upper_arm_inertia, S, E, along)
        fore = _rod(body, v.forearm_mass, v.forearm_centre, v.forearm_inertia, E, W, along)
        bodies |= {f"{word}_upper_arm": upper[0], f"{word}_forearm": fore[0]}
        mbs.CreateSphericalJoint(itemNumbers=[bodies["torso"], upper[0]], position=list(S), useGlobalFrame=True)
        mbs.CreateRevoluteJoint(itemNumbers=[upper[0], fore[0]], position=list(E), axis=list(n), useGlobalFrame=True)
        mbs.CreateGenericJoint(itemNumbers=[bodies["bar"], fore[0]], position=list(W),
                               rotationMatrixAxes=np.column_stack([h, n, np.cross(h, n)]),
                               constrainedAxes=[1, 1, 1, 0, 0, 1], useGlobalFrame=True)  # fmt: skip
        mbs.CreateTorsionalSpringDamper(itemNumbers=[upper[0], fore[0]], position=list(E), axis=list(n),
                                        stiffness=v.elbow_stiffness, damping=v.elbow_damping,
                                        useGlobalFrame=True)  # fmt: skip
        _spring(
            mbs,
            bodies["torso"],
            E - hips,
            upper[0],
            E - upper[1],
            v.shoulder_stiffness,
            v.shoulder_damping,
            v.upper_arm_length,
        )
        _spring(mbs, bodies["bar"], E, fore[0], E - fore[1], v.wrist_stiffness, v.wrist_damping, v.forearm_length)
        mbs.CreateForce(itemNumber=bodies["bar"], loadVector=[v.hand_mass * g for g in gravity], localPosition=list(W))
    return bodies


def _rod(
    body: Any, mass: float, centre: float, inertia: float, start: np.ndarray, end: np.ndarray, along: float
) -> tuple[int, np.ndarray]:
    """(body, its mass centre) of a limb from start to end."""
    direction = (end - start) / np.linalg.norm(end - start)
    tensor = inertia * (np.eye(3) - np.outer(direction, direction)) + along * np.outer(direction, direction)
    place = start + centre * direction
    return body(mass, tensor, place), place


def _spring(
    mbs: Any,
    carrier: int,
    rest: np.ndarray,
    limb: int,
    elbow: np.ndarray,
    stiffness: float,
    damping: float,
    length: float,
) -> None:
    """A joint spring k |u - u_rest|^2 / 2 of a limb's direction u: between the elbow and where its
    carrier would hold it."""
    mbs.CreateCartesianSpringDamper(itemNumbers=[carrier, limb], localPosition0=list(rest), localPosition1=list(elbow),
                                    stiffness=[stiffness / length**2] * 3,
                                    damping=[damping / length**2] * 3)  # fmt: skip
