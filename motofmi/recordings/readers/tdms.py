"""TDMS files, as LabVIEW and other programs of National Instruments write them."""

from pathlib import Path

import numpy as np

from motofmi.recordings.table import Format, Table

UNITS = ("unit_string", "NI_UnitDescription")  # properties that give a channel's unit
TIMED = "wf_increment"  # property of a waveform: its sampling interval [s]


def read(path: Path) -> Table:
    """The numeric channels. Waveforms are put on the time base of the one with most samples; else a
    channel gives the time.

    A name that stands in several groups is called `group.name`.
    """
    from nptdms import TdmsFile  # noqa: PLC0415 - an optional package

    channels = [
        channel
        for group in TdmsFile.read(path).groups()
        for channel in group.channels()
        if channel.dtype.kind in "fiu" and len(channel)
    ]
    names = [channel.name for channel in channels]
    waves = [channel.time_track() for channel in channels if TIMED in channel.properties]
    base = max(waves, key=len) if waves else None
    found = [] if base is None or "time" in names else [("time", "s", base)]
    for channel in channels:
        values = channel[:]
        if base is not None and TIMED in channel.properties:
            values = np.interp(base, channel.time_track(), values)
        unit = next((channel.properties[key] for key in UNITS if channel.properties.get(key)), "")
        found.append(
            (channel.name if names.count(channel.name) == 1 else f"{channel.group_name}.{channel.name}", unit, values)
        )
    return Table.of(found)


FORMAT = Format("TDMS", (".tdms",), read, needs="nptdms")
