"""Rider and handlebar on the rig as a two-degree-of-freedom system: frequencies and damping ratios of the 2008 paper.

    M = [I_s I_cc; I_cc I_t],   K = [k_a -k_a; -k_a k_a + k_t],   C likewise with c_a, c_t
    nu_1, nu_2 = sqrt(eig(M^-1 K)) / 2 pi        undamped; 2008, Table 2
    zeta_1, zeta_2 = -Re(lambda) / |lambda|      of the damped pairs; none for two real roots
    nu_t, zeta_t                                 the torso with the steer locked; 2011, eqs 8, 9

Source: Cossalter, Doria, Fabris, Maso (2008), eqs 3, 4; Cossalter, Doria, Lot, Massaro, Meccanica 46 (2011).
"""

from math import pi

import numpy as np

from fmus import Component, System, linearise
from rider_fmu.components.passive_rider import PassiveRider, locked_steer_mode
from rider_fmu.rigs.handlebar import Handlebar

DERIVED_UNITS = {
    "nu1": "Hz",
    "nu2": "Hz",
    "zeta1": "1",
    "zeta2": "1",
    "nu_t": "Hz",
    "zeta_t": "1",
    "added_steer_inertia": "kg.m2",
}


def derived(rider: PassiveRider, steer_inertia: float, handlebar_inertia: float) -> dict[str, float | None]:
    """nu1, nu2, nu_t [Hz], zeta1, zeta2, zeta_t [1] (None where overdamped) and added_steer_inertia [kg.m2].

    steer_inertia is that of the test, the rider's share included; handlebar_inertia that of the bare bar.
    """
    undamped = rider.with_values(arm_damping=0.0, waist_damping=0.0)
    nu1, nu2 = np.sort(np.abs(_roots(undamped, steer_inertia).imag))[::2] / (2 * pi)
    zeta1, zeta2 = _damping_ratios(_roots(rider, steer_inertia))
    nu_t, zeta_t = locked_steer_mode(rider)
    return {"nu1": float(nu1), "nu2": float(nu2), "zeta1": zeta1, "zeta2": zeta2, "nu_t": nu_t, "zeta_t": zeta_t,
            "added_steer_inertia": steer_inertia - handlebar_inertia}  # fmt: skip


def _roots(rider: Component, steer_inertia: float) -> np.ndarray:
    """The eigenvalues (4,) [1/s] of rider and bar; the inertia of the bar is reduced by the cross inertia of the
    rider.
    """
    reduced = steer_inertia - rider.values["cross_inertia"] ** 2 / rider.values["torso_inertia"]
    return np.linalg.eigvals(
        linearise(System("rig", {"bar": Handlebar("bar", steer_inertia=reduced), "rider": rider})).A
    )


def _damping_ratios(roots: np.ndarray) -> tuple[float | None, float | None]:
    """Damping ratios of the two pairs by rising |lambda|; two real roots a, b count as a pair with |lambda| = sqrt(a
    b).
    """
    pairs = roots[roots.imag > 0]
    ratios: list[tuple[float, float | None]] = [(abs(r), float(-r.real / abs(r))) for r in pairs]
    real = np.sort(-roots[roots.imag == 0].real)
    ratios += [(float(np.sqrt(a * b)), None) for a, b in zip(real[::2], real[1::2], strict=True)]
    (_, zeta1), (_, zeta2) = sorted(ratios, key=lambda pair: pair[0])
    return zeta1, zeta2
