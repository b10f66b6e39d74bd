"""Imports on first use, so that `import vibsim` costs next to nothing."""

from __future__ import annotations

import sys
from importlib import import_module

TYPE_CHECKING = False  # to type checkers it is true
if TYPE_CHECKING:
    from collections.abc import Callable
    from functools import cached_property
    from typing import Any

    Lazy = tuple[Callable[[str], Any], Callable[[], list[str]], list[str]]


# What lower rooms call of the highest ones, by name -> "module:name"; the package itself fills it in
FRONT: dict[str, str] = {}


def lazy_names(package: str) -> Lazy:
    """`__getattr__`, `__dir__` and `__all__` of a package: of the names that it imports for type checkers.

    These stand once, as `from MODULE import NAME as NAME` under `if TYPE_CHECKING:`, and are read there.
    """
    modules = {}
    with open(str(sys.modules[package].__file__), encoding="utf-8") as source:
        for line in source:
            words = line.split()
            if line.startswith("    from ") and words[2::2] == ["import", "as"] and words[3] == words[5]:
                modules[words[3]] = words[1]

    def imported(name: str) -> Any:
        if name not in modules:
            raise AttributeError(f"module {package!r} has no attribute {name!r}")
        value = getattr(import_module(modules[name]), name)
        setattr(sys.modules[package], name, value)
        return value

    public = sorted(modules)
    return imported, lambda: sorted(public), public


def named(path: str) -> Any:
    """The object of a name such as "vibsim.plots.picture:plot", its module imported."""
    module, _, name = path.partition(":")
    return getattr(import_module(module), name)


# Attributes that are worked out once, when they are first asked for.


if TYPE_CHECKING:
    once = cached_property
else:

    class once:
        """As `functools.cached_property`, whose lock (before Python 3.12) takes longer than most of what a
        point of a branch works out.
        """

        def __init__(self, function: Callable[[Any], Any]):
            self.function, self.name, self.__doc__ = function, function.__name__, function.__doc__

        def __get__(self, instance: object | None, owner: type) -> Any:
            if instance is None:
                return self
            value = instance.__dict__[self.name] = self.function(instance)
            return value
