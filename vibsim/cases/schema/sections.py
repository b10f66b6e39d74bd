"""Sections of a case: classes whose annotations say what stands at their keys."""

from functools import cached_property
from inspect import cleandoc
from typing import Any, ClassVar, NoReturn, TypeVar

from vibsim.cases.schema.kinds import Fault, Json, Kind, Location, kind_of

REFERENCE = "#/$defs/"  # where JSON Schema keeps sections
REQUIRED = object()

S = TypeVar("S", bound="Section")


class Key:
    """A key of a section.

    Attributes
    ----------
    annotation : what stands there
    default : as a file would say it; REQUIRED where the key must be given
    description, examples : for people
    """

    def __init__(self, annotation: Any, default: Any, description: str, examples: list[str]):
        self.annotation, self.default = annotation, default
        self.description, self.examples = description, examples

    def is_required(self) -> bool:
        return self.default is REQUIRED

    @cached_property
    def kind(self) -> Kind:
        return kind_of(self.annotation)

    @cached_property
    def _default(self) -> Any:
        """The default, read as if a file gave it."""
        faults: list[Fault] = []
        value = None if self.default is None else self.kind.read(self.default, (), faults)
        if faults:
            raise TypeError(f"a default that is none: {faults[0].message}")
        return value

    def default_value(self) -> Any:
        """What stands at the key where it is left out; never the same mapping twice."""
        return dict(self._default) if isinstance(self._default, dict) else self._default

    def json(self, sections: dict[str, Json]) -> Json:
        """JSON Schema of the value; of the sections in it the schema is put into `sections`."""
        about: Json = {"description": self.description, "examples": self.examples}
        schema = {**self.kind.json(sections), **{name: note for name, note in about.items() if note}}
        if isinstance(self.default, str | int):
            schema["default"] = self.default
        return dict(sorted(schema.items()))


def key(description: str = "", default: Any = REQUIRED, examples: list[str] | None = None) -> Any:
    """What a class says of a key beside its annotation."""
    return Key(None, default, description, examples or [])


class Section:
    """Base of all sections: unknown keys are faults, and a section does not change once it is read."""

    keys: ClassVar[dict[str, Key]] = {}  # of the sections that inherit it too

    def __init_subclass__(cls) -> None:
        cls.keys = dict(cls.keys)
        for name, annotation in cls.__annotations__.items():
            cls.keys[name] = _key(annotation, cls.__dict__.get(name, REQUIRED))

    @classmethod
    def read(cls: type[S], values: Any, at: Location, faults: list[Fault]) -> S | None:
        """The section of nested texts; what is wrong is added to `faults`, and then it is of no use."""
        if isinstance(values, cls):
            return values
        if not isinstance(values, dict):
            faults.append(Fault("no mapping", at, values))
            return None
        section = cls.__new__(cls)
        content = section.__dict__
        for name, key in cls.keys.items():
            if name in values:
                content[name] = key.kind.read(values[name], (*at, name), faults)
            elif key.is_required():
                faults.append(Fault("missing", (*at, name), values))
            else:
                content[name] = key.default_value()
        faults += [Fault("unknown", (*at, name), values[name]) for name in values if name not in cls.keys]
        return section

    @classmethod
    def as_kind(cls) -> Kind:
        return cls

    @classmethod
    def json(cls, sections: dict[str, Json]) -> Json:
        """A reference; the JSON Schema of the section itself is put into `sections`."""
        if cls.__name__ not in sections:
            sections[cls.__name__] = {}
            sections[cls.__name__] = cls.json_schema(sections)
        return {"$ref": REFERENCE + cls.__name__}

    @classmethod
    def json_schema(cls, sections: dict[str, Json]) -> Json:
        """JSON Schema of the section, those of the sections in it beside it."""
        required = [name for name, key in cls.keys.items() if key.is_required()]
        schema: Json = {
            "additionalProperties": False,
            "description": cleandoc(cls.__doc__ or ""),
            "properties": {name: key.json(sections) for name, key in cls.keys.items()},
        }
        return schema | ({"required": required} if required else {}) | {"type": "object"}

    def __setattr__(self, name: str, value: object) -> NoReturn:
        raise AttributeError(f"a section does not change: {name}")

    def __delattr__(self, name: str) -> NoReturn:
        raise AttributeError(f"a section does not change: {name}")

    def __eq__(self, other: object) -> bool:
        return type(self) is type(other) and self.__dict__ == other.__dict__

    def __hash__(self) -> int:
        return hash((type(self), *self.__dict__.values()))

    def __repr__(self) -> str:
        content = ", ".join(f"{name}={value!r}" for name, value in self.__dict__.items())
        return f"{type(self).__name__}({content})"


def _key(annotation: Any, said: Any) -> Key:
    """A key from its annotation and what the class says of it: `key(...)`, a default alone, or nothing."""
    if isinstance(said, Key):
        return Key(annotation, said.default, said.description, said.examples)
    return Key(annotation, said, "", [])
