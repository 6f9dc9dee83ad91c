"""The laws outside the library at the places where a library has effects, and their fits.

The laws are those of `fmus.effects.unspecified_law`: compared with the effects of the library and never named.
"""

from collections.abc import Sequence

from fmus.effects import Effect
from fmus.effects import unspecified_law as outside_library
from fmus.effects.library import declared_by
from motofmi.gap.criteria import Criteria
from motofmi.gap.estimation.candidate import Candidate
from motofmi.gap.estimation.effect_fit import fit_each
from motofmi.gap.estimation.fit_result import Fit
from motofmi.gap.estimation.screening import screen

SPRING = "hardening_stiffness"  # the family that a library has at every element with a deflection and a rate
MOST_LAWS = 3  # laws that are fitted, those with the largest screened gain


def fitted_laws(base: Fit, laws: Sequence[type[Effect]], beat: float, criteria: Criteria) -> list[Candidate]:
    """The laws with the largest screened gain, at most `MOST_LAWS`, each fitted with the base.

    Fits end early where they cannot come near the chi-square `beat`.
    """
    screened = sorted(screen(base, laws, keep=1), key=lambda s: -s.gain)[:MOST_LAWS]
    return [c for c in fit_each(base, screened, [], beat, [], criteria) if c.fitted]


def laws_outside_library(library: Sequence[type[Effect]], failed: bool = False) -> list[type[Effect]]:
    """The laws outside the library at the elements where the library has effects.

    A law of a spring acts at every element at which the library has a spring. Laws of the steering head and of the
    measuring channel are there if the library has an effect at the same place. Laws that a family of the library
    approximates (`named_by`) are left out, unless no family is adequate (`failed`).
    """
    families = {e.family for e in library if not failed}
    elements = {e.element for e in library}
    places: dict[str, list[str]] = {p: [p] if p in elements else [] for p in ("steering_head", "channel")}
    places["spring"] = list(dict.fromkeys(e.element for e in library if e.family == SPRING))
    return [
        type(law.__name__, (law,), {"__doc__": law.__doc__, "__module__": law.__module__, "element": element})
        for law in declared_by(outside_library)
        if families.isdisjoint(law.named_by)
        for element in places[law.element]
    ]
