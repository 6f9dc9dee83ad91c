"""The recordings of a workflow, given as paths or objects, one or several, and the contents of `rig.json`."""

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from fmus.support.errors import InputError
from motofmi.recordings.reading import read_recording
from motofmi.recordings.recording import Recording
from motofmi.recordings.rig_file import read_rig

Recorded = str | Path | Recording
Rig = str | Path | Mapping[str, Any]


def recordings_of(
    given: Recorded | Sequence[Recorded], mapping: Mapping[str, str] | None = None, rate: float | None = None
) -> list[Recording]:
    """The recordings; files are read with other names for columns and at a reduced rate [Hz]. Raises InputError
    where there is none."""
    every = [given] if isinstance(given, str | Path | Recording) else list(given)
    if not every:
        raise InputError("no recordings: give at least one")
    return [each if isinstance(each, Recording) else read_recording(each, mapping or None, rate) for each in every]


def paths_of(recordings: Sequence[Recording]) -> tuple[Path, ...]:
    """The files from which recordings were read; recordings that were made otherwise have none."""
    return tuple(run.path for run in recordings if run.path is not None)


def rig_of(given: Rig | None, recordings: Sequence[Recording]) -> Mapping[str, Any]:
    """The contents of a rig.json, by default of the one beside the first recording. Raises InputError for a
    file that does not exist."""
    if given is None:
        return recordings[0].rig if recordings else {}
    if isinstance(given, Mapping):
        return given
    if not Path(given).exists():
        raise InputError(f"cannot read {given}: no such file; expected a rig.json with handlebar_inertia and others")
    return read_rig(given)
