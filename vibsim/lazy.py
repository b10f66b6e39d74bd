"""Imports on first use, so that `import vibsim` costs next to nothing."""

from __future__ import annotations

import dataclasses
import sys
from collections.abc import Callable, Sequence
from dataclasses import MISSING, FrozenInstanceError
from importlib import import_module
from operator import attrgetter
from reprlib import recursive_repr
from typing import TYPE_CHECKING, Any, Generic, TypeVar, overload

if TYPE_CHECKING:
    from typing_extensions import Self


# What lower rooms call of the highest ones, by name -> "module:name"; the package itself fills it in
FRONT: dict[str, str] = {}

Lazy = tuple[Callable[[str], Any], Callable[[], list[str]], list[str]]


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


T = TypeVar("T")


class once(Generic[T]):
    """As `functools.cached_property`, whose lock (before Python 3.12) takes longer than most of what a point
    of a branch works out.
    """

    def __init__(self, function: Callable[[Any], T]):
        self.function, self.name, self.__doc__ = function, function.__name__, function.__doc__

    @overload
    def __get__(self, instance: None, owner: type) -> Self: ...
    @overload
    def __get__(self, instance: object, owner: type) -> T: ...
    def __get__(self, instance: object | None, owner: type) -> Self | T:
        if instance is None:
            return self
        value = instance.__dict__[self.name] = self.function(instance)
        return value


# Dataclasses that are made in less than half of the time: before Python 3.13 those of the standard library
# compile six texts each, which for the 50 classes of a run takes twice as long as reading its case.

Fields = Sequence["dataclasses.Field[Any]"]

if TYPE_CHECKING:
    from dataclasses import dataclass as dataclass
else:

    def dataclass(cls=None, *, frozen=False, eq=True, repr=True, **further):
        """As `dataclasses.dataclass`; of all its functions __init__ alone is compiled.

        further : other options, such as slots: a class with one is the standard library's
        """
        if further:
            return dataclasses.dataclass(cls, frozen=frozen, eq=eq, repr=repr, **further)
        if cls is None:
            return lambda cls: dataclass(cls, frozen=frozen, eq=eq, repr=repr)
        own = set(vars(cls))
        hashes_itself = vars(cls).get("__hash__") is not None or ("__hash__" in own and "__eq__" not in own)
        made = dataclasses.dataclass(init=False, repr=False, eq=False)(cls)
        of = dataclasses.fields(made)
        functions = {"__init__": _initializer(made, of, frozen)}
        if repr:
            functions["__repr__"] = _representation([one.name for one in of if one.repr])
        if eq:
            functions["__eq__"] = _comparison(_values([one.name for one in of if one.compare]))
        if frozen:
            names = {one.name for one in of}
            functions |= {"__setattr__": _refusal(made, names), "__delattr__": _refusal(made, names)}
        if eq and not hashes_itself:
            hashed = [one.name for one in of if (one.compare if one.hash is None else one.hash)]
            made.__hash__ = _hash(_values(hashed)) if frozen else None
        for name in functions.keys() - own:
            setattr(made, name, functions[name])
        return made


def _initializer(cls: type, of: Fields, frozen: bool) -> Callable[..., None]:
    """__init__ of a dataclass."""
    known: dict[str, Any] = {"_set": object.__setattr__, "_missing": MISSING}
    by_place, by_name, lines = ["self"], list[str](), list[str]()
    for one in of:
        value = name = one.name
        made = one.default_factory is not MISSING
        if made:
            known[f"_make_{name}"] = one.default_factory
            value = f"_make_{name}() if {name} is _missing else {name}" if one.init else f"_make_{name}()"
        if one.init:
            known[f"_of_{name}"] = one.default
            optional = f"{name}=_of_{name}" if made or one.default is not MISSING else name
            (by_name if one.kw_only else by_place).append(optional)
        if one.init or made:
            lines.append(f" _set(self, {name!r}, {value})" if frozen else f" self.{name} = {value}")
    if hasattr(cls, "__post_init__"):
        lines.append(" self.__post_init__()")
    named = ["*", *by_name] if by_name else []
    exec("\n".join([f"def __init__({', '.join(by_place + named)}):", *lines, " return"]), known)
    function: Callable[..., None] = known["__init__"]
    function.__qualname__ = f"{cls.__qualname__}.__init__"
    function.__annotations__ = {one.name: one.type for one in of if one.init} | {"return": None}
    return function


def _values(names: Sequence[str]) -> Callable[[Any], Any]:
    """Gives the values of attributes, as a tuple."""
    if len(names) > 1:
        return attrgetter(*names)
    return lambda one: tuple([getattr(one, name) for name in names])


def _representation(names: Sequence[str]) -> Callable[[Any], str]:
    @recursive_repr()
    def __repr__(self: Any) -> str:
        shown = ", ".join(f"{name}={getattr(self, name)!r}" for name in names)
        return f"{type(self).__qualname__}({shown})"

    return __repr__


def _comparison(values: Callable[[Any], Any]) -> Callable[[Any, Any], Any]:
    def __eq__(self: Any, other: Any) -> Any:
        return values(self) == values(other) if other.__class__ is self.__class__ else NotImplemented

    return __eq__


def _hash(values: Callable[[Any], Any]) -> Callable[[Any], int]:
    def __hash__(self: Any) -> int:
        return hash(values(self))

    return __hash__


def _refusal(cls: type, names: set[str]) -> Callable[..., None]:
    """Refuses to set or delete a field, and what else an object of the class itself may have."""

    def refuse(self: Any, name: str, *value: Any) -> None:
        if type(self) is cls or name in names:
            raise FrozenInstanceError(f"cannot {'assign to' if value else 'delete'} field {name!r}")
        above = super(cls, self)
        above.__setattr__(name, *value) if value else above.__delattr__(name)

    return refuse
