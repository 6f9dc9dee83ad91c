"""Effects outside the library: force laws that are compared with the library's effects and never named.

An effect of the library may be adequate and still be wrong. The parameters of the library have their physical signs, so
that, for example, a softening spring is approximated by the nearest effect. Where a law outside the library explains
the data better, the missing effect is not in the library:

    BIC(base + law) < BIC(base + effect),   BIC(base + law) < BIC(base + two effects) + `tie_delta_bic`
"""

from collections.abc import Sequence

from fmus.effects import Effect
from fmus.effects import unspecified_law as outside_library
from fmus.effects.library import declared_by
from motofmi.gap.criteria import Criteria
from motofmi.gap.estimation.candidate import Candidate, adequate, best_of, ranked
from motofmi.gap.estimation.effect_fit import fit_each
from motofmi.gap.estimation.fit_result import Fit
from motofmi.gap.estimation.screening import screen

SPRING = "hardening_stiffness"  # the family that a library has at every element with a deflection and a rate
MOST_LAWS = 3  # laws that are fitted, those with the largest screened gain


def better_outside_library(
    base: Fit,
    named: Fit,
    library: Sequence[type[Effect]],
    criteria: Criteria,
    unspecified_form: bool = False,
    failed: bool = False,
) -> Candidate | None:
    """The law outside the library with a lower BIC than the effects of the fit `named`; None where there is none.

    With two effects in that fit a law within `Criteria.tie_delta_bic` is sufficient. The law must be adequate, unless
    the form of the named effect is unspecified. Laws that a family of the library approximates are left out, except
    where no family is adequate (`failed`).
    """
    screened = sorted(screen(base, laws_outside_library(library, failed), keep=1), key=lambda s: -s.gain)[:MOST_LAWS]
    law = best_of(ranked(fit_each(base, screened, [], named.chi2, [], criteria)), criteria)
    if law is None or not (adequate(law.fit, criteria) or unspecified_form):
        return None
    two = len(named.model.effects) - len(base.model.effects) > 1
    return law if law.fit.bic < named.bic + (criteria.tie_delta_bic if two else 0.0) else None


def laws_outside_library(library: Sequence[type[Effect]], failed: bool = False) -> list[type[Effect]]:
    """The laws outside the library at the elements where the library has effects.

    A law of a spring acts at every element at which the library has a spring. Laws of the steering head and of the
    measuring channel are there if the library has an effect at the same place. Laws that a family of the library
    approximates (`named_by`) are left out, unless `failed`.
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
