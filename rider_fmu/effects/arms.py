"""Nonlinear, hysteretic and drifting arms and grip: the laws of mechanics at the element `arms`."""

from fmus.effects import adds_to, damping, drift, hysteresis, stiffness


class HardeningArms(stiffness.CubicHardening):
    """The arms stiffen with the square of their deflection."""

    element = "arms"


class QuinticArms(stiffness.QuinticHardening):
    """The arms stiffen with the fourth power of their deflection."""

    element = "arms"


class SquareArms(stiffness.SquareHardening):
    """The arms stiffen in proportion to their deflection."""

    element = "arms"


class TendonArms(stiffness.ExponentialHardening):
    """The arms stiffen exponentially with their deflection, as tendons do."""

    element = "arms"


class AnyArms(stiffness.AnyHardening):
    """The torque of the arms is an odd polynomial of their deflection."""

    element = "arms"


class GripBacklash(stiffness.Backlash):
    """The grip has backlash: small deflections of the arms give no torque."""

    element = "arms"


class SoftGrip(stiffness.SoftBacklash):
    """The grip has backlash with a smooth transition."""

    element = "arms"


class UnevenArms(stiffness.Asymmetry):
    """The arms are stiffer to one side; the ratio is positive where steering right is stiffer."""

    element = "arms"

    @adds_to("force")
    def difference(self, v, m):
        return -v.ratio * v.stiffness * m.absolute(v.deflection)


class BentArms(stiffness.QuadraticAsymmetry):
    """The arms are stiffer to one side, with a difference in proportion to the deflection."""

    element = "arms"


class ProgressiveArms(damping.ProgressiveDamping):
    """The arms' damping grows with their rate."""

    element = "arms"


class CubicArmDamping(damping.CubicDamping):
    """The arms' damping grows with the square of their rate."""

    element = "arms"


class AnyArmDamping(damping.AnyDamping):
    """The damping torque of the arms is an odd polynomial of their rate."""

    element = "arms"


class ArmHysteresis(hysteresis.DahlHysteresis):
    """The arms' torque lags behind their deflection, with a smooth loop."""

    element = "arms"


class RoundHysteresis(hysteresis.BoucWenHysteresis):
    """The arms' torque lags behind their deflection, with a rounded loop."""

    element = "arms"


class SlidingHysteresis(hysteresis.JenkinsHysteresis):
    """The arms' torque lags behind their deflection: skin that sticks and slides."""

    element = "arms"


class SharpenedHysteresis(hysteresis.SharpenedHysteresis):
    """The arms' torque lags behind their deflection, with a loop of free sharpness."""

    element = "arms"


class AnyHysteresis(hysteresis.IwanHysteresis):
    """The arms' torque lags behind their deflection: sliders of several widths."""

    element = "arms"


class ViscoelasticArms(hysteresis.ViscoelasticArm):
    """The arms are stiffer at high rates: a spring and a damper in series act in parallel."""

    element = "arms"


class GripDrift(drift.Drift):
    """The grip tightens or loosens during the test."""

    element = "arms"


class GripStiffnessDrift(drift.StiffnessDrift):
    """The grip's stiffness changes during the test."""

    element = "arms"


class GripDampingDrift(drift.DampingDrift):
    """The grip's damping changes during the test."""

    element = "arms"


class GripSettling(drift.SettlingDrift):
    """The grip settles in the first part of the test."""

    element = "arms"


class GripStiffnessSettling(drift.StiffnessSettling):
    """The grip's stiffness settles in the first part of the test."""

    element = "arms"


class GripShift(drift.StepDrift):
    """The grip changes in a step during the test."""

    element = "arms"


class GripStiffnessShift(drift.StiffnessStep):
    """The grip's stiffness changes in a step during the test."""

    element = "arms"


class AnyGripDrift(drift.AnyDrift):
    """Stiffness and damping of the grip change during the test independently of each other."""

    element = "arms"
