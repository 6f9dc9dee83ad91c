"""The motion of a mode, drawn from above and from behind by the phasors of its eigenvector. The page only turns
phasors:

    q(t) = Re(phasor exp(lambda t))

Fast modes are slowed down and all motions are enlarged by one factor, which are both stated.
"""

from collections.abc import Mapping
from math import pi

from markupsafe import escape

from fmus.support.plain_json import to_json
from motofmi.reports.illustration import Illustration

LARGEST, WIDEST = 0.35, 0.45  # rad, m; amplitudes as drawn
SLOWEST_PERIOD, RUN = 1.6, 6.0  # s, of the drawing: least period of an oscillation, length of a run
GROWTH = 1.2  # logarithm, by which the amplitude may change in a run
TOP = """<svg viewBox="-110 -130 220 250" role="img" aria-label="from above"><g class="lateral"><g class="yaw">
<path class="frame" d="M0 92 V-35"/><path class="frame thick" d="M0 92 V66"/>
<g class="steer" data-at="0 -35"><path class="front" d="M-38 -30 Q0 -44 38 -30 M0 -35 V-60"/><path class="front thick" d="M0 -58 V-88"/></g>
<g class="torso" data-at="0 20"><path class="rider thick" d="M-30 20 H30"/><circle class="rider fill" cx="0" cy="14" r="11"/></g>
<path class="rider arms"/></g></g></svg>"""
BACK = """<svg viewBox="-110 -150 220 170" role="img" aria-label="from behind"><line class="quiet" x1="-105" x2="105" y1="2" y2="2"/><g class="lateral"><g class="roll">
<path class="frame thick" d="M0 0 V-50"/><path class="frame" d="M0 -50 V-82"/><path class="front" d="M-38 -88 H38"/>
<path class="rider" d="M0 -78 V-112 M-26 -112 H26 M-26 -112 L-36 -88 M26 -112 L36 -88"/><circle class="rider fill" cx="0" cy="-128" r="12"/></g></g></svg>"""


def mode_animation(name: str, eigenvalue: complex, phasors: Mapping[str, complex]) -> Illustration:
    """A mode by its eigenvalue [1/s] and the phasors of steer, torso, roll, yaw [rad] and lateral [m]."""
    angle = max(abs(phasors[key]) for key in ("steer", "torso", "roll", "yaw"))
    gain = min(LARGEST / max(angle, 1e-12), WIDEST / max(abs(phasors["lateral"]), 1e-12))
    period = 2 * pi / eigenvalue.imag if eigenvalue.imag else 0.0
    speed = min(1.0, period / SLOWEST_PERIOD) if period else min(1.0, GROWTH / RUN / max(abs(eigenvalue.real), 1e-9))
    data = {"value": complex(eigenvalue), "gain": gain, "speed": speed, "run": RUN, "growth": GROWTH,
            "phasors": {name: complex(value) for name, value in phasors.items()}}  # fmt: skip
    slowed = f", slowed {1 / speed:.2g} times" if speed < 0.999 else ", at the speed of the motion"
    said = f"{name}: from above and from behind{slowed}. Forward is up."
    json = to_json(data, indent=None).replace("</", "<\\/")
    return Illustration(
        '<div class="animation"><p class="animation-bar"><button type="button" class="play">play</button> '
        f"<span>{escape(said)}</span></p>"
        f'<div class="views">{TOP}{BACK}</div><script type="application/json">{json}</script></div>',
        "animation.js",
    )
