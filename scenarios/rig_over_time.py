"""The gap workflow on rig runs that follow no swept or stepped sine (multisines, random motion): simulated over time."""

import argparse
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

from fmus.effects import Effect
from fmus.progress import track
from identification.gap.data.runs import usable
from identification.gap.data.sampled import prepare_sampled
from identification.gap.naming.any_component import Investigation, investigate
from identification.gap.stands.component_test import ComponentTest
from identification.gap.stands.test_stand import TestStand
from identification.recordings import Recording, read_recording
from scenarios.component_test import limitations_of, result_of
from scenarios.recordings_on_the_command_line import mapping_of
from scenarios.verdict_file import writing_so_far

OVER_TIME = ("The imposed angle follows no swept or stepped sine: the runs are compared over time, where the noise is not known apart. "
             "A sweep tells more (motofmi gap --plan).")  # fmt: skip


def run_over_time(arguments: argparse.Namespace, stand: TestStand, library: Sequence[type[Effect]]) -> tuple[Investigation, dict[str, Any]]:
    """What is found in the recordings of a rig test, and what `verdict.json` says of it so far."""
    test = ComponentTest(stand.component, (stand.imposed,), (stand.measured,), stand.free, stand.imposed, measured_effects=stand.measured_effects)
    recordings, held = (_read(files, stand, arguments.map) for files in (arguments.files, arguments.holdout))
    runs = [prepare_sampled(r, test) for r in recordings]
    notes = [OVER_TIME, *(note for r in (*recordings, *held) for note in r.warnings), *(note for r in runs for note in r.notes)]
    so_far = writing_so_far(Path(arguments.out), lambda verdict: result_of(verdict, []))
    found = investigate(test, runs, so_far=so_far, holdout=held, library=library)
    result = result_of(found.verdict, notes)
    result["limitations"] += limitations_of(found, result, stand.component, bool(held))
    return found, result


def _read(files: Sequence[str], stand: TestStand, mapping: Sequence[str]) -> list[Recording]:
    """The recordings, their columns named as the variables of the rig."""
    mapped = mapping_of(mapping)
    recordings = [read_recording(path, mapped or None) for path in track(files, "reading")]
    usable(recordings)
    called = {stand.columns["imposed"]: stand.imposed, stand.columns["measured"]: stand.measured}
    return [replace(r, columns={new: r[old] for old, new in called.items()}, units={new: r.units[old] for old, new in called.items()}) for r in recordings]
