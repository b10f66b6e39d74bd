"""What one value of a case must be: its dimension and its range, as a note in the annotation of a key."""

from fractions import Fraction
from functools import lru_cache
from typing import Any, NamedTuple

from vibsim.cases.problems import shown
from vibsim.cases.schema.kinds import kind_of_value
from vibsim.cases.values.quantities import NUMBER, Quantity, QuantityError, parse_quantity
from vibsim.cases.values.units import si_unit, unit_names

_exact = lru_cache(maxsize=64)(Fraction)  # of the few texts that bounds are written as


class Measured(NamedTuple):
    """A quantity of one dimension and its range, for use inside Annotated.

    Attributes
    ----------
    dimension : name in the unit table, such as "length"
    above, least, most : the value must be > above, >= least, <= most (texts in SI units; None: no bound)
    nonzero : the value must not be 0
    word : a word that may stand in place of the quantity, such as "fixed"
    alternative : what else may stand there, for messages
    """

    dimension: str
    above: str | None = None
    least: str | None = None
    most: str | None = None
    nonzero: bool = False
    word: str | None = None
    alternative: str = ""

    def read(self, value: object) -> Quantity | str:
        """The quantity behind a text (or the word). Raises QuantityError."""
        if isinstance(value, Quantity):
            return value
        if isinstance(value, bool) or not isinstance(value, str | int | float):
            raise QuantityError(f"must be a single value, got {kind_of_value(value)}")
        text = str(value)
        if self.word is not None and text.strip() == self.word:
            return self.word
        alternative = f"the word {self.word}" if self.word else self.alternative
        quantity = parse_quantity(text, self.dimension, alternative)
        broken = self.broken_bound(quantity.value)
        if broken:
            raise QuantityError(f"must be {broken}, got {shown(text)}")
        return quantity

    def broken_bound(self, value: Fraction) -> str | None:
        """The bound that a value breaks, in words; None inside the range."""
        if self.nonzero and value == 0:
            return "different from 0"
        if self.above is not None and value <= _exact(self.above):
            return f"> {self.above}"
        if self.least is not None and value < _exact(self.least):
            return f">= {self.least}"
        if self.most is not None and value > _exact(self.most):
            return f"<= {self.most}"
        return None

    def json_schema(self) -> dict[str, Any]:
        """A number in SI units with its bounds, a text with a unit, or the word."""
        units = unit_names(self.dimension)
        tail = r"\s*[^\s0-9].*" if self.dimension == "angular rate" else ".*" if units else r"\s*"
        text: dict[str, Any] = {"type": "string", "pattern": rf"^\s*{NUMBER}(\s*/\s*\d+)?{tail}$"}
        if units:
            text["description"] = f"number and unit: {', '.join(units)}"
        choices = [text]
        if self.dimension != "angular rate":
            choices.insert(
                0, {"type": "number", "description": f"in {si_unit(self.dimension).name or 'no unit'}"}
            )
            choices[0] |= self._json_bounds()
        if self.word is not None:
            choices.append({"const": self.word})
        return {"anyOf": choices}

    def _json_bounds(self) -> dict[str, Any]:
        bounds = {"exclusiveMinimum": self.above, "minimum": self.least, "maximum": self.most}
        keywords: dict[str, Any] = {name: float(bound) for name, bound in bounds.items() if bound is not None}
        return keywords | ({"not": {"const": 0}} if self.nonzero else {})
