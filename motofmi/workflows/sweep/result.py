"""The result of a study: its results as a lazy xarray Dataset, its table of runs, and what follows from them."""

import json
from collections.abc import Sequence
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np

from fmus.support.errors import InputError, unknown
from fmus.support.notebook import html
from motofmi.reports.chart_figures import figure
from motofmi.reports.shown import Interactive
from motofmi.reports.sweep_maps import share_chart, share_unstable
from motofmi.reports.sweep_report import FILE as REPORT
from motofmi.reports.sweep_report import sweep_report
from motofmi.reports.sweep_runs import RunLinks
from motofmi.studies.runs import FAILED
from motofmi.studies.store import RESULTS, STUDY, TABLE, missing_extra
from motofmi.workflows.sweep.explore_links import FILE as EXPLORE
from motofmi.workflows.sweep.explore_links import StudyPage


class StudyResult:
    """The folder of a study. Nothing is read before it is used, and of the results only what is used; `sweep` shows an
    example.
    """

    def __init__(self, folder: Path, description: dict[str, Any]):
        self.folder, self.description = folder, description

    @cached_property
    def dataset(self) -> Any:
        """The results over the named dimensions (xarray.Dataset), read from the Zarr store when they are used."""
        import xarray as xr  # noqa: PLC0415 - imported on use

        found = xr.open_dataset(self.folder / RESULTS, engine="zarr", backend_kwargs={"consolidated": False})
        names = [name for name in found.data_vars if "." in str(name)]  # parameters of the members
        found = found.set_coords(names)
        return found.assign_attrs({key: self.description[key] for key in ("kind", "version", "hash")})

    @cached_property
    def table(self) -> Any:
        """One row for each run: labels, parameters, status, reason, and the values of the kind (pandas.DataFrame)."""
        import pandas as pd  # noqa: PLC0415 - imported on use

        return pd.read_parquet(self.folder / TABLE)

    @property
    def runs(self) -> int:
        """The number of runs."""
        return len(self.table)

    @property
    def failed(self) -> int:
        """The number of runs that failed; their reasons are in the table."""
        return int((self.table["status"] == FAILED).sum())

    def share_unstable(self, mode: str, over: str = "rider") -> Any:
        """The share of the runs along a dimension in which a mode is unstable (xarray.DataArray), over the other
        dimensions and the speed. Runs without results do not count.

        Raises InputError for an unknown mode or dimension, and for a study of another kind.
        """
        if "unstable" not in self.dataset:
            raise InputError(f"{self.folder} is a study of kind {self.description['kind']}, not of modes")
        modes = [str(name) for name in self.dataset["mode"].values]
        if mode not in modes:
            raise unknown("mode", mode, modes)
        dims = [str(dim) for dim in self.dataset["unstable"].dims if dim != "mode"]
        if over not in dims:
            raise unknown("dimension", over, dims)
        share = share_unstable(self.dataset, self.table, mode, tuple(dim for dim in dims if dim != over))
        return share.rename(f"share_{mode}_unstable").assign_attrs(units="1")

    def report(self, path: str | Path | None = None) -> Path:
        """Write the HTML report, by default into the folder of the study; its path.

        Of a study of modes an explore page is written beside it, in which the report's links show single runs.
        """
        place = self.folder / REPORT if path is None else Path(path)
        links = None
        if "unstable" in self.dataset:
            page, file = StudyPage.of(self.description), place.with_name(EXPLORE)
            reason = page.write(file)
            links = RunLinks(file, reason, page.address)
        sweep_report(self.dataset, self.table, self.description, links).write(place)
        return place

    def plot(self, modes: Sequence[str] = ("weave", "wobble")) -> Any:
        """The share of unstable runs over speed for each mode; the figure of matplotlib."""
        return figure(share_chart(self.dataset, self.table, list(modes))[0])

    def show(self, modes: Sequence[str] = ("weave", "wobble")) -> Interactive:
        """The share of unstable runs over speed for each mode, interactive in a notebook."""
        return Interactive(share_chart(self.dataset, self.table, list(modes))[0], "Share of runs unstable")

    def to_dict(self) -> dict[str, Any]:
        """The keys of `motofmi sweep --json`."""
        return {"runs": self.runs, "failed": self.failed, "store": str(self.folder / RESULTS),
                "table": str(self.folder / TABLE), "hash": self.description["hash"]}  # fmt: skip

    def to_dataframe(self) -> Any:
        """The table (pandas.DataFrame)."""
        return self.table

    def to_xarray(self) -> Any:
        """The results (xarray.Dataset)."""
        return self.dataset

    def __repr__(self) -> str:
        sizes = ", ".join(f"{dim} {n}" for dim, n in self.dataset.sizes.items())
        return f"StudyResult({self.description['kind']}: {self.runs} runs, {self.failed} failed; {sizes})"

    def _repr_html_(self) -> str:
        rows = [(name, " x ".join(map(str, array.dims)), array.attrs.get("units", ""), array.attrs.get("long_name", ""))
                for name, array in self.dataset.data_vars.items()]  # fmt: skip
        return html(repr(self), ("result", "dimensions", "unit", "meaning"), rows)


def open_study(folder: str | Path) -> StudyResult:
    """The result of a study in a folder, read lazily. Raises InputError where it is none, or is not complete.

    open_study("riders").dataset

        >>> found = mf.sweep(device=["none", "damper:7.5"], speed=[20.0, 30.0], out="dampers")
        >>> mf.open_study("dampers").runs
        2
    """
    missing_extra()
    path = Path(folder)
    if not (path / STUDY).exists():
        raise InputError(f"{path} holds no {STUDY}: give the folder of a study, as motofmi sweep --out writes it")
    if not (path / TABLE).exists():
        raise InputError(f"the study in {path} is not complete: start it again, and it goes on from what is there")
    found = StudyResult(path, json.loads((path / STUDY).read_text("utf-8")))
    _check_chunks(found)
    return found


def _check_chunks(found: StudyResult) -> None:
    """Raises InputError where a chunk's file is missing: Zarr would read it as absent values."""
    for folder in (found.folder / RESULTS).iterdir():
        if not folder.is_dir():
            continue
        described = json.loads((folder / "zarr.json").read_text("utf-8"))
        size = described["chunk_grid"]["configuration"]["chunk_shape"]
        expected = int(np.prod([-(-n // c) for n, c in zip(described["shape"], size, strict=True)]))
        held = sum(path.is_file() for path in (folder / "c").rglob("*")) if described["shape"] else 1
        if held < expected:
            raise InputError(f"{folder} lacks {expected - held} of {expected} chunks: start the study again, and it "
                             "computes them")  # fmt: skip
