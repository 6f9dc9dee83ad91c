"""Blind cases whose dominant effect is in no library, beside a weaker one that is in none either.

The machines and recordings are those of `real_like_cases`, whose simulation uses nothing of the library. A law F(q, s)
has a form that the workflow compares without naming it, or another form of the same kind:

    product             c q s          c tanh(q) s
    deflection          c q^2 s        c |q| s              damping that grows with the deflection
    rate                k q s^2        k q |s|              stiffness that grows with the rate
    thinning            -c s |s|       -c s (1 - exp(-s^2)) damping that falls with the rate

with q over the largest deflection and s over the largest rate.
"""

from collections.abc import Callable
from contextlib import suppress

import numpy as np

from tests.simulators.real_like_cases import SECONDS, SETTINGS, SHARES, Law, Machine, RealLikeCase, nothing, times

SIZES = (0.05, 0.2)  # of the driving torque's rms: the part of the law that no linear mechanism explains
LARGEST_LOSS = 0.9  # of the damping that thinning takes away
LARGEST_MOTION = 5.0  # times that of the linear mechanism
SMALLER = 0.7  # factor on a size with which the motion grows beyond that
LAWS: dict[str, Callable[[float, float], float]] = {  # relative deflection and rate -> relative torque
    "product": lambda q, s: q * s,
    "deflection": lambda q, s: q**2 * s,
    "rate": lambda q, s: q * s**2,
    "thinning": lambda q, s: -s * abs(s),
    "blunt_product": lambda q, s: np.tanh(q) * s,
    "blunt_deflection": lambda q, s: abs(q) * s,
    "blunt_rate": lambda q, s: q * abs(s),
    "blunt_thinning": lambda q, s: -s * (1 - np.exp(-(s**2))),
}
FORMS = {"product": {"product"}, "deflection": {"damping_by_deflection"}, "rate": {"stiffness_by_rate"},
         "thinning": {"thinning", "cubic_thinning"}}  # fmt: skip # of the library, by the kind of a law


def kind_of(law: str) -> str:
    """The kind of a law, without its form."""
    return law.removeprefix("blunt_")


class OutsideMachine(Machine):
    """A machine with a law that is in no library, and a second effect of a share of its size.

    size is the part of the law's torque that no linear mechanism explains, over the driving torque (both rms). Raises
    ValueError where the motion grows beyond bounds: some of the laws supply energy.
    """

    law: Law = staticmethod(nothing)

    def __init__(self, rng: np.random.Generator, setting: str, law: str, second: str, share: float, size: float):
        super().__init__(rng, setting, "none", "none", 0.0)
        drive, relative = self.drive(rng), LAWS[law]
        linear, unit = self.motion(drive), lambda q, s, z, t: (relative(q / self.angle, s / self.rate), 0.0)
        factor = size * linear[2].std() / self.beyond_linear(linear, unit)
        most = LARGEST_LOSS * self.p["c"] * self.rate if kind_of(law) == "thinning" else np.inf
        self.law = times(min(factor, most), unit)
        beyond = self.beyond_linear(self.motion(drive), self.law)
        other = SECONDS[second](self.angle, self.rate, self.duration, self.p)
        self.second = times(share * beyond / self.beyond_linear(linear, other), other)

    def _first_law(self, q: float, s: float, z: float, t: float) -> tuple[float, float]:
        return self.law(q, s, z, t)

    def motion(self, drive: Callable[..., np.ndarray]) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Deflection, rate and driving torque (n,) on the fine grid."""
        with np.errstate(all="ignore"):
            made = super().motion(drive)
        if not np.max(np.abs(made[0])) < LARGEST_MOTION * self.angle:
            raise ValueError("the motion grows beyond bounds")
        return made


def draw_outside(number: int, seed: int) -> RealLikeCase:
    """The case of that number."""
    rng = np.random.default_rng([seed, number])
    law = list(LAWS)[number % len(LAWS)]
    setting = SETTINGS[int(rng.integers(len(SETTINGS)))]
    second = list(SECONDS)[int(rng.integers(len(SECONDS)))]
    share = float(np.exp(rng.uniform(*np.log(SHARES))))
    jitter = ("sampling", "stamps")[int(rng.integers(2))]
    size = float(np.exp(rng.uniform(*np.log(SIZES))))
    while True:
        with suppress(ValueError):
            machine = OutsideMachine(rng, setting, law, second, share, size)
            fitted, validation = (machine.recorded(rng, part, jitter) for part in (1.0, rng.uniform(0.6, 1.1)))
            near = {n: machine.p[n] * float(np.exp(0.5 * rng.normal())) for n in ("J", "k", "c")}
            return RealLikeCase(number, law, second, share, setting, jitter, fitted, validation, near)
        size *= SMALLER
