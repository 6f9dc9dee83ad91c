"""Relaxation lengths of the tyres that differ from those of the base.

    (sigma / V) Y' + Y = C_1 alpha + C_2 gamma

Source: Pacejka, Tire and Vehicle Dynamics (2006), ch. 7; measured lengths of motorcycle tyres differ by a factor of two
with load and carcass (Sharp, Evangelou, Limebeer, Multibody Syst. Dyn. 12 (2004) 251-283).
"""

from fmus import Effect, adds_to, parameter


class TyreRelaxation(Effect):
    """The relaxation lengths of both tyres differ from those of the base."""

    family, form = "tyre_relaxation", "both"
    length = parameter("m", "Relaxation length beyond the base's", symbol=r"\Delta\sigma", min=-0.2, max=5, start=0.1)

    @adds_to("front_relaxation_length")
    def front(self, v, m):
        return v.length

    @adds_to("rear_relaxation_length")
    def rear(self, v, m):
        return v.length


class FrontRelaxation(Effect):
    """The relaxation length of the front tyre differs from that of the base."""

    family, form = "tyre_relaxation", "front"
    length = parameter("m", "Relaxation length beyond the base's", symbol=r"\Delta\sigma", min=-0.2, max=5, start=0.1)

    @adds_to("front_relaxation_length")
    def front(self, v, m):
        return v.length


class RearRelaxation(Effect):
    """The relaxation length of the rear tyre differs from that of the base."""

    family, form = "tyre_relaxation", "rear"
    length = parameter("m", "Relaxation length beyond the base's", symbol=r"\Delta\sigma", min=-0.2, max=5, start=0.1)

    @adds_to("rear_relaxation_length")
    def rear(self, v, m):
        return v.length
