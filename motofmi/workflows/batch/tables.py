"""What a batch tabulates of each test: the columns of a workflow, and how they follow from its result."""

import json
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

from fmus.support.plain_json import to_json
from motofmi.studies.runs import Column
from motofmi.workflows.gap.find_gap import find_gap
from motofmi.workflows.gap.result import Gap
from motofmi.workflows.identify import RiderIdentification, identify
from motofmi.workflows.measured_rider import PARAMETERS, rig_response

NUMBER, TEXT = "float64", "string"


@dataclass(frozen=True)
class Workflow:
    """A workflow for batches: its function, the columns of its results, and their values from a result.

    saves says whether the function writes the files of a test into a folder `out`.
    """

    function: Callable[..., Any]
    columns: Mapping[str, Column]
    values: Callable[[Any], dict[str, Any]]
    saves: bool = False


def _of_identification(found: RiderIdentification) -> dict[str, Any]:
    values = {name: entry["value"] for name, entry in found.parameters.items()}
    errors = {f"{name}_error": entry["standard_error"] for name, entry in found.parameters.items()}
    return {**values, **errors, "reduced_chi_square": float(found.fit.reduced_chi_square),
            "radius": found.residual["radius"], "phase": found.residual["phase_deg"],
            "warnings": "; ".join(found.warnings)}  # fmt: skip


def _of_gap(found: Gap) -> dict[str, Any]:
    contents = json.loads(to_json(found.to_dict()))  # plain numbers, None for those that are not finite
    effects, gap, best = contents["effects"], contents["gap"], (contents["candidates"] or [{}])[0]
    closest, explained = contents["closest"] or {}, contents["explained"] or {}
    return {
        "verdict": contents["verdict"],
        "effects": " + ".join(effect["name"] for effect in effects),
        "forms": " + ".join(effect["form"] for effect in effects),
        "tied": ", ".join(contents["tied"]),
        "closest": closest.get("name") or "",
        "delta_bic": best.get("delta_bic"),
        "parameters": json.dumps({f"{e['name']}.{n}": p["value"] for e in effects for n, p in e["parameters"].items()}),
        "before": gap["before"], "after": gap["after"],
        "validation_before": gap["holdout_before"], "validation_after": gap["holdout_after"],
        "explained": explained.get("share"), "complete": contents["complete"],
        "limitations": " ".join(contents["limitations"]),
    }  # fmt: skip


def _units() -> dict[str, str]:
    return {row.name.rpartition(".")[2]: row.unit for row in rig_response().rows}


def workflows() -> dict[str, Workflow]:
    """The workflows by name."""
    units = _units()
    identified = {f"{name}{part}": Column(NUMBER, units[name]) for part in ("", "_error") for name in PARAMETERS}
    identified |= {"reduced_chi_square": Column(NUMBER, "1"), "radius": Column(NUMBER, "(rad/s2)/(N.m)"),
                   "phase": Column(NUMBER, "deg"), "warnings": Column(TEXT)}  # fmt: skip
    gap = {name: Column(TEXT) for name in ("verdict", "effects", "forms", "tied", "closest")}
    gap |= {"delta_bic": Column(NUMBER, "1"), "parameters": Column(TEXT)}
    gap |= {n: Column(NUMBER, "1") for n in ("before", "after", "validation_before", "validation_after", "explained")}
    gap |= {"complete": Column("bool"), "limitations": Column(TEXT)}
    return {"identify": Workflow(identify, identified, _of_identification),
            "gap": Workflow(find_gap, gap, _of_gap, saves=True)}  # fmt: skip
