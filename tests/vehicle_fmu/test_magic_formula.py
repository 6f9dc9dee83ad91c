"""The complete Magic Formula of the touring motorcycle against a second implementation, with combined slip."""

import numpy as np
import pytest

from tests.vehicle_fmu.test_touring_motorcycle import coefficients, magic_formula  # noqa: F401 - a fixture
from vehicle_fmu import motorcycles
from vehicle_fmu.large_motion.touring_tree import tyre

TUM = motorcycles.load("tum_2020")
RADII = [("front", 0.06), ("rear", 0.095)]


@pytest.mark.parametrize("end, radius", RADII)
def test_tyre_forces_are_those_of_a_second_implementation(coefficients, end, radius):  # noqa: F811
    own, generator = tyre(TUM, end), np.random.default_rng(0)
    for _ in range(40):
        load, slip, camber = generator.uniform(300, 2500), generator.uniform(-0.2, 0.2), generator.uniform(-0.9, 0.9)
        wanted = magic_formula(coefficients[end], radius, load, slip, camber)
        assert own.forces(load, slip, camber) == pytest.approx(wanted, rel=1e-12)  # rounding


def combined(c, radius, load, ratio, slip, camber):
    """(X, Y, M) of the motorcycle version with combined slip, from the coefficients of the file."""
    sin, cos, atan, sqrt, sign = np.sin, np.cos, np.arctan, np.sqrt, np.sign
    d = (load - c["Fz0"]) / c["Fz0"]
    Dx, Kx = (c["pDx1"] + c["pDx2"] * d) * load, load * (c["pKx1"] + c["pKx2"] * d) * np.exp(c["pKx3"] * d)
    Ex = (c["pEx1"] + c["pEx2"] * d + c["pEx3"] * d * d) * (1 - c["pEx4"] * sign(ratio))
    x = Kx / (c["Cx"] * Dx) * ratio
    alone = Dx * sin(c["Cx"] * atan(x - Ex * (x - atan(x))))
    X = cos(c["Cxal"] * atan(c["rBx1"] * cos(atan(c["rBx2"] * ratio)) * slip)) * alone
    factor = cos(c["Cyka"] * atan(c["rBy1"] * cos(atan(c["rBy2"] * (abs(slip) - c["rBy3"]))) * ratio))
    Y, _ = magic_formula(c, radius, load, slip, camber)
    upright, _ = magic_formula(c, radius, load, slip, 0.0)
    K = c["pKy1"] * c["Fz0"] * sin(c["pKy2"] * atan(load / (c["pKy3"] * c["Fz0"])))
    S = (c["qHz3"] + c["qHz4"] * d) * camber
    lat, lar = (sqrt(a * a + (Kx * ratio / K) ** 2) * sign(a) for a in (slip, slip + S))
    Bt = (c["qBz1"] + c["qBz2"] * d) * (1 + c["qBz5"] * abs(camber) + c["qBz6"] * camber**2)
    Dt = load * radius / c["Fz0"] * (c["qDz1"] + c["qDz2"] * d) * (1 + c["qDz3"] * abs(camber) + c["qDz4"] * camber**2)
    Et = (c["qEz1"] + c["qEz2"] * d) * (1 + c["qEz5"] * camber * 2 / np.pi * atan(Bt * c["Ct"] * slip))
    Dy = load * c["pDy1"] * np.exp(c["pDy2"] * d)
    Br = c["qBz9"] + c["qBz10"] * K / (c["Cy"] * Dy) * c["Cy"]
    Dr = load * radius * ((c["qDz8"] + c["qDz9"] * d) * camber + (c["qDz10"] + c["qDz11"] * d) * camber * abs(camber))
    trail = Dt * cos(c["Ct"] * atan(Bt * lat - Et * (Bt * lat - atan(Bt * lat)))) / sqrt(1 + slip**2)
    return X, factor * Y, -trail * factor * upright + Dr / sqrt(1 + slip**2) * cos(atan(Br * lar))


@pytest.mark.parametrize("end, radius", RADII)
def test_combined_slip_is_that_of_a_second_implementation(coefficients, end, radius):  # noqa: F811
    own, generator = tyre(TUM, end), np.random.default_rng(1)
    for _ in range(40):
        load, camber = generator.uniform(300, 2500), generator.uniform(-0.9, 0.9)
        ratio, slip = generator.uniform(-0.2, 0.2, 2)
        wanted = combined(coefficients[end], radius, load, ratio, slip, camber)
        found = own.longitudinal_force(load, ratio, slip), *own.forces(load, slip, camber, ratio)
        assert found == pytest.approx(wanted, rel=1e-11, abs=1e-9)  # rounding


@pytest.mark.parametrize("end, radius", RADII)
def test_characteristic_points(coefficients, end, radius):  # noqa: F811
    """Slope K_x = p_Kx1 Z_0 and peak p_Dx1 Z_0 at the nominal load; combined slip reduces both forces."""
    own, c = tyre(TUM, end), coefficients[end]
    load = own.nominal_load
    slope = (own.longitudinal_force(load, 1e-6, 0.0) - own.longitudinal_force(load, -1e-6, 0.0)) / 2e-6
    assert slope == pytest.approx(c["pKx1"] * load, rel=1e-6)  # differences
    forces = own.longitudinal_force(load, np.linspace(0, 0.6, 2000), 0.0)
    assert forces.max() == pytest.approx(c["pDx1"] * load, rel=1e-5)  # the grid's
    assert own.longitudinal_force(load, 0.05, 0.1) < own.longitudinal_force(load, 0.05, 0.0)
    assert own.forces(load, 0.05, 0.5, 0.1)[0] < own.forces(load, 0.05, 0.5)[0]
    left, right = own.forces(load, -0.05, -0.5, 0.1), own.forces(load, 0.05, 0.5, 0.1)
    assert left == pytest.approx([-x for x in right], rel=1e-12)  # mirrored
