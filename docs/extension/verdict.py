"""The keys of verdict.json: the thresholds from `Criteria`, the rest by a short gap run."""

import ast
import inspect
from dataclasses import fields

from extension.tables import table
from motofmi.gap.criteria import Criteria

INTRODUCTION = """# Thresholds of the gap workflow

All decisions use the fields of `Criteria`; the values that were used are in verdict.json under `criteria`. Change
some of them with `mf.find_gap(..., criteria=dataclasses.replace(Criteria(), tie_delta_bic=6.0))`.

"""


def page() -> str:
    described = _descriptions()
    return INTRODUCTION + table(
        ("name", "value", "meaning"), [(f"`{f.name}`", f"{f.default:g}", described[f.name]) for f in fields(Criteria)]
    )


def _descriptions() -> dict[str, str]:
    """The text below each field."""
    (made,) = ast.parse(inspect.getsource(Criteria)).body
    assert isinstance(made, ast.ClassDef)
    found = {}
    for field, text in zip(made.body, made.body[1:], strict=False):
        if isinstance(field, ast.AnnAssign) and isinstance(text, ast.Expr) and isinstance(text.value, ast.Constant):
            found[ast.unparse(field.target)] = " ".join(str(text.value.value).split())
    return found
