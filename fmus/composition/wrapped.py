"""A component around another one, with further variables and elements."""

from collections.abc import Iterable, Mapping
from typing import Any

from fmus.declaration.component import Component
from fmus.declaration.elements import Element
from fmus.declaration.variables import Variable
from fmus.effects import Effect
from fmus.support.errors import unknown


class WrappedComponent(Component):
    """Base of components around another one, `inner`, whose parameters they share.

    The constructor of a subclass takes inner, its own `arguments` by name, and effects.
    """

    inner: Component
    arguments: Mapping[str, Any]

    def _begin(self, inner: Component, name: str, names: Iterable[tuple[str, str]], **arguments: Any) -> None:
        """Set the inner component and the arguments; names are (role, name) of variables that it must have.

        Raises InputError with the valid names for any other.
        """
        valid_of = {"input": inner.inputs, "output": inner.outputs, "state": inner.states}
        for role, variable in names:
            if variable not in (valid := valid_of[role]):
                raise unknown(f"{role} of {inner.name}", variable, valid)
        Component.__init__(self, name, inner.source)
        self.inner, self.arguments = inner, arguments
        vars(self).update(arguments)

    def _complete(self, table: dict[str, Variable], elements: dict[str, Element], effects: Iterable[Effect]) -> None:
        """Set the table and the elements, add the effects, and take the values of the inner component."""
        self.table, self.elements = table, elements  # type: ignore[misc]
        self.effects = tuple(effects)
        for effect in self.effects:
            effect.join(self)
        added = {n: row.start for n, row in self.rows("parameter").items() if n not in self.inner.values}
        self.values = {**self.inner.values, **added}

    @property
    def structure(self) -> tuple:
        """What the equations depend on besides values (see `Component.structure`)."""
        return (
            type(self),
            self.inner.structure,
            *self.arguments.values(),
            *(e.structure for e in self.effects),
        )

    def _remade(self, effects: tuple, values: Any) -> Component:
        inner = self.inner.with_values(**{n: v for n, v in values.items() if n in self.inner.values})
        kind: Any = type(self)
        twin = kind(inner, **self.arguments, effects=effects)
        twin._set_values({n: v for n, v in values.items() if n in twin.values})
        return twin
