"""A labelled sketch of motorcycle and rider: bodies, axes, signs and the handlebar port.

Numbers stand in the drawing and their meanings below it, so that they can be read on a narrow screen.
"""

from markupsafe import escape

from motofmi.reports.illustration import Illustration

LABELS = (
    (
        "front",
        "Front assembly (front frame): fork, handlebar, front wheel. It turns about the steer axis by the steer angle.",
    ),
    ("frame", "Rear frame with engine and rear wheel, and everything of the rider that does not move relative to it."),
    (
        "front",
        "Steer axis. The caster angle is its inclination, the trail the distance from its point on the ground back to "
        "the front contact.",
    ),
    ("rider", "Torso of the passive rider: an inertia that turns about an axis parallel to the steer axis."),
    ("rider", "Arms: a spring and a damper between torso and handlebar. Their torque is the handlebar torque."),
    (
        "rider",
        "Waist and saddle: a spring and a damper between torso and rear frame. Their torque is the frame torque.",
    ),
    (
        "port",
        "Handlebar port, where a rider or a damper is exchanged: steer angle, steer rate and frame rate go to the "
        "device; handlebar torque and frame torque come back.",
    ),
)
SIGNS = (
    "Axes: x forward, y right (towards the reader), z down, with the origin on the ground below the mass centre of the "
    "rear frame. Yaw, roll and steer to the right are positive; a torque is positive in the sense of its angle."
)
DRAWING = """
<line class="quiet" x1="20" y1="360" x2="640" y2="360"/>
<circle class="frame" cx="150" cy="300" r="60"/><circle class="front" cx="500" cy="300" r="60"/>
<path class="frame" d="M150 300 L245 290 L250 215 L190 190 M245 290 L375 285 L415 165 L250 215 M375 285 L250 215"/>
<path class="frame fill" d="M255 200 Q330 150 408 165 L395 205 Q320 225 255 215 Z"/>
<path class="frame" d="M170 188 L260 205"/>
<path class="front" d="M500 300 L430 150 M430 150 L400 132 M430 150 L440 172"/>
<line class="axis" x1="405" y1="97" x2="528" y2="360"/>
<path class="rider" d="M222 188 L300 85"/><circle class="rider" cx="322" cy="55" r="22"/>
<path class="rider" d="M300 85 L345 150 L402 134"/><path class="rider" d="M222 188 L325 235 L275 300"/>
<path class="axis rider" d="M228 196 L250 244 M330 150 L330 150"/>
<circle class="port" cx="402" cy="133" r="8"/>
<g class="quiet"><line x1="560" y1="70" x2="625" y2="70"/><path d="M625 70 l-10 -5 v10 z"/><line x1="560" y1="70" x2="560" y2="135"/><path d="M560 135 l-5 -10 h10 z"/><circle cx="560" cy="70" r="7"/><circle cx="560" cy="70" r="1.5"/></g>
<text x="630" y="76">x</text><text x="552" y="156">z</text><text x="538" y="62">y</text>
"""
PLACES = ((560, 250), (80, 240), (535, 350), (235, 118), (362, 100), (190, 160), (440, 100))  # of the numbers


def motorcycle_sketch() -> Illustration:
    """The sketch with its legend."""
    numbers = "".join(
        f'<g class="number"><circle cx="{x}" cy="{y}" r="15"/>'
        f'<text x="{x}" y="{y + 7}" text-anchor="middle">{k}</text></g>'
        for k, (x, y) in enumerate(PLACES, 1)
    )
    legend = "".join(f"<li>{escape(text)}</li>" for _, text in LABELS)
    return Illustration(
        '<div class="sketch"><svg viewBox="0 0 660 375" role="img" '
        f'aria-label="Motorcycle with rider from the right side">{DRAWING}{numbers}</svg>'
        f"<ol>{legend}</ol><p>{escape(SIGNS)}</p></div>"
    )
