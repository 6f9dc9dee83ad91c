"""Blind cases that resemble real machines: two effects of which the library holds one, and imperfect recordings.

    python -m benchmarks.gap_real_like --cases 100 --seed 1 --out real_like

The simulator is that of the tests (`tests/simulators/real_like_cases.py`), which shares no code with the library. A
quarter of the cases hide nothing. The others hide a dominant effect, in a form of the library or in another one of the
same family, and a second effect of 3 to 20 % of its size that is in no library. Each case is a fitted and a validation
run; files, not arrays, are given to `find_gap`. The first name is judged: which effect is dominant. A tie that contains
it is counted apart. A row per case goes to the study in the --out folder, so that a run can be taken up again.
"""

import json
import tempfile
import time
from collections import Counter
from collections.abc import Callable, Iterable, Sequence
from pathlib import Path
from typing import Any

import numpy as np

import motofmi as mf
from benchmarks._resumed import command_line, resumed
from benchmarks.gap_blind import share_of
from fmus.declaration.component import Component
from fmus.effects.unspecified_law import FAMILY as OUTSIDE
from fmus.mechanisms import DrivenJoint, MassSpringDamper, Pendulum
from fmus.support.errors import InputError
from fmus.support.progress import track
from tests.simulators.real_like_cases import RealLikeCase, draw

CASES, SEED = 100, 1
UNITS = {"torque": "N.m", "angle": "rad", "force": "N", "displacement": "m"}


def mechanism(case: RealLikeCase) -> Component:
    """The mechanism that was recorded, with values that are near."""
    near = case.near
    if case.setting == "mass_spring_damper":
        return MassSpringDamper(mass=near["J"], spring_stiffness=near["k"], spring_damping=near["c"])
    if case.hidden == "sine":
        return Pendulum(inertia=near["J"], gravity_stiffness=near["k"], damping=near["c"])
    return DrivenJoint(inertia=near["J"], stiffness=near["k"], damping=near["c"])


def find(case: RealLikeCase, folder: Path) -> dict[str, Any]:
    """What the workflow says of a case."""
    paths = [folder / "fitted.csv", folder / "validation.csv"]
    for path, (stamps, columns) in zip(paths, (case.fitted, case.validation), strict=True):
        header = ",".join(["time [s]", *(f"{name} [{UNITS[name]}]" for name in columns)])
        np.savetxt(path, np.column_stack([stamps, *columns.values()]), "%.10g", ",", header=header, comments="")
    try:
        found = mf.find_gap(
            paths[0],
            validation=paths[1],
            component=mechanism(case),
            impose="angle" if case.setting == "imposed" else None,
        )
    except InputError as error:
        return {"verdict": "refused", "names": [], "forms": [], "tied": [], "law": "", "why": str(error)}
    said = found.to_dict()
    outside = [e["form"] for row in said["compared"] for e in row["effects"] if e["name"] == OUTSIDE]
    return {"verdict": found.verdict, "names": [e["name"] for e in found.effects], "forms": [e["form"] for e in found.effects],
            "tied": found.tied, "law": next(iter(outside), ""), "nearest": [f"{c['name']}.{c['form']}" for c in found.candidates[:3]],
            "explained": said.get("explained"), "gap": found.gap, "limitations": found.limitations}  # fmt: skip


def run(
    progress: Callable[..., Iterable], cases: int = CASES, seed: int = SEED, out: str | Path | None = None
) -> dict[str, Any]:
    """Rates and the confusion matrix; cases that the folder `out` holds already are not run again."""

    def one(number: int) -> dict[str, Any]:
        case, begun = draw(number, seed), time.process_time()
        with tempfile.TemporaryDirectory() as folder:
            found = find(case, Path(folder))
        truth = {"hidden": case.hidden, "family": case.family, "second": case.second, "share": case.share,
                 "setting": case.setting, "jitter": case.jitter, "samples": len(case.fitted[0])}  # fmt: skip
        return truth | found | {"cpu_seconds": time.process_time() - begun}

    return summary(resumed(cases, out, one, seed=seed))


def summary(rows: Sequence[dict[str, Any]]) -> dict[str, Any]:
    """Rates with Wilson's intervals, and the confusion matrix."""
    nothing, hidden = ([r for r in rows if (r["hidden"] == "none") == empty] for empty in (True, False))
    rates = {
        "nothing hidden: a name": share_of([r["verdict"] == "named" for r in nothing]),
        "nothing hidden: none": share_of([r["verdict"] == "none" for r in nothing]),
        "dominant effect named first": share_of([_first(r) == r["family"] for r in hidden]),
        "dominant effect named first, or in the tie": share_of(
            [r["family"] in (_first(r), *r["tied"]) for r in hidden]
        ),
        "wrong first name": share_of([_first(r) not in ("", r["family"]) for r in hidden]),
        "no name": share_of([not _first(r) for r in hidden]),
    }
    confusion = Counter((r["hidden"], " + ".join(r["names"]) or r["verdict"]) for r in rows)
    return {
        "cases": len(rows), "rates": rates, "confusion": {f"{truth} -> {answer}": n for (truth, answer), n in sorted(confusion.items())},
        "settings": dict(Counter(r["setting"] for r in rows)), "median_cpu_seconds": float(np.median([r["cpu_seconds"] for r in rows])),
    }  # fmt: skip


def _first(row: dict[str, Any]) -> str:
    return row["names"][0] if row["names"] else ""


def main() -> None:
    arguments = command_line("gap_real_like", __doc__, CASES, seed=SEED)
    print(json.dumps(run(track, arguments.cases, arguments.seed, arguments.out), indent=1))


if __name__ == "__main__":
    main()
