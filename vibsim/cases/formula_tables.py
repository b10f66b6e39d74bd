"""Tables in formulas: pairs or CSV files to exact polynomials between knots; and the size of numbers."""

import csv
import io
import math
from collections.abc import Callable
from fractions import Fraction
from itertools import pairwise
from pathlib import Path

from vibsim.cases.any_unit import any_quantity
from vibsim.cases.formula_text import MOST_PAIRS, FormulaError, parsed, walk
from vibsim.cases.problems import shown
from vibsim.cases.quantities import QuantityError, exact_number
from vibsim.physics import formulas as nodes
from vibsim.physics.formulas import Node

LARGEST_TABLE = 1_000_000  # bytes of a CSV file
MOST_EXACT = 40  # knots of a spline that is solved in fractions; of longer ones to 1e-80
DIGITS = 80

Pieces = tuple[tuple[Fraction, ...], ...]


def pieces_of(knots: list[Fraction], values: list[Fraction], kind: str) -> Pieces:
    """The polynomials between the knots of a table. Raises ValueError for tables that are none."""
    if len(knots) < 2:
        raise ValueError("a table needs at least two pairs")
    for i, (one, next_) in enumerate(pairwise(knots), 1):
        if one >= next_:
            raise ValueError(f"the first numbers of pairs must rise; those of pairs {i} and {i + 1} do not")
    return spline_pieces(knots, values) if kind == "cubic" else line_pieces(knots, values)


def line_pieces(knots: list[Fraction], values: list[Fraction]) -> Pieces:
    """Straight lines between the knots: value, and slope."""
    return tuple(
        (values[i], (values[i + 1] - values[i]) / (knots[i + 1] - knots[i])) for i in range(len(knots) - 1)
    )


def spline_pieces(knots: list[Fraction], values: list[Fraction]) -> Pieces:
    """The not-a-knot cubic spline: two cubics meet in the third derivative too at the second and last but one
    knot. With two knots a line, with three a parabola.
    """
    if len(knots) == 2:
        return line_pieces(knots, values)
    steps = [b - a for a, b in pairwise(knots)]
    slopes = [(b - a) / h for a, b, h in zip(values, values[1:], steps, strict=False)]
    if len(knots) == 3:
        bend = (slopes[1] - slopes[0]) / (steps[0] + steps[1])
        starts = [slopes[0] - bend * steps[0], slopes[0] + bend * steps[0]]
        return tuple((values[i], starts[i], bend) for i in range(2))
    bends = _second_derivatives(steps, slopes)
    return tuple(
        (
            values[i],
            slopes[i] - steps[i] * (2 * bends[i] + bends[i + 1]) / 6,
            bends[i] / 2,
            (bends[i + 1] - bends[i]) / (6 * steps[i]),
        )
        for i in range(len(steps))
    )


def _second_derivatives(steps: list[Fraction], slopes: list[Fraction]) -> list[Fraction]:
    """Second derivatives M at the knots: h_(i-1) M_(i-1) + 2 (h_(i-1) + h_i) M_i + h_i M_(i+1) = 6 (s_i -
    s_(i-1)), with M_0 = M_1 - h_0 (M_2 - M_1)/h_1 and alike at the end, which leaves three bands.
    """
    n = len(steps)
    cut = _exact if n < MOST_EXACT else _to_digits
    first, last = steps[0] / steps[1], steps[-1] / steps[-2]
    below = [steps[i - 1] for i in range(1, n)]
    middle = [2 * (steps[i - 1] + steps[i]) for i in range(1, n)]
    above = [steps[i] for i in range(1, n)]
    right = [6 * (slopes[i] - slopes[i - 1]) for i in range(1, n)]
    middle[0] += steps[0] * (1 + first)
    above[0] -= steps[0] * first
    middle[-1] += steps[-1] * (1 + last)
    below[-1] -= steps[-1] * last
    for i in range(1, n - 1):
        share = cut(below[i] / middle[i - 1])
        middle[i] = cut(middle[i] - share * above[i - 1])
        right[i] = cut(right[i] - share * right[i - 1])
    inner = [Fraction(0)] * (n - 1)
    for i in range(n - 2, -1, -1):
        behind = above[i] * inner[i + 1] if i < n - 2 else 0
        inner[i] = cut((right[i] - behind) / middle[i])
    start = inner[0] - first * (inner[1] - inner[0]) if n > 2 else inner[0]
    end = inner[-1] + last * (inner[-1] - inner[-2]) if n > 2 else inner[-1]
    return [start, *inner, end]


def _exact(value: Fraction) -> Fraction:
    return value


def _to_digits(value: Fraction) -> Fraction:
    """The value to 80 digits."""
    if not value:
        return value
    places = DIGITS - (len(str(abs(value.numerator))) - len(str(value.denominator)))
    scale = Fraction(10) ** places
    return Fraction(round(value * scale)) / scale


# Tables in CSV files: they become lists of pairs in the text of the formula, so that a case holds all of it.


def with_pairs(text: str, read: Callable[[str], str]) -> tuple[str, list[tuple[int, int, int]]]:
    """The text of a formula with lists of pairs in place of names of files; and where each name began, how
    long it was, and how long its pairs are.

    read : name of a file -> its text; raises ValueError with what is wrong. Raises FormulaError.
    """
    places: list[tuple[int, int, int]] = []
    files = [term for term in walk(parsed(text)) if term.kind == "call" and term.value == "table"]
    files = [term for term in files if term.parts[1].kind == "text"]
    for term in sorted(files, key=lambda term: -term.start):
        name = term.parts[1]
        try:
            pairs = pairs_of(read(str(name.value)))
        except ValueError as error:
            raise FormulaError(f"table {shown(name.value)}: {error}", name.start, name.end) from None
        text = text[: name.start] + pairs + text[name.end :]
        places.insert(0, (name.start, name.end - name.start, len(pairs)))
    return text, places


def table_file(name: str, folder: Path) -> str:
    """The text of a CSV file beside a case. Raises ValueError."""
    path = folder / name
    try:
        if path.exists() and not path.is_file():
            raise ValueError("is no regular file")
        with open(path, "rb") as file:
            raw = file.read(LARGEST_TABLE + 1)
    except OSError as error:
        raise ValueError(f"cannot be read: {error.strerror or error}") from None
    if len(raw) > LARGEST_TABLE:
        raise ValueError("is larger than 1 MB")
    try:
        return raw.decode("utf-8-sig")
    except UnicodeDecodeError:
        raise ValueError("is not UTF-8 text") from None


def pairs_of(text: str) -> str:
    """The list of pairs that a CSV file with a header such as `t [s], F [N]` holds. Raises ValueError."""
    rows = [row for row in csv.reader(io.StringIO(text)) if any(cell.strip() for cell in row)]
    if not rows:
        raise ValueError("is empty; it begins with a line such as: t [s], F [N]")
    units = [_unit_of_column(cell) for cell in rows[0]]
    if len(units) != 2:
        raise ValueError(f"must have two columns, got {len(units)}")
    if len(rows) > MOST_PAIRS:
        raise ValueError(f"has more than {MOST_PAIRS} rows")
    pairs = []
    for i, row in enumerate(rows[1:], 2):
        if len(row) != 2:
            raise ValueError(f"row {i} has {len(row)} columns, must have 2")
        try:
            for cell in row:
                exact_number(cell.strip())
        except (QuantityError, ValueError):
            raise ValueError(f"row {i} must be two numbers, got {shown(','.join(row))}") from None
        cells = [f"{cell.strip()} {unit}".strip() for cell, unit in zip(row, units, strict=True)]
        pairs.append(f"[{', '.join(cells)}]")
    return f"[{', '.join(pairs)}]"


def _unit_of_column(header: str) -> str:
    """The unit behind a name, such as s in `t [s]`."""
    name, bracket, unit = header.strip().partition("[")
    if not name.strip() or not bracket or not unit.endswith("]"):
        raise ValueError(f"the first line must be like `t [s], F [N]`, got {shown(header)}")
    inner = unit[:-1].strip()
    try:
        quantity, _ = any_quantity(f"1 {inner}" if inner not in ("", "1", "-") else "1")
    except QuantityError as error:
        raise ValueError(f"column {shown(name.strip())}: {error}") from None
    return quantity.text.partition(" ")[2]


# The size of formulas of numbers alone, in doubles: for bounds, never for motions.


def size_of(node: Node, t: float = 0.0) -> float | None:
    """The value of a node that reads nothing but the time; None where it has none, or reads more."""
    try:
        return _size(node, t)
    except (ArithmeticError, ValueError, LookupError, TypeError):
        return None


def _size(node: Node, t: float) -> float:
    kind = node[0]
    if kind == "num":
        return float(node[1])
    if kind in ("pi", "t"):
        return math.pi if kind == "pi" else t
    below = [_size(child, t) for child in nodes.children(node)]
    if kind == "choose":
        return below[1] if below[0] >= 0 else below[2]
    if kind == "table":
        return _in_table(node, below[0])
    if kind == "pow":
        result: float = below[0] ** float(node[2])
        return result
    return _OPERATIONS[kind](*below)


_OPERATIONS: dict[str, Callable[..., float]] = {
    "add": lambda a, b: a + b,
    "sub": lambda a, b: a - b,
    "mul": lambda a, b: a * b,
    "div": lambda a, b: a / b,
    "mod": lambda a, b: a - b * math.floor(a / b),
    **{name: getattr(math, name) for name in ("sin", "cos", "exp", "log", "sinh", "cosh", "tanh")},
    **{name: getattr(math, name) for name in ("atan", "asin", "acos")},
}


def _in_table(node: Node, u: float) -> float:
    _, _, knots, pieces, _ = node
    place = min(max(u, float(knots[0])), float(knots[-1]))
    k = max(0, min(len(pieces) - 1, sum(1 for knot in knots if knot <= place) - 1))
    beyond = place - float(knots[k])
    return sum(float(c) * beyond**n for n, c in enumerate(pieces[k]))
