"""Data classes whose methods are written when they are first needed.

`dataclasses.dataclass` writes and compiles five to seven functions of every class when its module is
imported, 0.25 ms; a command needs a hundred such classes, most of whose functions are never called. Here all
classes share one comparison, one hash and one representation, and an initializer, the same as that of
`dataclasses`, is compiled when the first instance is made. All else is as there: `fields`, `replace` and
`asdict` work.
"""

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from dataclasses import dataclass as dataclass
else:
    import dataclasses
    from dataclasses import MISSING, FrozenInstanceError, fields
    from operator import attrgetter
    from reprlib import recursive_repr
    from types import MethodType

    class _Factory:
        """The default of an argument that is made anew."""

        def __repr__(self):
            return "<factory>"

    FACTORY = _Factory()

    def dataclass(cls=None, /, *, frozen=False, slots=False, repr=True):
        """As `dataclasses.dataclass`, without the options that nobody here asks for."""

        def made(cls):
            return _data_class(cls, frozen, slots, repr)

        return made if cls is None else made(cls)

    def _data_class(cls, frozen, slots, shown):
        documented = cls.__doc__
        cls.__doc__ = documented or cls.__name__  # else a signature is made up for it
        cls = dataclasses.dataclass(init=False, repr=False, eq=False, slots=slots)(cls)
        cls.__doc__ = documented
        methods = _comparison(cls, frozen) | ({"__repr__": _representation(cls)} if shown else {})
        methods |= (_frozen(cls) if frozen else {}) | (_state() if slots else {})
        for name, method in methods.items():
            if name not in cls.__dict__ or (name == "__hash__" and cls.__dict__[name] is None):
                setattr(cls, name, method)
        if "__init__" not in cls.__dict__:
            cls.__init__ = _Initializer(cls, frozen)
        return cls

    def _comparison(cls, frozen):
        """Equality, and a hash where instances do not change, by the values of all fields."""
        values = _values(tuple(field.name for field in fields(cls) if field.compare))

        def equal(self, other):
            return values(self) == values(other) if other.__class__ is self.__class__ else NotImplemented

        return {"__eq__": equal, "__hash__": (lambda self: hash(values(self))) if frozen else None}

    def _values(names):
        """What gives the values of these fields as a tuple: tuples take a value that is itself for equal."""
        if len(names) > 1:
            return attrgetter(*names)
        return lambda self: tuple(getattr(self, name) for name in names)

    def _representation(cls):
        names = [field.name for field in fields(cls) if field.repr]

        @recursive_repr()
        def representation(self):
            content = ", ".join(f"{name}={getattr(self, name)!r}" for name in names)
            return f"{self.__class__.__qualname__}({content})"

        return representation

    def _frozen(cls):
        """What refuses to change the fields; other attributes of classes that inherit them may change."""
        names = frozenset(field.name for field in fields(cls))

        def set_attribute(self, name, value):
            if type(self) is cls or name in names:
                raise FrozenInstanceError(f"cannot assign to field {name!r}")
            super(cls, self).__setattr__(name, value)

        def delete_attribute(self, name):
            if type(self) is cls or name in names:
                raise FrozenInstanceError(f"cannot delete field {name!r}")
            super(cls, self).__delattr__(name)

        return {"__setattr__": set_attribute, "__delattr__": delete_attribute}

    def _state():
        """Pickling of classes with slots."""

        def state(self):
            return [getattr(self, field.name) for field in fields(self)]

        def restore(self, values):
            for field, value in zip(fields(self), values, strict=True):
                object.__setattr__(self, field.name, value)

        return {"__getstate__": state, "__setstate__": restore}

    class _Initializer:
        """Stands for `__init__` until it is called or looked at."""

        def __init__(self, cls, frozen):
            self.cls, self.frozen = cls, frozen

        def __get__(self, instance, owner):
            return self if instance is None else MethodType(self, instance)

        def __call__(self, instance, /, *arguments, **named):
            initialize = self.cls.__init__ = self.written()
            initialize(instance, *arguments, **named)

        @property
        def __signature__(self):
            from inspect import signature

            return signature(self.written())

        def written(self):
            """The initializer: it sets every field, and calls `__post_init__` where there is one."""
            known = {"put": object.__setattr__, "FACTORY": FACTORY}
            arguments, lines, last = ["self"], [], ["*"]
            for field in fields(self.cls):
                if not field.init:
                    raise TypeError(f"{self.cls.__qualname__}.{field.name}: init=False is not known here")
                (last if field.kw_only else arguments).append(_argument(field, known))
                value = _value(field)
                lines.append(
                    f"put(self, {field.name!r}, {value})" if self.frozen else f"self.{field.name} = {value}"
                )
            if hasattr(self.cls, "__post_init__"):
                lines.append("self.__post_init__()")
            listed = ", ".join(arguments + (last if len(last) > 1 else []))
            exec(f"def __init__({listed}):\n " + "\n ".join(lines or ["pass"]), known)
            initializer = known["__init__"]
            initializer.__qualname__ = f"{self.cls.__qualname__}.__init__"
            initializer.__module__ = self.cls.__module__
            types = {field.name: field.type for field in fields(self.cls)}
            initializer.__annotations__ = types | {"return": None}
            return initializer

    def _argument(field, known):
        """A field as an argument; what it refers to is put into `known`."""
        if field.default_factory is not MISSING:
            known[f"make_{field.name}"] = field.default_factory
            return f"{field.name}=FACTORY"
        if field.default is MISSING:
            return field.name
        known[f"default_{field.name}"] = field.default
        return f"{field.name}=default_{field.name}"

    def _value(field):
        if field.default_factory is MISSING:
            return field.name
        return f"make_{field.name}() if {field.name} is FACTORY else {field.name}"
