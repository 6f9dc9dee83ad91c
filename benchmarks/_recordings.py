"""Recordings of real machines whose missing effects are known: sources, files, and what is published of them.

The recordings belong to others and are not part of the project. Their folder is given by --data or by the environment
variable MOTOFMI_MEASURED; those that are not there are skipped, with the command that gets them.
"""

import os
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

DATA = "MOTOFMI_MEASURED"
HERE = Path(__file__).parent
MOTOR = "time [s],angle [rad],rate [rad/s],torque [N.m]"
JOINT, MASS = "time [s],torque [N.m],angle [rad]", "time [s],force [N],displacement [m]"

# The rigid-body model of the bicycle by its authors (mechmotum/sbw_bicycle_with_model_matching).
BICYCLE = """
A0 = [[0, 0, 1, 0], [0, 0, 0, 1], [13.5934863142, -0.438988101746, 0, 0], [2.4476559527, 23.0914910644, 0, 0]]
A1 = [[0, 0, 0, 0], [0, 0, 0, 0], [0, 0, -0.187133919764, -0.539355760804], [0, 0, 3.82992579518, -3.18311895912]]
A2 = [[0, 0, 0, 0], [0, 0, 0, 0], [0, -1.29589144233, 0, 0], [0, -0.86139430207, 0, 0]]
B = [[0, 0], [0, 0], [0.0953640872087, -0.454498760802], [-0.454498760802, 9.30187605789]]
source = "github.com/mechmotum/sbw_bicycle_with_model_matching"
"""


@dataclass(frozen=True)
class Published:
    """A published value of a parameter, with the ends of its range."""

    parameter: str
    low: float
    high: float

    def __str__(self) -> str:
        return f"{self.low:g}" if self.low == self.high else f"{self.low:g} to {self.high:g}"


@dataclass(frozen=True)
class Source:
    """Where a recording is from, its files in the folder of data, and the options with which it is used.

    fitted and validation are files, or parts (samples) of the one fitted file. columns is the heading with which the
    files are written anew, `use` the columns that are kept, and factors what these are multiplied with. known are the
    families that are missing.
    """

    repository: str
    fitted: Sequence[str]
    validation: Sequence[str]
    known: frozenset[str]
    component: str = ""
    impose: str = ""
    options: Sequence[str] = ()
    published: Published | None = None
    columns: str = ""
    use: Sequence[int] | None = None
    factors: Mapping[int, float] = field(default_factory=dict)
    parts: tuple[slice, slice] | None = None
    vehicle: str = ""

    def files(self, folder: Path, into: Path) -> tuple[list[Path], list[Path]]:
        """The fitted and the validation files: those of the folder or, where columns or parts are given, new ones."""
        groups = [[folder / name for name in names] for names in (self.fitted, self.validation)]
        if self.parts:
            return tuple([self._written(groups[0][0], into / f"{name}.csv", part)] for name, part in
                         zip(("fitted", "validation"), self.parts, strict=True))  # type: ignore[return-value]  # fmt: skip
        if self.columns:
            groups = [[self._written(path, into / f"{i}_{path.name}") for path in group] for i, group in enumerate(groups)]
        return groups[0], groups[1]

    def _written(self, path: Path, to: Path, part: slice = slice(None)) -> Path:
        rows = np.loadtxt(path, delimiter=",", skiprows=1, usecols=self.use)[part]
        for column, factor in self.factors.items():
            rows[:, column] *= factor
        np.savetxt(to, rows, "%.10g", ",", header=self.columns, comments="")
        return to

    def command(self, folder: Path, into: Path) -> list[str]:
        """The arguments of `motofmi gap`."""
        fitted, validation = self.files(folder, into)
        found = [*map(str, fitted), "--holdout", *map(str, validation), *self.options]
        if self.vehicle:
            (into / "vehicle.toml").write_text(self.vehicle)
            found += ["--vehicle", str(into / "vehicle.toml")]
        found += ["--component", self.component] if self.component else []
        return [*found, "--impose", self.impose] if self.impose else found


def _emps(suffix: str, impose: str = "") -> Source:
    files = [f"emps/{name}{suffix}.csv" for name in ("run", "pulses")]
    return Source("forgi86/sysid-neural-continuous", files[:1], files[1:], frozenset({"coulomb_friction"}), "mass_spring_damper",
                  impose, published=Published("coulomb_friction.friction_torque", 20.4, 20.4))  # fmt: skip


def _motor_pendulum(component: str, known: Sequence[str], published: Published | None = None) -> Source:
    files = [f"torque_limited_simple_pendulum/results/control_method_{name}/data_measured.csv"
             for name in ("ddp", "direct_collocation")]  # fmt: skip
    return Source("dfki-ric-underactuated-lab/torque_limited_simple_pendulum", files[:1], files[1:], frozenset(known), component,
                  published=published, columns=MOTOR)  # fmt: skip


def _swings(component: str, known: Sequence[str], published: Published | None = None) -> Source:
    return Source("dynamicslab/MultiArm-Pendulum", [f"multiarm_pendulum/swing_{i}.csv" for i in range(1, 5)],
                  [f"multiarm_pendulum/validation_{i}.csv" for i in (1, 2)], frozenset(known), component,
                  published=published)  # fmt: skip


SINE = Published("geometric_nonlinearity.share", 1, 1)
SOURCES = {
    "EMPS, displacement imposed": _emps("", "displacement"),
    "EMPS, force in": _emps(""),
    "EMPS at 1 kHz, displacement imposed": _emps("_1kHz", "displacement"),
    "EMPS at 1 kHz, force in": _emps("_1kHz"),
    "Silverbox": Source(
        "biaslab/nsi-silverbox", ["silverbox/whole.csv"], [], frozenset({"hardening_stiffness"}), "mass_spring_damper",
        published=Published("hardening_stiffness.cubic_stiffness", 3.99, 3.99), columns=MASS,
        parts=(slice(40650, 44746), slice(110000, 114096)),
    ),
    "filmed pendulum": Source(
        "erwincoumans/tiny-differentiable-simulator", ["pendulum_camera/pendulum_first.csv"],
        ["pendulum_camera/pendulum_second.csv"], frozenset({"geometric_nonlinearity"}), "pendulum", published=SINE,
    ),
    "four swings": _swings("pendulum", ["geometric_nonlinearity"], SINE),
    "four swings, sine in the base": _swings(f"{HERE / '_sine_pendulum.py'}:SinePendulum",
                                             ["coulomb_friction", "progressive_damping"]),
    "swing-up by a motor": _motor_pendulum("pendulum", ["geometric_nonlinearity", "coulomb_friction"], SINE),
    "swing-up by a motor, sine in the base": _motor_pendulum(f"{HERE / '_sine_pendulum.py'}:SinePendulum", ["coulomb_friction"]),
    "motor against gravity, angle imposed": Source(
        "dfki-ric-underactuated-lab/torque_limited_simple_pendulum",
        ["torque_limited_simple_pendulum/results/control_method_gravity_compensation/data_measured.csv"], [],
        frozenset({"geometric_nonlinearity"}), "pendulum", "angle", published=SINE, columns=MOTOR,
        parts=(slice(0, 20000), slice(20000, None)),
    ),
    "joint of a robot arm, angle imposed": Source(
        "longshike/NNFM-A-Novel-Neural-Network-Modeling-Approach-for-Robot-Flexible-Joints-Friction",
        ["franka_joint/case3_middle.csv"], ["franka_joint/case3_slow.csv"], frozenset({"coulomb_friction"}), "driven_joint",
        "angle", published=Published("coulomb_friction.friction_torque", 0.334, 0.334),
        columns="time [s],angle [rad],torque [N.m]", use=(0, 1, 4),
    ),
    "wrist of a robot arm, angle imposed": Source(
        "shamilmamedov/dynamic_calibration", ["robot_wrist/ur-20_01_22-joint_4.csv"], [],
        frozenset({"geometric_nonlinearity", "coulomb_friction"}), "driven_joint", "angle",
        columns="time [s],angle [rad],torque [N.m]", use=(0, 4, 16), factors={2: 10.0},  # N.m/A, nominal
        parts=(slice(0, 3144), slice(3144, None)),
    ),
    "banded friction damper": Source(
        "ARTS-Laboratory/Dataset-Friction-Damper-with-Backlash", ["friction_damper/0.5Hz35lbtension.csv"],
        ["friction_damper/1Hz35lbtension.csv"], frozenset({"hysteresis"}), "mass_spring_damper", "displacement",
    ),
    "magnetorheological damper": Source(
        "DanielMaurelE/vRTHS_AMBC_MRdamper", ["mr_damper/10mm1Hz1A.csv"], ["mr_damper/25mm0p5Hz1A.csv"],
        frozenset({"coulomb_friction"}), "mass_spring_damper", "displacement",
    ),
    "steering motor": Source(
        "mfeingesicht/chalmers_matlab", [f"bicycle_steering_motor/{f}Hz.csv" for f in ("0.5", "1", "2")],
        ["bicycle_steering_motor/5Hz.csv"], frozenset({"coulomb_friction"}), "driven_joint",
        published=Published("coulomb_friction.friction_torque", 0.5, 0.6), columns=JOINT, factors={1: 3.03},
    ),
    "steer-by-wire bicycle": Source(
        "mechmotum/sbw_bicycle_with_model_matching",
        [f"steer_by_wire_bicycle/{n}.csv" for n in ("bode_4mps_1.0Hz", "bode_4mps_1.8Hz", "bode_4mps_2.6Hz",
                                                    "free_7.2kph", "free_16.2kph")],
        [f"steer_by_wire_bicycle/{n}.csv" for n in ("bode_4mps_1.4Hz", "bode_4mps_2.2Hz", "free_12.6kph")],
        frozenset({"coulomb_friction"}), options=("--free", "all"), vehicle=BICYCLE,
    ),
}  # fmt: skip


def folder_of_data(given: str | Path | None) -> Path | None:
    """The folder of recordings, as given or as the environment variable says."""
    name = given or os.environ.get(DATA)
    return Path(name) if name else None


def missing(folder: Path | None, source: Source) -> str:
    """Why a recording cannot be used, and how to get it; empty where it is there."""
    absent = [name for name in (*source.fitted, *source.validation) if folder is None or not (folder / name).exists()]
    if not absent:
        return ""
    where = f"{folder} has no {absent[0]}" if folder else f"no folder of data (--data DIR, or {DATA})"
    return (f"skipped: {where}; git clone https://github.com/{source.repository}, and write the columns with their units as "
            f"{', '.join(absent)}")  # fmt: skip
