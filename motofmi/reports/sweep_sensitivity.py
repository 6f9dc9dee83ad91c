"""Which parameter matters: sensitivities of the least damping ratio of each mode to the parameters of the runs.

    regression   standardised coefficients b_i s_i / s_y of a linear fit of the ranks (Saltelli et al., Sensitivity
                 Analysis, 2000), with the share of the variance that the fit explains
    Sobol        first-order indices V(E[y | x_i]) / V(y) from the runs as they are, by random balance designs
                 (Tarantola, Gatelli, Mara, Reliab. Eng. Syst. Saf. 91 (2006), as in SALib)

Parameters of a population are correlated; an index then includes what a parameter shares with the others.
"""

from typing import Any

import numpy as np
from scipy.stats import rankdata

from motofmi.reports.charts import SEQUENCE, Axis, Chart, Curve, Line, Panel
from motofmi.reports.report import Section, Table
from motofmi.reports.sweep_maps import DRAWN

FEWEST_FOR_SOBOL = 100  # runs; the indices of RBD-FAST are biased for less
LABELS = ("run", "vehicle", "device", "rider", "sample", "status", "reason")


def sensitivity_section(dataset: Any, table: Any) -> Section | None:
    """Bars and a table of the sensitivities; None where the runs differ in less than two parameters, or are few."""
    names = [
        n
        for n in list(table.columns)[: list(table.columns).index("status")]
        if n not in LABELS and table[n].nunique() > 2
    ]
    if len(names) < 2:
        return None
    found: dict[str, tuple[np.ndarray, float, np.ndarray | None]] = {}
    for mode in DRAWN:
        rows = table[(table["status"] == "done") & table[f"{mode}_damping_ratio"].notna()]
        response = rows[f"{mode}_damping_ratio"].to_numpy(float)
        if len(rows) > 5 * len(names) and response.std() > 0:
            values = rows[names].to_numpy(float)
            found[mode] = (*rank_regression(values, response), first_order(names, values, response))
    if not found:
        return None
    curves = [Curve(f"{mode.replace('_', '-')} (explained: {100 * share:.0f} %)", coefficients, np.arange(len(names)),
                    SEQUENCE[k], "points")
              for k, (mode, (coefficients, share, _)) in enumerate(found.items())]  # fmt: skip
    panel = Panel(Axis("standardised rank regression coefficient", "1"), Axis("parameter", "", names=names), curves,
                  lines=[Line(0.0, across="x")], hover="point", height=120 + 30 * len(names))  # fmt: skip
    rows_of_table = [[mode.replace("_", "-"), name, f"{coefficients[i]:+.2f}",
                      "-" if sobol is None else f"{max(sobol[i], 0.0):.2f}"]
                     for mode, (coefficients, _, sobol) in found.items() for i, name in enumerate(names)]  # fmt: skip
    text = ("A positive coefficient: more of the parameter, more damping of the mode. Devices and vehicles are mixed. "
            "The parameters of a population are correlated; an index includes what a parameter shares "
            "with others.")  # fmt: skip
    return Section("Sensitivities", [text], [(Chart([panel]), "Sensitivity of the least damping ratio over speed.")],
                   [Table(["mode", "parameter", "regression [1]", "first-order Sobol index [1]"],
                          rows_of_table)])  # fmt: skip


def rank_regression(values: np.ndarray, response: np.ndarray) -> tuple[np.ndarray, float]:
    """Standardised coefficients (np,) of the ranks of values (n, np), and the explained share of the variance."""
    ranks = np.apply_along_axis(rankdata, 0, values)
    ranks = (ranks - ranks.mean(axis=0)) / ranks.std(axis=0)
    wanted = rankdata(response)
    wanted = (wanted - wanted.mean()) / wanted.std()
    coefficients, *_ = np.linalg.lstsq(ranks, wanted, rcond=None)
    return coefficients, float(1.0 - ((wanted - ranks @ coefficients) ** 2).mean())


def first_order(names: list[str], values: np.ndarray, response: np.ndarray) -> np.ndarray | None:
    """First-order Sobol indices (np,); None without SALib, and for few runs."""
    if len(values) < FEWEST_FOR_SOBOL:
        return None
    try:
        from SALib.analyze import rbd_fast  # noqa: PLC0415 - of the extra
    except ImportError:
        return None
    problem = {"num_vars": len(names), "names": names,
               "bounds": [[low, high] for low, high in
                          zip(values.min(axis=0), values.max(axis=0), strict=True)]}  # fmt: skip
    return np.asarray(rbd_fast.analyze(problem, values, response, num_resamples=2, seed=0)["S1"])
