"""The arguments of `find_gap`: recordings by their use, the tested component or vehicle, and the settings."""

import inspect
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from fmus.declaration.component import Component
from fmus.effects import Effect, load_folder
from fmus.support.errors import InputError
from fmus.support.progress import track
from motofmi.gap.criteria import Criteria
from motofmi.gap.preprocessing.eigenvalues import MeasuredEigenvalues, has_eigenvalues, read_eigenvalues
from motofmi.recordings.channels import UNITS
from motofmi.recordings.reading import read_recording
from motofmi.recordings.recording import Recording
from motofmi.recordings.rig_file import read_rig
from motofmi.workflows import components
from motofmi.workflows.components import ComponentLike
from motofmi.workflows.measured import Rig, rig_of

Measured = str | Path | Recording | MeasuredEigenvalues  # one run, or the path of its file


@dataclass(frozen=True)
class Given:
    """The arguments of `find_gap`, as described there. Files are read on demand and only once."""

    recordings: Sequence[Measured]
    validation: Sequence[Measured] = ()
    bare: Sequence[Measured] = ()
    component: ComponentLike | None = None
    vehicle: ComponentLike | None = None
    device: ComponentLike | None = None
    rider: str = "mean_2011"
    rig: Rig | None = None
    impose: str = ""
    free: Sequence[str] = ()
    mapping: Mapping[str, str] = field(default_factory=dict)
    effects: str | Path | Sequence[type[Effect]] = ()
    rate: float | None = None
    criteria: Criteria = Criteria()
    _read: dict[tuple[str, Any], list[Recording]] = field(default_factory=dict)

    @property
    def files(self) -> list[Path]:
        """The files of the recordings, fitted ones first; recordings that were not read from files have none."""
        given = (*self.recordings, *self.validation, *self.bare)
        found = [Path(each) if isinstance(each, str | Path) else getattr(each, "path", None) for each in given]
        return [path for path in found if path is not None]

    @property
    def holds_eigenvalues(self) -> bool:
        """Whether the first recording is a table of eigenvalues over speed."""
        first = self.recordings[0]
        return isinstance(first, MeasuredEigenvalues) or (isinstance(first, str | Path) and has_eigenvalues(str(first)))

    @property
    def own_effects(self) -> list[type[Effect]]:
        """The user's own effects, from a folder or given as classes."""
        return load_folder(self.effects) if isinstance(self.effects, str | Path) else list(self.effects)

    @property
    def effects_folder(self) -> str | None:
        """The folder of the user's own effects, to which a value file refers; None if there is none."""
        return str(self.effects) if isinstance(self.effects, str | Path) else None

    def runs(self, use: str, quantities: Mapping[str, str] = UNITS) -> list[Recording]:
        """The recordings of one use (`recordings`, `validation` or `bare`).

        quantities holds the expected variables with their SI units. Raises InputError for a file that cannot be read.
        """
        key = (use, tuple(quantities.items()))
        if key not in self._read:
            self._read[key] = [self._recording(each, quantities) for each in track(getattr(self, use), "reading")]
        return self._read[key]

    def _recording(self, each: Measured, quantities: Mapping[str, str]) -> Recording:
        if isinstance(each, Recording):
            return each
        if isinstance(each, MeasuredEigenvalues):
            raise InputError(
                f"{each.name} holds eigenvalues over speed, expected a recording over time as in the first file"
            )
        return read_recording(each, self.mapping or None, self.rate, quantities)

    def spectra(self, use: str) -> list[MeasuredEigenvalues]:
        """The eigenvalue tables of one use. Raises InputError for recordings and for files that cannot be read."""
        given = getattr(self, use)
        if wrong := [each.name for each in given if isinstance(each, Recording)]:
            raise InputError(
                f"{', '.join(wrong)}: recordings over time, expected eigenvalues over speed as in the first file"
            )
        return [each if isinstance(each, MeasuredEigenvalues) else read_eigenvalues(str(each)) for each in given]

    @property
    def rig_contents(self) -> Mapping[str, Any]:
        """The contents of the given `rig.json`, else of the one beside the first recording; empty if there is none.

        Raises InputError if the given file does not exist.
        """
        first = self.recordings[0]
        if self.rig is None and isinstance(first, str | Path):
            return read_rig(Path(first).parent)
        return rig_of(self.rig, [first] if isinstance(first, Recording) else [])

    @property
    def tested(self) -> Component:
        """The component with recorded inputs and outputs. Raises InputError for an unknown name."""
        assert self.component is not None
        return components.component(self.component)

    @property
    def own_class(self) -> tuple[str, str] | None:
        """File and class name of a user's own component; None for a shipped one or if the file is unknown."""
        if isinstance(self.component, Component):
            kind = type(self.component)
            if components.COMPONENTS.get(kind.__name__) is kind:
                return None
            try:
                return inspect.getfile(kind), kind.__name__
            except (TypeError, OSError):  # declared in a notebook
                return None
        file, _, title = str(self.component).rpartition(":")
        return (file, title) if file.endswith(".py") else None

    @property
    def base_vehicle(self) -> Component:
        """The vehicle. Raises InputError for an unknown name."""
        assert self.vehicle is not None
        return components.vehicle(self.vehicle)

    @property
    def base_device(self) -> Component | None:
        """The device at the vehicle's handlebar, or None. Raises InputError for an unknown name."""
        return components.device(self.device)
