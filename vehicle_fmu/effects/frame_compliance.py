r"""The front frame twists at the steering head: an axis x_s across the steer axis, fixed in the rear frame.

With c = cos(eps), S = sin(eps), the lengths a, e, f, t, k, j and the moment G of the motorcycle, and the twist axis at
the height z_t above the foot of a, along the steer axis, the twist beta moves the front mass centre by n and the front
contact by n_c (to the right, per radian), turns the wheel by -S and tilts it by c:

    n = f - z_t,     n_c = -((a - t) S / c + z_t),     Q = M_f n g + Z_f n_c
    lateral  ... + M_f n b'
    yaw      ... + (M_f k n - I_fx S + I_fxz c) b' - h_f c b
    roll     ... + (M_f j n + I_fx c + I_fxz S) b' - h_f S b - Q beta
    steer    ... + (M_f e n + I_fxz) b' - h_f b - G c beta
    twist    the same column as row, + (I_fx + M_f n^2) b' + M_f n V r + h_f (p S + r c + s)
             - Q (phi + c beta) - G c delta                                  = n_c Y_f - beta / C - d b
    slip     alpha_f ... - S beta - n_c b / V         camber ... + c beta          (b = beta')

C is the compliance, d the damping. As the axis does not turn with the steer, the moments of weight and load are
symmetric in beta and delta.

Source: the degree of freedom is that of Sharp, Alstead, Vehicle Syst. Dyn. 9 (1980) 327-357, and Spierings, ibid. 10
(1981) 21-35; the equations are of this project and are verified by a derivation with Kane's equations in the tests.
"""

from typing import ClassVar

from fmus import Effect, adds_to, parameter, state


class FrameCompliance(Effect):
    """The front frame twists at the steering head."""

    family, form = "frame_compliance", "twist"
    compliance = parameter("rad/N.m", "Twist per torque", symbol="C", min=1e-8, max=1e-2, start=2e-5)
    damping = parameter("N.m.s/rad", "Damping of the twist", symbol="d", min=0, max=1e4, start=20.0)
    height = parameter(
        "m",
        "Twist axis above the foot of the steer axis distance, along the steer axis",
        symbol="z_t",
        min=-1,
        max=2,
        start=0.4,
    )
    twist = state("rad", "Twist of the front frame, tilting it to the right positive", symbol=r"\beta")
    twist_rate = state("rad/s", "Rate of the twist", symbol="b")
    starts: ClassVar = {"damping": (20.0,), "height": (0.1, 0.5)}

    @staticmethod
    def centre(v):
        """n: displacement of the front mass centre per twist [m]."""
        return v.front_mass_rise - v.height

    @staticmethod
    def contact(v, m):
        """n_c: displacement of the front contact per twist [m]."""
        return -((v.steer_axis_distance - v.trail) * m.tan(v.caster_angle) + v.height)

    def weight(self, v, m):
        """Q: moment of weight and tyre load per twist [N.m/rad]."""
        return v.front_mass * v.gravity * self.centre(v) + v.front_tyre_load * self.contact(v, m)

    @adds_to("mass(twist_rate, twist_rate)")
    def with_itself(self, v, m):
        return v.front_cross_inertia + v.front_mass * self.centre(v) ** 2 - 1.0  # a state's entry is 1 before

    @adds_to("mass(twist_rate, lateral_velocity)", "mass(lateral_velocity, twist_rate)")
    def with_lateral(self, v, m):
        return v.front_mass * self.centre(v)

    @adds_to("mass(twist_rate, yaw_rate)", "mass(yaw_rate, twist_rate)")
    def with_yaw(self, v, m):
        c, S = m.cos(v.caster_angle), m.sin(v.caster_angle)
        return (
            v.front_mass * v.front_mass_distance * self.centre(v)
            - v.front_cross_inertia * S
            + v.front_product_of_inertia * c
        )

    @adds_to("mass(twist_rate, roll_rate)", "mass(roll_rate, twist_rate)")
    def with_roll(self, v, m):
        c, S = m.cos(v.caster_angle), m.sin(v.caster_angle)
        return (
            v.front_mass * v.front_mass_height * self.centre(v)
            + v.front_cross_inertia * c
            + v.front_product_of_inertia * S
        )

    @adds_to("mass(twist_rate, steer_rate)", "mass(steer_rate, twist_rate)")
    def with_steer(self, v, m):
        return v.front_mass * v.front_mass_offset * self.centre(v) + v.front_product_of_inertia

    @adds_to("der(twist)")
    def turns(self, v, m):
        return v.twist_rate

    @adds_to("der(twist_rate)")
    def twists(self, v, m):
        c, S = m.cos(v.caster_angle), m.sin(v.caster_angle)
        spin = v.front_spin_momentum * (v.roll_rate * S + v.yaw_rate * c + v.steer_rate)
        falls = self.weight(v, m) * (v.roll_angle + c * v.twist) + v.tilt_moment * c * v.steer_angle
        turning = v.front_mass * self.centre(v) * v.speed * v.yaw_rate
        return (
            self.contact(v, m) * v.front_side_force
            + falls
            - spin
            - turning
            - v.twist / v.compliance
            - v.damping * v.twist_rate
        )

    @adds_to("der(yaw_rate)")
    def on_yaw(self, v, m):
        return v.front_spin_momentum * m.cos(v.caster_angle) * v.twist_rate

    @adds_to("der(roll_rate)")
    def on_roll(self, v, m):
        return v.front_spin_momentum * m.sin(v.caster_angle) * v.twist_rate + self.weight(v, m) * v.twist

    @adds_to("der(steer_rate)")
    def on_steer(self, v, m):
        return v.front_spin_momentum * v.twist_rate + v.tilt_moment * m.cos(v.caster_angle) * v.twist

    @adds_to("front_slip_angle")
    def slips(self, v, m):
        return -m.sin(v.caster_angle) * v.twist - self.contact(v, m) * v.twist_rate / v.speed

    @adds_to("front_camber_angle")
    def leans(self, v, m):
        return m.cos(v.caster_angle) * v.twist
