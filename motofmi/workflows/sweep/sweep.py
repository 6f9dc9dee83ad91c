"""Studies: the product of vehicles, devices, speeds, parameters and populations, run on all cores or on a cluster."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from time import process_time
from typing import Any

from fmus.support.errors import InputError
from fmus.support.parallel import processes
from motofmi.studies.runner import run_study
from motofmi.studies.store import Store, missing_extra
from motofmi.workflows.components import ComponentLike, DeviceSet
from motofmi.workflows.sweep.result import StudyResult, open_study
from motofmi.workflows.sweep.study import Study
from motofmi.workflows.sweep.system_runs import SystemRuns

OUT = "sweep"  # the default folder


@dataclass(frozen=True)
class Prepared:
    """A validated study and its folder."""

    study: Study
    runs: SystemRuns
    store: Store

    @classmethod
    def of(cls, study: Study, out: str | Path) -> "Prepared":
        """Validate a study. Raises InputError for whatever cannot be run, and MissingToolError without the extra."""
        missing_extra()
        runs = study.runs()
        return cls(study, runs, Store(Path(out), runs))

    @cached_property
    def seconds(self) -> float:
        """The estimated processor time of all runs [s], from the first chunk, which is computed for it."""
        indices = self.runs.grid.indices(0)
        self.runs.compute(indices[:1])  # compiles the equations, which the worker processes inherit
        began = process_time()
        self.runs.compute(indices)
        return (process_time() - began) / len(indices) * self.runs.grid.runs

    def estimate(self, workers: int | None = None) -> str:
        """The number of runs and the estimated time in a sentence."""
        count = workers or processes()
        grid, time = self.runs.grid, max(self.seconds / count, 0.1)
        size = " x ".join(f"{n} {dim}" for dim, n in zip(grid.dims, grid.shape, strict=True))
        return (f"{grid.runs:,} runs of kind {self.study.kind} ({size}) in {grid.chunks:,} chunks: about "
                f"{time:,.0f} s on {count} {'process' if count == 1 else 'processes'}")  # fmt: skip

    def run(self, scheduler: str | None = None, workers: int | None = None,
            on_dashboard: Callable[[str], object] = lambda address: None) -> StudyResult:  # fmt: skip
        """Compute what the folder lacks; the result."""
        run_study(self.store, self.study.description(self.runs), "chunks", scheduler, workers, on_dashboard)
        return open_study(self.store.folder)


def sweep(study: str | Path | Study | None = None, *, kind: str = "modes",
          vehicle: ComponentLike | Sequence[ComponentLike] = "sharp_1971",
          device: DeviceSet | Sequence[DeviceSet] = None, speed: Any = None, set: Mapping[str, Any] | None = None,
          count: int = 100, design: str = "sobol", seed: int = 0, out: str | Path = OUT,
          scheduler: str | None = None, workers: int | None = None, **options: Any) -> StudyResult:  # fmt: skip
    """Run a study into the folder `out`, or go on with it there; the result.

    study is a TOML file with the same keys, or a Study; else the arguments describe it. kind is `modes`. vehicle and
    device are one or several components, names or paths; several devices that act together are a tuple or a comma
    list. speed is an array [m/s] or A:B:STEP. set gives parameters by name (`part.name` where several parts have it):
    a number, a sequence, `A:B:N` for N values, or `~A:B` for a range from which members are drawn; under the name
    `rider` a population of riders, `~riders_2011` or `~mine.toml` with standard errors and correlations. The runs are
    the product of all; count members are drawn, with `seed`, by the design `sobol`, `latin_hypercube`, `random` or
    `members`. options are those of the kind, as `duration` [s] of co-simulations.

    A run that fails is recorded with its reason. An interrupted study goes on from its complete chunks; another study
    in the same folder is refused. scheduler is the address of a Dask cluster; else so many workers of this machine are
    used. Raises InputError before anything runs for whatever cannot be run, MissingToolError without `motofmi[scale]`.

        >>> devices, speed = ["none", "damper:7.5"], [20.0, 30.0]
        >>> found = mf.sweep(device=devices, speed=speed, set={"rider": "~riders_2011"}, count=2, out="riders")
        >>> found.runs, found.failed, set(found.table["status"])
        (4, 0, {'done'})
        >>> found.dataset.eigenvalue.dims, found.to_xarray() is found.dataset
        (('vehicle', 'device', 'rider', 'mode', 'speed'), True)
        >>> found.share_unstable("weave").shape
        (1, 2, 2)
        >>> figure, page, chart = found.plot(), found.report(), found.show().save("share.html")
        >>> found.to_dict()["runs"] == len(found.to_dataframe())
        True
    """
    if isinstance(study, Study):
        described = study
    elif study is not None:
        described = Study.read(study)
    else:
        described = Study.of({"kind": kind, "vehicle": vehicle, "device": device, "speed": speed, "set": set or {},
                              "count": count, "design": design, "seed": seed, **options})  # fmt: skip
    if workers is not None and workers < 1:
        raise InputError(f"workers = {workers}: expected 1 or more")
    return Prepared.of(described, out).run(scheduler, workers)
