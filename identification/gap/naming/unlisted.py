"""Whether something that has no name explains data better than what was named: then the name is taken back.

A name may fit as well as noise lets it, and still not be what is there: the library's effects have the signs that nature
gives them, so that a spring that softens comes out as whatever of them is near.

    BIC(base + law) < BIC(base + effect),   BIC(base + law) < BIC(base + two effects) + 10: one thing rather than two
"""

from collections.abc import Sequence

from fmus.effects import Effect, unlisted
from fmus.effects.library import declared_by
from identification.gap.naming.candidate import TIE, Candidate, adequate, best_of, ranked
from identification.gap.naming.fitted import Fit
from identification.gap.naming.joining import fit_each
from identification.gap.naming.screening import screen

SPRING = "hardening_stiffness"  # acts at the elements that have a deflection and a rate
LIKELIEST = 3  # laws that are fitted


def better_unlisted(base: Fit, named: Fit, library: Sequence[type[Effect]], open_form: bool = False, failed: bool = False) -> Candidate | None:
    """The law without a name that explains more than the effects of a fit do, or as much as two of them; None where there is none.

    It must be as good as noise, unless the name that it is compared with has an open form. A law has a name where a family of the
    library comes near it, unless all of these failed.
    """
    likeliest = sorted(screen(base, unlisted_laws(library, failed), keep=1), key=lambda s: -s.gain)[:LIKELIEST]
    law = best_of(ranked(fit_each(base, likeliest, [], named.chi2, [])))
    if law is None or not (adequate(law.fit) or open_form):
        return None
    two = len(named.model.effects) - len(base.model.effects) > 1
    return law if law.fit.bic < named.bic + (TIE if two else 0.0) else None


def unlisted_laws(library: Sequence[type[Effect]], failed: bool = False) -> list[type[Effect]]:
    """The laws without a name, at the elements where the library has springs, and at the head and the measuring channel if it has effects there."""
    springs, families = dict.fromkeys(e.element for e in library if e.family == SPRING), {e.family for e in library if not failed}
    places = {"spring": springs, **{place: [place] if any(e.element == place for e in library) else [] for place in ("head", "channel")}}
    return [type(law.__name__, (law,), {"__doc__": law.__doc__, "__module__": law.__module__, "element": element})
            for law in declared_by(unlisted) if families.isdisjoint(law.named_by) for element in places[law.element]]  # fmt: skip
