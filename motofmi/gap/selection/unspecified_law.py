"""Effects outside the library: force laws without an effect of their own, one of which may explain the
data better than a name.

An effect may be adequate and still be wrong: the effects of the library have their physical signs, so that a softening
spring is fitted by the effect nearest to it.

    BIC(base + law) < BIC(base + effect),   BIC(base + law) < BIC(base + two effects) + tie: one law rather than two effects
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

SPRING = "hardening_stiffness"  # acts at every element that has a deflection and a rate
LIKELIEST = 3  # laws that are fitted, the best by screening


def better_outside_library(base: Fit, named: Fit, library: Sequence[type[Effect]], criteria: Criteria, unspecified_form: bool = False,
                    failed: bool = False) -> Candidate | None:  # fmt: skip
    """The law outside the library that explains more than the effects of a fit, or as much as two of them;
    None where there is none.

    It must be adequate, unless the name that it is compared with has an unspecified form. Laws that a family of the
    library approximates are left out, unless all families failed.
    """
    likeliest = sorted(screen(base, laws_outside_library(library, failed), keep=1), key=lambda s: -s.gain)[:LIKELIEST]
    law = best_of(ranked(fit_each(base, likeliest, [], named.chi2, [], criteria)), criteria)
    if law is None or not (adequate(law.fit, criteria) or unspecified_form):
        return None
    two = len(named.model.effects) - len(base.model.effects) > 1
    return law if law.fit.bic < named.bic + (criteria.tie_delta_bic if two else 0.0) else None


def laws_outside_library(library: Sequence[type[Effect]], failed: bool = False) -> list[type[Effect]]:
    """The laws outside the library, at the elements where it has springs, and at steering head and channel if
    it has effects there."""
    springs, families = (
        dict.fromkeys(e.element for e in library if e.family == SPRING),
        {e.family for e in library if not failed},
    )
    places = {
        "spring": springs,
        **{
            place: [place] if any(e.element == place for e in library) else [] for place in ("steering_head", "channel")
        },
    }
    return [type(law.__name__, (law,), {"__doc__": law.__doc__, "__module__": law.__module__, "element": element})
            for law in declared_by(outside_library) if families.isdisjoint(law.named_by) for element in places[law.element]]  # fmt: skip
