"""Arms and grip that are not a linear spring and damper: the laws of mechanics at the rider's arms."""

from fmus.effects import adds_to, change, damping, memory, stiffness


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
    """The arms' torque has an odd curve of its own."""

    element = "arms"


class GripBacklash(stiffness.Backlash):
    """The grip has play: the arms do not feel small deflections."""

    element = "arms"


class SoftGrip(stiffness.SoftBacklash):
    """The grip has play with a soft transition."""

    element = "arms"


class UnevenArms(stiffness.Asymmetry):
    """The arms are stiffer to one side; the ratio is positive where turning right against the torso is."""

    element = "arms"

    @adds_to("force")
    def lopsided(self, v, m):
        return -v.ratio * v.stiffness * m.absolute(v.deflection)


class BentArms(stiffness.QuadraticAsymmetry):
    """The arms are stiffer to one side, in proportion to the deflection."""

    element = "arms"


class ProgressiveArms(damping.ProgressiveDamping):
    """The arms' damping grows with their rate."""

    element = "arms"


class CubicArmDamping(damping.CubicDamping):
    """The arms' damping grows with the square of their rate."""

    element = "arms"


class AnyArmDamping(damping.AnyDamping):
    """The arms' damping has an odd curve of its own."""

    element = "arms"


class ArmHysteresis(memory.DahlHysteresis):
    """The arms' torque lags behind their deflection, with a smooth loop."""

    element = "arms"


class RoundHysteresis(memory.BoucWenHysteresis):
    """The arms' torque lags behind their deflection, with a rounded loop."""

    element = "arms"


class SlidingHysteresis(memory.JenkinsHysteresis):
    """The arms' torque lags behind their deflection: skin that sticks and slides."""

    element = "arms"


class SharpenedHysteresis(memory.SharpenedHysteresis):
    """The arms' torque lags behind their deflection, with a loop as sharp as it comes."""

    element = "arms"


class AnyHysteresis(memory.IwanHysteresis):
    """The arms' torque lags behind their deflection, with a loop of its own."""

    element = "arms"


class ViscoelasticArms(memory.ViscoelasticArm):
    """The arms are stiffer when moved fast: a spring and a damper in series beside them."""

    element = "arms"


class GripDrift(change.Drift):
    """The grip tightens or loosens during the test."""

    element = "arms"


class GripStiffnessDrift(change.StiffnessDrift):
    """The grip's stiffness changes during the test."""

    element = "arms"


class GripDampingDrift(change.DampingDrift):
    """The grip's damping changes during the test."""

    element = "arms"


class GripSettling(change.SettlingDrift):
    """The grip settles in the first part of the test."""

    element = "arms"


class GripStiffnessSettling(change.StiffnessSettling):
    """The grip's stiffness settles in the first part of the test."""

    element = "arms"


class GripShift(change.StepDrift):
    """The rider takes another grip at some moment of the test."""

    element = "arms"


class GripStiffnessShift(change.StiffnessStep):
    """The grip's stiffness changes at once, at some moment of the test."""

    element = "arms"


class AnyGripDrift(change.AnyDrift):
    """The grip changes during the test in a way of its own."""

    element = "arms"
