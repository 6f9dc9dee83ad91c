"""The verdict of a search that may be ended before its end, by a time budget or by an interrupt."""

from collections.abc import Callable
from contextlib import suppress
from dataclasses import replace

from fmus.support.deadline import current_deadline, deadline
from fmus.support.errors import InputError
from motofmi.gap.estimation.stages import TimeUpError
from motofmi.gap.selection.result import Verdict

CONCLUDING_SHARE = 0.25  # of the time budget, for the simulation of validation runs after its end
INTERRUPTED = "Interrupted: these are intermediate results, and no verdict."


def within_time(
    search: Callable[[Callable[[Verdict], None]], Verdict], on_progress: Callable[[Verdict], None]
) -> Verdict:
    """The verdict of a search, or the latest intermediate verdict where the search ends early.

    search(report) reports a verdict at every stage, and on_progress is called with each. After the time budget the
    latest one is concluded (`Verdict.conclude`); after an interrupt it is `unknown`. Raises KeyboardInterrupt where no
    verdict was reported yet.
    """
    latest: list[Verdict] = []

    def report(verdict: Verdict) -> None:
        latest[:] = [verdict]
        on_progress(verdict)

    try:
        return search(report)
    except KeyboardInterrupt:
        if not latest:
            raise
        return replace(latest[0].as_unknown(), ended=INTERRUPTED, interrupted=True)
    except TimeUpError as end:
        known = latest[0]
        with suppress(InputError, TimeUpError), deadline(CONCLUDING_SHARE * current_deadline().budget):
            known = known.conclude() if known.conclude else known
        return replace(known, ended=str(end))
