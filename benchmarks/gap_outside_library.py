"""Blind cases whose dominant effect is outside the library: is anything named, and is the law stated?

    python -m benchmarks.gap_outside_library --cases 64 --seed 1 --out outside

The machines are those of `benchmarks.gap_real_like`, with a law of `tests/simulators/outside_library_cases.py` as the
dominant effect, and a second effect of 3 to 20 % of its size that is in no library either. A row per case goes to the
study in the --out folder, so that a run can be taken up again.
"""

import json
import tempfile
from collections import Counter
from collections.abc import Callable, Iterable, Sequence
from pathlib import Path
from typing import Any

from benchmarks._resumed import command_line, resumed
from benchmarks.gap_blind import share_of
from benchmarks.gap_real_like import find
from fmus.support.progress import track
from tests.simulators.outside_library_cases import FORMS, draw_outside, kind_of

CASES, SEED = 64, 1


def run(
    progress: Callable[..., Iterable] = track, cases: int = CASES, seed: int = SEED, out: str | Path | None = None
) -> dict[str, Any]:
    """Rates and the confusion matrix; cases that the folder `out` holds already are not run again."""

    def one(number: int) -> dict[str, Any]:
        case = draw_outside(number, seed)
        with tempfile.TemporaryDirectory() as folder:
            found = find(case, Path(folder))
        return {"hidden": case.hidden, "second": case.second, "setting": case.setting, "share": case.share, **found}

    return summary(resumed(cases, out, one, seed=seed))


def summary(rows: Sequence[dict[str, Any]]) -> dict[str, Any]:
    """Rates with Wilson's intervals, and the confusion matrix."""
    rates = {
        "nothing named": share_of([r["verdict"] != "named" for r in rows]),
        "a name": share_of([r["verdict"] == "named" for r in rows]),
        "the law stated": share_of([r["law"] in FORMS[kind_of(r["hidden"])] for r in rows]),
        "another law stated": share_of([bool(r["law"]) and r["law"] not in FORMS[kind_of(r["hidden"])] for r in rows]),
    }
    counts = Counter((r["hidden"], r["law"] or " + ".join(r["names"]) or r["verdict"]) for r in rows)
    confusion = {f"{truth} -> {found}": n for (truth, found), n in sorted(counts.items())}
    return {"cases": len(rows), "rates": rates, "confusion": confusion}


def main() -> None:
    arguments = command_line("gap_outside_library", __doc__, CASES, seed=SEED)
    print(json.dumps(run(track, arguments.cases, arguments.seed, arguments.out), indent=1))


if __name__ == "__main__":
    main()
