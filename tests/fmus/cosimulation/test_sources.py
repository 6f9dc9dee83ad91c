"""FMUs without inputs drive others: each coupling against the exact solution."""

import numpy as np
import pytest

import motofmi as mf
from fmus.cosimulation.cosimulate import cosimulate
from fmus.cosimulation.subsystems.fmu_subsystem import FmuSubsystem

AMPLITUDE, FREQUENCY, STEP, DURATION = 2.0, 6.0, 0.01, 1.0  # N.m, rad/s, s, s


class Wave(mf.Component):
    """A torque that varies as a sine of time."""

    torque = mf.output("N.m", "Torque")

    def equations(self, v, m):
        return {"torque": AMPLITUDE * m.sin(FREQUENCY * v.time)}


class Rotor(mf.Component):
    """A rotor with an inertia of 1 kg.m2."""

    torque = mf.input("N.m", "Torque")
    rate = mf.state("rad/s", "Rate")
    turning_rate = mf.output("rad/s", "Rate")

    def equations(self, v, m):
        return {"der(rate)": v.torque, "turning_rate": v.rate}


# Held over a step the torque is late by half of it. A line through former values, and the other forms of second order and
# above, miss at most the curvature of the torque within a step.
HELD = AMPLITUDE * STEP
CURVED = AMPLITUDE * (FREQUENCY * STEP) ** 2


@pytest.mark.parametrize("compiled", [True, False])
@pytest.mark.parametrize(("coupling", "bound"), [("jacobi", HELD), ("gauss_seidel", HELD), ("jacobi_linear", CURVED), ("jacobi_quadratic", CURVED), ("hermite", CURVED),
                                                 ("interface_jacobian", HELD), ("iterated", CURVED), ("implicit_hermite", CURVED)])  # fmt: skip
def test_a_source_drives_another_fmu_in_every_coupling(coupling, bound, compiled, tmp_path):
    wave, rotor = (mf.build(kind(), tmp_path).path for kind in (Wave, Rotor))
    with FmuSubsystem(wave, "wave") as source, FmuSubsystem(rotor, "rotor") as driven:
        run = cosimulate({"wave": source, "rotor": driven}, STEP, DURATION, coupling, wiring={"rotor.torque": ["wave.torque"]}, compiled=compiled)
    exact = AMPLITUDE / FREQUENCY * (1 - np.cos(FREQUENCY * run["time"]))
    assert np.abs(run["rotor.turning_rate"] - exact).max() < bound
    assert run["wave.torque"] == pytest.approx(AMPLITUDE * np.sin(FREQUENCY * run["time"]), abs=1e-12)
