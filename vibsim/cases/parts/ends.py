"""The two ends of a part, as written: `between: [ram, ground]`."""

from typing import Any, NamedTuple

from vibsim.cases.problems import shown
from vibsim.cases.schema.kinds import Single

GROUND, BASE = "ground", "base"
NO_BODIES = (GROUND, BASE)  # ends that are no bodies


class Ends(NamedTuple):
    """Names of the ends P and Q of a part: a body, ground or base."""

    P: str
    Q: str

    def __str__(self) -> str:
        return f"[{self.P}, {self.Q}]"

    @staticmethod
    def read(value: object) -> "Ends | None":
        """The ends behind a list, a tree's {"1": P, "2": Q} or a text such as "[P, Q]"; None for others."""
        if isinstance(value, Ends):
            return value
        if isinstance(value, str):
            text = value.strip()
            listed = text.startswith("[") and text.endswith("]")
            value = (text[1:-1] if listed else text).split(",")
            if any(bracket in name for name in value for bracket in "[]"):
                return None
        if isinstance(value, dict):
            value = [value.get("1"), value.get("2")] if len(value) == 2 else None
        names = value
        if not isinstance(names, list | tuple) or len(names) != 2:
            return None
        if not all(isinstance(name, str) and name.strip() for name in names):
            return None
        return Ends(names[0].strip(), names[1].strip())

    @staticmethod
    def as_kind() -> Single:
        return Single(_TwoEnds())


class _TwoEnds:
    """What a key that holds two ends takes."""

    def read(self, value: object) -> Ends:
        ends = Ends.read(value)
        if ends is None:
            value_text = _shown_places(value) if isinstance(value, dict) else shown(value)
            raise ValueError(
                f"must be two ends such as [ram, ground]: bodies, ground or base; got {value_text}"
            )
        return ends

    def json_schema(self) -> dict[str, Any]:
        """A list of two names."""
        name = {"type": ["string", "integer"]}  # a body may be called 1
        return {"type": "array", "items": name, "minItems": 2, "maxItems": 2}


def _shown_places(value: dict[str, object]) -> str:
    """What stands in place of the two ends, a list or a mapping, with what has been reported already left
    out.
    """
    items = {place: item if isinstance(item, str) else "..." for place, item in value.items()}
    if all(place.isdecimal() for place in items):
        return shown(f"[{', '.join(items.values())}]")
    return shown(f"{{{', '.join(f'{place}: {item}' for place, item in items.items())}}}")
