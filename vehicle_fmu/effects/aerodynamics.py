r"""Aerodynamic forces in proportion to the square of the speed.

    load     Z_f -> Z_f + kappa V^2 (less load, as z is down), tyre forces in proportion to the loads:
             C_f -> C_f (1 - kappa V^2 / |Z_f|),   C_r -> C_r (1 + kappa V^2 / Z_r),   Z_r = (M_f + M_r) g - |Z_f|
    drift    a side force -lambda V v at the height h_a, x_a ahead of the origin, from the angle of incidence v / V
             lateral -lambda V w,  yaw -x_a lambda V w,  roll -h_a lambda V w,   w = v + x_a r + h_a p

kappa collects drag (rho C_D A / 2 times its height over the wheelbase) and lift (rho C_L A / 2 times its share on the
front). w is the lateral velocity of the centre of pressure.

Source: Cooper, Motorcycle Aerodynamics, SAE 740628 (1974); Sharp, Evangelou, Limebeer, Multibody Syst. Dyn. 12 (2004)
251-283, Sect. 2.
"""

from typing import ClassVar

from fmus import Effect, adds_to, parameter


class LoadTransfer(Effect):
    """Drag and lift take load off the front wheel in proportion to the square of the speed."""

    family, form = "aerodynamics", "load"
    load = parameter(
        "kg/m", "Load taken off the front wheel per squared speed", symbol=r"\kappa", min=0, max=2, start=0.1
    )

    @adds_to("front_tyre_load")
    def lifts(self, v, m):
        return v.load * v.speed**2

    @staticmethod
    def on_front(v):
        """Relative change of the load on the front tyre."""
        return v.load * v.speed**2 / (v.front_tyre_load - v.load * v.speed**2)

    @staticmethod
    def on_rear(v):
        """Relative change of the load on the rear tyre."""
        static = (v.front_mass + v.rear_mass) * v.gravity + v.front_tyre_load - v.load * v.speed**2
        return v.load * v.speed**2 / static

    @adds_to("front_cornering_stiffness")
    def front_slip(self, v, m):
        return v.front_cornering_stiffness * self.on_front(v)

    @adds_to("front_camber_stiffness")
    def front_camber(self, v, m):
        return v.front_camber_stiffness * self.on_front(v)

    @adds_to("rear_cornering_stiffness")
    def rear_slip(self, v, m):
        return v.rear_cornering_stiffness * self.on_rear(v)

    @adds_to("rear_camber_stiffness")
    def rear_camber(self, v, m):
        return v.rear_camber_stiffness * self.on_rear(v)


class SideForce(Effect):
    """A side force opposes the lateral velocity, in proportion to the speed."""

    family, form = "aerodynamics", "drift"
    drag = parameter("kg/m", "Side force per speed and side velocity", symbol=r"\lambda", min=0, max=20, start=0.5)
    height = parameter("m", "Centre of pressure above the ground", symbol="h_a", min=0, max=2, start=0.7)
    advance = parameter("m", "Centre of pressure ahead of the origin", symbol="x_a", min=-1, max=1.5, start=0.2)
    starts: ClassVar = {"height": (0.7,), "advance": (-0.2, 0.4)}

    @staticmethod
    def force(v):
        """The side force [N]."""
        return -v.drag * v.speed * (v.lateral_velocity + v.advance * v.yaw_rate + v.height * v.roll_rate)

    @adds_to("der(lateral_velocity)")
    def pushes(self, v, m):
        return self.force(v)

    @adds_to("der(yaw_rate)")
    def yaws(self, v, m):
        return v.advance * self.force(v)

    @adds_to("der(roll_rate)")
    def rolls(self, v, m):
        return v.height * self.force(v)
