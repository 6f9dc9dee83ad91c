"""Every public name, from its docstring."""

import inspect

import motofmi

INTRODUCTION = """# Python interface

One import, `import motofmi as mf`. [By example](../../python.md) shows them at work; quantities are in SI units.
"""


def page() -> str:
    names = [name for name in sorted(motofmi.__all__) if not name.startswith("__")]
    return INTRODUCTION + "".join(_section(name) for name in names)


def _section(name: str) -> str:
    found = getattr(motofmi, name)
    signature = _signature(found)
    lines = (inspect.getdoc(found) or "").splitlines()
    text = "\n".join(lines)
    return f"\n## {name}\n\n```python\n{name}{signature}\n```\n\n```text\n{text}\n```\n"


def _signature(found: object) -> str:
    """The parameters without their types, which the docstring states in words."""
    if not callable(found):
        return ""
    try:
        given = inspect.signature(found)
    except ValueError:
        return "(...)"
    parameters = [p.replace(annotation=inspect.Parameter.empty) for p in given.parameters.values()]
    return str(given.replace(parameters=parameters, return_annotation=inspect.Signature.empty))
