"""FMUs from components that are given by name."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from fmus.export.build import BuiltFmu, build_all
from fmus.support.errors import InputError, unknown
from fmus.support.notebook import html
from fmus.support.progress import track
from motofmi.workflows.components import ComponentLike, component, every_name
from motofmi.workflows.corner import in_corner
from motofmi.workflows.ssp_archive import SPEED, build_ssp

VERSIONS = ("2", "3")


@dataclass(frozen=True, repr=False)
class BuiltFmus:
    """The archives that were written, each with name, path, SHA-256 and platforms; `build` shows an example."""

    fmus: tuple[BuiltFmu, ...]
    ssp: Path | None = None  # the archive that holds them

    def __len__(self) -> int:
        return len(self.fmus)

    def __iter__(self) -> Iterator[BuiltFmu]:
        return iter(self.fmus)

    def __getitem__(self, index: int) -> BuiltFmu:
        return self.fmus[index]

    @property
    def path(self) -> Path:
        """The path of the only archive. Raises InputError if there are several."""
        if len(self.fmus) != 1:
            raise InputError(
                f"{len(self.fmus)} archives were written, so there is no single path: take built[0].path, "
                "built[1].path and so on"
            )
        return self.fmus[0].path

    def __repr__(self) -> str:
        return f"BuiltFmus({', '.join(str(fmu.path) for fmu in self.fmus)})"

    def _repr_html_(self) -> str:
        return html(
            "FMUs",
            ("path", "platforms", "sha256"),
            [(fmu.path, " ".join(fmu.platforms), fmu.sha256[:16]) for fmu in self.fmus],
        )

    def to_dict(self) -> dict[str, Any]:
        """The keys of `motofmi build --json`."""
        fmus = [
            {"name": f.name, "path": str(f.path), "sha256": f.sha256, "platforms": list(f.platforms)} for f in self.fmus
        ]
        return {"fmus": fmus, "ssp": None if self.ssp is None else str(self.ssp)}

    def to_dataframe(self) -> Any:
        """One row for each archive (pandas.DataFrame)."""
        import pandas as pd  # noqa: PLC0415 - imported on use

        return pd.DataFrame(self.to_dict()["fmus"])


def build(given: ComponentLike | Sequence[ComponentLike] | None = None, out: str | Path = ".", *, fmi: int | str = 2,
          backend: str = "compiled", platforms: str = "host",
          set: Mapping[str, float] | None = None, ssp: str | Path | None = None, ssp_version: int | str = 1,
          initial: Mapping[str, float] | None = None, speed: float = SPEED,
          lean: float | None = None) -> BuiltFmus:  # fmt: skip
    """Write FMUs of components, of names, or of value files into a folder; without `given`, of every shipped
    component.

    given is a component or several; out is the folder. fmi is 2 or 3, backend `compiled` or `python` (FMI 2 only),
    platforms `host`, `all` or a comma list. set changes parameters of a single component. With `ssp` the path of an
    archive of SSP 1.0 or 2.0 (`ssp_version`) is written in place of the folder: of one vehicle and the devices at its
    ports, with `initial` states and a speed [m/s] to start from. With a `lean` angle [deg] the FMU is that of a vehicle
    in large motion (tum_2020), which starts in steady turning at that lean angle and the speed, as `trim` finds it.
    Raises InputError for an unknown name or choice and a folder that cannot be written, MissingToolError if there is no
    C compiler.

        >>> built = mf.build(["damper:7.5", "damper:high_2011"], "out")
        >>> len(built), built[0].path.name, sorted(built.to_dict())
        (2, 'damper_7_5.fmu', ['fmus', 'ssp'])
        >>> list(built.to_dataframe().columns)
        ['name', 'path', 'sha256', 'platforms']
        >>> mf.build("damper:7.5", "out", fmi=3).path.name
        'damper_7_5_fmi3.fmu'
        >>> mf.build(["sharp_1971", "damper:7.5"], ssp="damped.ssp", speed=40.0).ssp.name
        'damped.ssp'
    """
    if str(fmi) not in VERSIONS:
        raise unknown("FMI version", fmi, VERSIONS)
    chosen: Sequence[ComponentLike] = every_name() if given is None else [given] if isinstance(given,
                                                                                               ComponentLike) else given
    if ssp is not None:
        if lean is not None:
            raise InputError("a lean angle is that of one FMU: leave out ssp, or the lean angle")
        fmus = build_ssp(chosen if given is not None else [], Path(ssp), ssp_version, fmi=int(fmi), backend=backend,
                         platforms=platforms, set=set, initial=initial, speed=speed)  # fmt: skip
        return BuiltFmus(tuple(fmus), Path(ssp))
    if set and len(chosen) != 1:
        raise InputError(f"parameters can be set of a single component, not of {len(chosen)}; build one at a time")
    if lean is not None:
        components = [in_corner(each, None, set, speed).component(lean) for each in chosen]
    else:
        components = [component(each, **(set or {})) for each in chosen]
    return BuiltFmus(tuple(built for each in track(components, "building", len(components))
                           for built in build_all(each, out, int(fmi), backend, platforms)))  # fmt: skip
