"""The numbers of docs/sweep.md about riders who weave: those of the scenario `which_riders_weave`."""

from collections.abc import Callable
from typing import Any

from motofmi.scenarios import which_riders_weave as scenario


def run(progress: Callable, riders: int = scenario.RIDERS) -> dict[str, Any]:
    """By vehicle and damper the shares of riders with an unstable weave or wobble, and of those that are served."""
    found = scenario.run(riders=riders)
    shares = {"weave": found.weaving, "wobble": found.wobbling, "served": found.served}
    pairs = progress(list(found.served), "shares")
    rows = [{"vehicle": v, "damper": d, **{name: float(share[v, d]) for name, share in shares.items()}} for v, d in pairs]
    motorcycles = [row for row in rows if row["vehicle"] != "benchmark_bicycle"]
    return {
        "riders": riders,
        "rows": rows,
        "most_wobbling_motorcycles": max(row["wobble"] for row in motorcycles),
        "served_without_damper": max(row["served"] for row in motorcycles if row["damper"] == "none"),
        "served_with_damper": max(row["served"] for row in motorcycles if row["damper"] != "none"),
    }


def table(results: dict[str, Any]) -> str:
    """The table of docs/sweep.md."""
    vehicles = list(dict.fromkeys(row["vehicle"] for row in results["rows"]))
    share = {(row["vehicle"], row["damper"]): row["weave"] for row in results["rows"]}
    lines = [f"| damper | {' | '.join(f'weave, `{v}`' for v in vehicles)} |", "|---|" + "---|" * len(vehicles)]
    for damper in dict.fromkeys(row["damper"] for row in results["rows"]):
        cells = [f"{100 * share[vehicle, damper]:.0f} %" for vehicle in vehicles]
        lines.append(f"| {damper.removeprefix('damper:')} | {' | '.join(cells)} |")
    return "\n".join(lines) + "\n"
