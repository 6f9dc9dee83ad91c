"""Results that depend on the structure of a component alone, derived once for all its parameter values."""

from collections import OrderedDict
from collections.abc import Callable
from functools import update_wrapper
from threading import Lock
from typing import Any, Generic, TypeVar

from fmus.declaration.component import Component

T = TypeVar("T")
# Structures whose results are kept. A verdict of the gap workflow needs up to 300; a batch of verdicts, whose effects
# are new classes each time, would fill the memory.
KEPT = 512


class once_per_structure(Generic[T]):  # noqa: N801
    """A function of a component that is called once for each structure; the results of the latest structures are kept.

    @once_per_structure
    def count(component): return len(component.states)
    """

    def __init__(self, derive: Callable[[Component], T]):
        self.derive, self.kept, self.lock = derive, OrderedDict[Any, T](), Lock()
        update_wrapper(self, derive)

    def __call__(self, component: Component) -> T:
        """The result for the component. Raises what the function raises."""
        key = component.structure
        with self.lock:
            if key in self.kept:
                self.kept.move_to_end(key)
                return self.kept[key]
        found = self.derive(component)
        with self.lock:
            self.kept[key] = found
            if len(self.kept) > KEPT:
                self.kept.popitem(last=False)
        return found
