"""Every public name and every class that a public function returns, from their docstrings."""

import inspect
import re
from textwrap import dedent
from typing import Any, get_type_hints

import motofmi

LONGEST_DEFAULT = 40  # characters
INTRODUCTION = """# Python interface

One import, `import motofmi as mf`. [By example](../../python.md) shows the names at work; quantities are in SI units.
In the examples `mf` is `motofmi` and `np` is `numpy`; every example is run by the tests.
"""


def page() -> str:
    names = {name: getattr(motofmi, name) for name in sorted(motofmi.__all__) if not name.startswith("__")}
    results = {found.__name__: found for each in names.values() if (found := _result(each))}
    sections = [_section(name, found) for name, found in names.items()]
    further = [_section(name, found) for name, found in sorted(results.items()) if name not in names]
    return INTRODUCTION + "".join([*sections, "\n## Results\n", *further])


def _result(function: object) -> Any:
    """The class that a function of the project returns, or None."""
    found = get_type_hints(function).get("return") if inspect.isfunction(function) else None
    return found if inspect.isclass(found) and found.__module__ != "builtins" else None


def _section(name: str, found: object) -> str:
    text = f"\n## {name}\n\n```python\n{name}{_signature(found)}\n```\n\n{_blocks(found)}"
    if inspect.isclass(found):
        members = [f"- `{n}`: {_first(getattr(found, n))}" for n in dir(found) if _shown(found, n)]
        text += "\n" + "\n".join(members) + "\n" if members else ""
    return text


def _blocks(found: object) -> str:
    """The docstring: paragraphs, what is indented as it stands, and the examples, which begin at the first prompt."""
    text, prompt, example = (inspect.getdoc(found) or "").partition("    >>> ")
    shown = "\n\n".join(_paragraph(part) for part in text.strip().split("\n\n"))
    return f"{shown}\n" + (f"\n```pycon\n{dedent(prompt + example).strip()}\n```\n" if prompt else "")


def _paragraph(text: str) -> str:
    """A paragraph as Markdown; one with indented lines as it stands."""
    return f"```text\n{dedent(text)}\n```" if re.search("^ ", text, re.MULTILINE) else _escaped(text)


def _escaped(text: str) -> str:
    """The text without what Markdown would read as markup, except in backquotes."""
    parts = re.split("(`[^`]*`)", text)
    return "".join(part if part.startswith("`") else re.sub(r"([*_<$\[\]#|])", r"\\\1", part) for part in parts)


def _shown(owner: type, name: str) -> bool:
    member = inspect.getattr_static(owner, name)
    described = inspect.isfunction(member) or hasattr(member, "fget") or hasattr(member, "func")
    return not name.startswith("_") and described and bool(inspect.getdoc(getattr(owner, name)))


def _first(member: object) -> str:
    """The first paragraph of a docstring."""
    return _escaped(" ".join((inspect.getdoc(member) or "").split("\n\n")[0].split()))


class _Long:
    """Stands for a default value whose text is long."""

    def __repr__(self) -> str:
        return "..."


def _default(parameter: inspect.Parameter) -> Any:
    long = parameter.default is not parameter.empty and len(repr(parameter.default)) > LONGEST_DEFAULT
    return _Long() if long else parameter.default


def _signature(found: object) -> str:
    """The parameters without their types, which the docstring states in words."""
    if not callable(found):
        return ""
    try:
        given = inspect.signature(found)
    except ValueError:
        return "(...)"
    parameters = [p.replace(annotation=inspect.Parameter.empty, default=_default(p)) for p in given.parameters.values()]
    return str(given.replace(parameters=parameters, return_annotation=inspect.Signature.empty))
