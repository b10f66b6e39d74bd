"""A case of parts as far as it can be read: what the rules look at before all of it is known to be right."""

from collections.abc import Iterator, Mapping
from typing import Any, NamedTuple

from vibsim.cases.parts.ends import Ends
from vibsim.cases.values.quantities import Quantity

JOINING = ("links", "stops", "friction", "clearances")  # sections of parts with two ends
PARTS = ("links", "stops", "friction", "forces", "clearances")
CALLED = {
    "bodies": "body",
    "links": "link",
    "stops": "stop",
    "friction": "friction",
    "forces": "force",
    "clearances": "clearance",
}


class Finding(NamedTuple):
    """What a rule finds wrong.

    Attributes
    ----------
    key : dotted key to be named
    message : what is wrong and what is allowed
    at : dotted key of the place, where that is another one
    of_the_name : True where the key itself is to blame and not its value
    """

    key: str
    message: str
    at: str = ""
    of_the_name: bool = False


class Draft:
    """Bodies and parts of a case that may still be wrong."""

    def __init__(self, flat: Mapping[str, Any], values: Mapping[str, Any]):
        self.flat, self.values = flat, values

    def section(self, *path: str) -> dict[str, Any]:
        """What stands at a path, where that is a mapping; else nothing."""
        inner: Any = self.values
        for name in path:
            inner = inner.get(name) if isinstance(inner, dict) else None
        return inner if isinstance(inner, dict) else {}

    @property
    def bodies(self) -> list[str]:
        return list(self.section("bodies"))

    def parts(self, *sections: str) -> Iterator[tuple[str, dict[str, Any]]]:
        """(dotted key, keys) of each part that is a mapping."""
        for section in sections:
            for name, part in self.section(section).items():
                if isinstance(part, dict):
                    yield f"{section}.{name}", part

    def ends(self) -> Iterator[tuple[str, Ends]]:
        """(dotted key, ends) of each part with two of them that can be read."""
        for key, part in self.parts(*JOINING):
            ends = Ends.read(part.get("between"))
            if ends is not None:
                yield key, ends

    def quantity(self, key: str) -> Quantity | None:
        value = self.flat.get(key)
        return value if isinstance(value, Quantity) else None
