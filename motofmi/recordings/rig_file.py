"""`rig.json`: what is known of a rig besides its recordings."""

import json
from pathlib import Path
from typing import Any

from fmus.declaration.units import unit
from fmus.support.errors import InputError
from motofmi.recordings.channels import si_unit

NAME = "rig.json"


def read_rig(folder: str | Path) -> dict[str, Any]:
    """The entries of `rig.json`, {} without one: each {value, unit, standard_error} as in the file, in SI.

    folder is the recordings' folder or the file itself. Raises InputError for a file that is not as expected.
    """
    path = Path(folder)
    path = path / NAME if path.is_dir() else path
    if not path.exists():
        return {}
    try:
        contents = json.loads(path.read_text("utf-8"))
        rig = {}
        for name, entry in contents.items():
            if name == "noise":  # {"noise": {"angle": {"value": 0.001, "unit": "rad"}}}: deviations by channel
                rig[name] = {channel: each["value"] * unit(each["unit"]).factor for channel, each in entry.items()}
                continue
            scale = unit(entry["unit"]).factor
            rig[name] = {**entry, "value": entry["value"] * scale, "unit": si_unit(entry["unit"])}
            if "standard_error" in entry:
                rig[name]["standard_error"] = entry["standard_error"] * scale
    except (ValueError, TypeError, KeyError, AttributeError) as error:
        fault = f"no {error}" if isinstance(error, KeyError) else error
        raise InputError(f'{path}: expected {{"handlebar_inertia": {{"value": 0.125, "standard_error": 0.00125, '
                         f'"unit": "kg.m2"}}}} and the like, found {fault}') from None  # fmt: skip
    return rig
