"""What `find_gap` is given: recordings by their use, what was tested, and the settings."""

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
from motofmi.workflows.measured import Rig, rig_of

Measured = str | Path | Recording | MeasuredEigenvalues  # one run, or the path of its file
Named = components.Given  # a component, its name, or the path of its file


@dataclass(frozen=True)
class Given:
    """The arguments of `find_gap`, which describes them; files are read on demand, and once."""

    recordings: Sequence[Measured]
    validation: Sequence[Measured] = ()
    bare: Sequence[Measured] = ()
    component: Named | None = None
    vehicle: Named | None = None
    device: Named | None = None
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
    def holds_eigenvalues(self) -> bool:
        """Whether the first recording is a table of eigenvalues over speed."""
        first = self.recordings[0]
        return isinstance(first, MeasuredEigenvalues) or (isinstance(first, str | Path) and has_eigenvalues(str(first)))

    @property
    def own_effects(self) -> list[type[Effect]]:
        """The user's own effects, of a folder or as classes."""
        return load_folder(self.effects) if isinstance(self.effects, str | Path) else list(self.effects)

    @property
    def effects_folder(self) -> str | None:
        """The folder of the user's own effects, which a value file names."""
        return str(self.effects) if isinstance(self.effects, str | Path) else None

    def runs(self, use: str, quantities: Mapping[str, str] = UNITS) -> list[Recording]:
        """The recordings of one use (`recordings`, `validation` or `bare`), with the SI units of the
        names that are expected.

        Raises InputError for what cannot be read.
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
                f"{each.name} holds eigenvalues, expected a recording over time: do not mix them with recordings"
            )
        return read_recording(each, self.mapping or None, self.rate, quantities)

    def spectra(self, use: str) -> list[MeasuredEigenvalues]:
        """The eigenvalues of one use. Raises InputError for what cannot be read as such."""
        given = getattr(self, use)
        if wrong := [each.name for each in given if isinstance(each, Recording)]:
            raise InputError(
                f"{', '.join(wrong)}: recordings over time, expected eigenvalues over speed as in the first file"
            )
        return [each if isinstance(each, MeasuredEigenvalues) else read_eigenvalues(str(each)) for each in given]

    @property
    def rig_contents(self) -> Mapping[str, Any]:
        """What `rig.json` says: the file or the contents that were given, else the file beside the first recording.

        Raises InputError for a file that is not there.
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
        """File and name of the class of a user's own component, None for one that ships or whose file is unknown."""
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
        """What was at the vehicle's handlebar. Raises InputError for an unknown name."""
        return components.device(self.device)
