"""Hysteresis and relaxation of springs, as differential equations with states of their own.

    Dahl        w z' = d' - |d'| z                                             (Dahl 1968)
    Bouc-Wen    w z' = d' - (|d'| |z|^(n-1) z + d' |z|^n) / 2                  (Wen 1976)
    Jenkins     the same with n = 8: a spring in series with a slider; n may also be fitted
    shaped      w z' = d' - |d'| z + s d' |z|,   stiffening for s > 1         (Bouc-Wen with n = 1)
    Iwan        three of them with different widths                            (Iwan 1966)
    Maxwell     tau z' = d - z,   F = k (d - z): a spring and a damper in series

z is the force of the sticking part relative to its maximum, w the deflection at which it slides.
"""

from typing import ClassVar

from fmus.declaration.variables import parameter, state
from fmus.effects.effect import Effect, adds_to

SHARP = 8  # exponent at which the Bouc-Wen model is close to a spring in series with a slider
SMALLEST = 1e-12  # added to |z|: the derivative of a power with respect to its exponent has a logarithm
NARROWEST = 0.01  # share of the largest deflection; a loop that closes within less is dry friction


def bouc_wen(d_rate, z, n, m):
    """w z' of the Bouc-Wen model; |z| is limited to 1 in the power, so that intermediate steps of a solver stay
    finite.
    """
    limited = m.where(m.absolute(z) < 1.0, m.absolute(z) + SMALLEST, 1.0 + 0.0 * z)
    return d_rate - (m.absolute(d_rate) * limited ** (n - 1) * z + d_rate * limited**n) / 2


class DahlHysteresis(Effect):
    """The force lags behind the deflection: hysteresis with a smooth loop."""

    family, form, element = "hysteresis", "dahl", "spring"
    both_ways: ClassVar = True
    force = parameter("N.m", "Largest force of the sticking part", symbol="F_h", min=0, start=1.0)
    width = parameter("rad", "Deflection at which the loop has closed", symbol="w", min=1e-6, start=0.02)
    sticking = state("1", "Force of the sticking part relative to its maximum", symbol="z")
    starts: ClassVar = {"width": (0.03, 0.1, 0.3, 1.0)}
    initial_deviations: ClassVar = {"sticking": 1.0}
    relative: ClassVar = ("width",)
    at_least: ClassVar = {"width": NARROWEST}

    def loop(self, v, m):
        """w z' of the model (see the module's docstring)."""
        return v.rate - m.absolute(v.rate) * v.sticking

    @adds_to("der(sticking)")
    def stick(self, v, m):
        return self.loop(v, m) / v.width

    @adds_to("force")
    def lag(self, v, m):
        return v.force * v.sticking


class BoucWenHysteresis(DahlHysteresis):
    """The force lags behind the deflection: hysteresis with a rounded loop."""

    form = "bouc_wen"

    def loop(self, v, m):
        """w z' of the model (see the module's docstring)."""
        return bouc_wen(v.rate, v.sticking, 2, m)


class JenkinsHysteresis(DahlHysteresis):
    """The force lags behind the deflection: a spring in series with a slider."""

    form = "jenkins"

    def loop(self, v, m):
        """w z' of the model (see the module's docstring)."""
        return bouc_wen(v.rate, v.sticking, SHARP, m)


class ShapedHysteresis(DahlHysteresis):
    """The force lags behind the deflection: hysteresis whose loop softens or stiffens as it opens."""

    form = "shaped"
    shape = parameter(
        "1", "Stiffening of the sticking part under load; 0 is Dahl's model", symbol="s", min=-1, max=2, start=1.0
    )
    starts: ClassVar = {"width": (0.3, 1.0), "shape": (1.3,)}
    initial_deviations: ClassVar = {}  # a loop that stiffens is not bounded

    def loop(self, v, m):
        """w z' of the model (see the module's docstring)."""
        return super().loop(v, m) + v.shape * v.rate * m.absolute(v.sticking)


class SharpenedHysteresis(DahlHysteresis):
    """The force lags behind the deflection: hysteresis with a loop of free sharpness."""

    form, flexible = "sharpened", True
    sharpness = parameter(
        "1",
        "Exponent of the Bouc-Wen model: 2 is rounded, 8 a spring in series with a slider",
        symbol="n",
        min=1,
        max=20,
        start=4.0,
    )
    starts: ClassVar = {"width": (0.1, 0.3, 1.0), "sharpness": (4.0,)}

    def loop(self, v, m):
        """w z' of the model (see the module's docstring)."""
        return bouc_wen(v.rate, v.sticking, v.sharpness, m)


class IwanHysteresis(Effect):
    """The force lags behind the deflection: sliders of several widths."""

    family, form, element, flexible = "hysteresis", "iwan", "spring", True
    both_ways: ClassVar = True
    force = parameter("N.m", "Largest force of the narrow slider", symbol="F_1", min=0, start=1.0)
    middle_force = parameter("N.m", "Largest force of the middle slider", symbol="F_2", min=0, start=1.0)
    wide_force = parameter("N.m", "Largest force of the wide slider", symbol="F_3", min=0, start=1.0)
    width = parameter(
        "rad",
        "Deflection at which the narrow slider slides; the others at three and nine times",
        symbol="w",
        min=1e-6,
        start=0.01,
    )
    narrow = state("1", "Narrow slider")
    middle = state("1", "Middle slider")
    wide = state("1", "Wide slider")
    starts: ClassVar = {"width": (0.03, 0.1, 0.3)}
    initial_deviations: ClassVar = {"narrow": 1.0, "middle": 1.0, "wide": 1.0}
    relative: ClassVar = ("width",)
    at_least: ClassVar = {"width": NARROWEST}

    @adds_to("der(narrow)")
    def stick_narrow(self, v, m):
        return bouc_wen(v.rate, v.narrow, 2, m) / v.width

    @adds_to("der(middle)")
    def stick_middle(self, v, m):
        return bouc_wen(v.rate, v.middle, 2, m) / (3 * v.width)

    @adds_to("der(wide)")
    def stick_wide(self, v, m):
        return bouc_wen(v.rate, v.wide, 2, m) / (9 * v.width)

    @adds_to("force")
    def lag(self, v, m):
        return v.force * v.narrow + v.middle_force * v.middle + v.wide_force * v.wide


class ViscoelasticArm(Effect):
    """A spring in series with a damper acts in parallel (Maxwell element): the stiffness depends on the rate."""

    family, form, element = "viscoelastic_arm", "maxwell", "spring"
    series_stiffness = parameter(
        "N.m/rad", "Stiffness of the spring in series with a damper", symbol="k_m", min=0, start=100.0
    )
    relaxation_time = parameter("s", "Damping over stiffness of that branch", symbol="t_m", min=1e-3, max=10, start=0.1)
    relaxed = state("rad", "Deflection of the damper in series", symbol="z")
    starts: ClassVar = {"relaxation_time": (0.01, 0.03, 0.1, 0.3)}
    times: ClassVar = ("relaxation_time",)

    @adds_to("der(relaxed)")
    def flow(self, v, m):
        return (v.deflection - v.relaxed) / v.relaxation_time

    @adds_to("force")
    def branch(self, v, m):
        return v.series_stiffness * (v.deflection - v.relaxed)
