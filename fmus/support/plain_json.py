"""Results as strict JSON, without NaN or infinity."""

import json
from pathlib import Path
from typing import Any

import numpy as np


def to_json(result: Any, indent: int | None = 1) -> str:
    """The result as JSON text: a complex number as [re, im], a number that is not finite as null, an array as a list.
    indent None gives one line without spaces.
    """
    return json.dumps(_plain(result), indent=indent, separators=None if indent else (",", ":"), allow_nan=False)


def _plain(value: Any) -> Any:
    if isinstance(value, dict):
        return {str(k): _plain(v) for k, v in value.items()}
    if isinstance(value, (list, tuple, np.ndarray)):
        return [_plain(v) for v in value]
    if isinstance(value, (complex, np.complexfloating)):
        return [_plain(value.real), _plain(value.imag)] if np.isfinite(value) else None
    if isinstance(value, (bool, np.bool_)):
        return bool(value)
    if isinstance(value, (int, np.integer)):
        return int(value)
    if isinstance(value, (float, np.floating)):
        return float(value) if np.isfinite(value) else None
    return str(value) if isinstance(value, Path) else value
