"""The side force of a tyre follows its slip over another distance than the base has it.

    (sigma / V) Y' + Y = C_1 alpha + C_2 gamma

Source: Pacejka, Tire and Vehicle Dynamics (2006), ch. 7; measured lengths of motorcycle tyres differ by a factor of two
with load and carcass (Sharp, Evangelou, Limebeer, Multibody Syst. Dyn. 12 (2004) 251-283).
"""

from fmus import Effect, adds_to, parameter


class TyreRelaxation(Effect):
    """Both tyres relax over another length than the base has it."""

    family, form = "tyre_relaxation", "both"
    length = parameter("m", "Relaxation length beyond the base's", symbol=r"\Delta\sigma", min=-0.2, max=5, start=0.1)

    @adds_to("front_relaxation_length")
    def front(self, v, m):
        return v.length

    @adds_to("rear_relaxation_length")
    def rear(self, v, m):
        return v.length


class FrontRelaxation(Effect):
    """The front tyre relaxes over another length than the base has it."""

    family, form = "tyre_relaxation", "front"
    length = parameter("m", "Relaxation length beyond the base's", symbol=r"\Delta\sigma", min=-0.2, max=5, start=0.1)

    @adds_to("front_relaxation_length")
    def front(self, v, m):
        return v.length


class RearRelaxation(Effect):
    """The rear tyre relaxes over another length than the base has it."""

    family, form = "tyre_relaxation", "rear"
    length = parameter("m", "Relaxation length beyond the base's", symbol=r"\Delta\sigma", min=-0.2, max=5, start=0.1)

    @adds_to("rear_relaxation_length")
    def rear(self, v, m):
        return v.length
