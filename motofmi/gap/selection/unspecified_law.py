"""Effects outside the library: force laws that are compared with the library's effects and never named.

An effect of the library may be adequate and still be wrong. The parameters of the library have their physical signs, so
that, for example, a softening spring is approximated by the nearest effect. Where a law outside the library explains
the data better, the missing effect is not in the library:

    BIC(base + law) < BIC(base + effect),   BIC(base + law) < BIC(base + two effects) + `tie_delta_bic`
"""

from collections.abc import Sequence

from fmus.effects import Effect
from motofmi.gap.criteria import Criteria
from motofmi.gap.estimation.candidate import Candidate, adequate, best_of, ranked
from motofmi.gap.estimation.fit_result import Fit
from motofmi.gap.estimation.laws_outside_library import fitted_laws, laws_outside_library


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
    laws = laws_outside_library(library, failed)
    law = best_of(ranked(fitted_laws(base, laws, named.chi2, criteria)), criteria)
    if law is None or not (adequate(law.fit, criteria) or unspecified_form):
        return None
    two = len(named.model.effects) - len(base.model.effects) > 1
    return law if law.fit.bic < named.bic + (criteria.tie_delta_bic if two else 0.0) else None
