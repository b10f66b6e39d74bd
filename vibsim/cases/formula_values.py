"""A formula with its names put in: the nodes that the engine reads, and the unit that it comes to.

Numbers stay exact fractions in SI units; a frequency of f Hz is 2 f pi. Units are worked out part by part:
the terms of a sum have one unit, arguments of sin, exp and the like are pure numbers, and so are exponents;
one above a unit must be known. A literal 0 fits any unit.
"""

from collections.abc import Mapping
from fractions import Fraction
from functools import lru_cache
from typing import NamedTuple

from vibsim.cases.any_unit import LARGEST_POWER, PURE, Dimension, called, dimension_of, product, symbol
from vibsim.cases.formula_text import (
    FUNCTIONS,
    PLAIN_FUNCTIONS,
    FormulaError,
    FormulaNumber,
    FormulaTerm,
    names_in,
    parsed,
)
from vibsim.cases.problems import did_you_mean, shown
from vibsim.cases.quantities import Quantity, fits_double
from vibsim.physics import formulas as nodes
from vibsim.physics.formulas import ONE, PI, ZERO, Node

MOST_NODES = 20_000  # of a formula written out, abs(a) as a choice between a and -a
DEEPEST = 200
MOST_BITS = 20_000  # of an exact number
KEPT = 256  # formulas with their numbers
SHARES = 8  # terms of a sum, or factors of a product, that are joined one by one; more are joined in halves


class Meaning(NamedTuple):
    """Meaning of a name in a formula: a node, and its dimension (None: it fits any, or was reported
    elsewhere).
    """

    node: Node
    dimension: Dimension | None


class WorkedOut(NamedTuple):
    """A part of a formula: its node; its dimension, None for a literal 0; and how large its tree is."""

    node: Node
    dimension: Dimension | None
    size: int = 1
    depth: int = 1


class WorkedTable(NamedTuple):
    """A table in a formula: its knots and the polynomials between them; of both columns the dimension, and
    whether it has a factor pi.
    """

    knots: tuple[Fraction, ...]
    pieces: tuple[tuple[Fraction, ...], ...]
    units: tuple[Dimension | None, ...]
    turns: tuple[int, ...]


class UnitError(FormulaError):
    """A formula whose units do not fit."""


def meaning_of_number(quantity: Quantity) -> Meaning:
    """Meaning in a formula of a number of the case."""
    return Meaning(number_node(quantity.value, int(quantity.per_turn)), dimension_of(quantity))


def number_node(value: Fraction, turns: int) -> Node:
    """value (2 pi)**turns."""
    node = nodes.num(value * Fraction(2) ** turns)
    for _ in range(abs(turns)):
        node = nodes.mul(node, PI) if turns > 0 else nodes.div(node, PI)
    return node


def formula_node(text: str, names: Mapping[str, Meaning], wanted: Dimension | None, place: str = "") -> Node:
    """The node of a formula.

    Parameters
    ----------
    names : what each name in it stands for
    wanted : what it must come to; None: anything
    place : what it is, in messages: "a force"

    Raises FormulaError.
    """
    tree = parsed(text)
    read = tuple((name, names[name]) for name in names_in(text) if name in names)
    try:
        value = _worked_out(text, read, wanted)
    except FormulaError:
        value = _Evaluation(text, names).of(tree, wanted)  # whose message tells of all names
    if wanted is not None and value.dimension is not None and value.dimension != wanted:
        what = f", {place}" if place else ""
        message = f"comes to {called(value.dimension)}, must be {called(wanted)}{what}"
        raise UnitError(message, tree.start, tree.end)
    return value.node


@lru_cache(maxsize=KEPT)
def _worked_out(text: str, read: tuple[tuple[str, Meaning], ...], wanted: Dimension | None) -> WorkedOut:
    """The value of a formula by the names that it reads: worked out once for a case that is checked and then
    run, and for all points of a sweep over other numbers.
    """
    return _Evaluation(text, dict(read)).of(parsed(text), wanted)


class _Evaluation:
    """Works out the parts of one formula."""

    def __init__(self, text: str, names: Mapping[str, Meaning]):
        self.text, self.names = text, names
        self.units_at: set[int] = set()  # where a name below 1/ may be a unit

    def of(self, term: FormulaTerm, wanted: Dimension | None = None) -> WorkedOut:
        """The value of a part; `wanted`: the dimension that it should have, where that is known."""
        value: WorkedOut = getattr(self, f"_{term.kind}")(term, wanted)
        if value.size > MOST_NODES or value.depth > DEEPEST:
            raise self.error("is too large when it is written out", term)
        number = nodes.value_of(value.node)
        if number is not None and (
            max(number.numerator.bit_length(), number.denominator.bit_length()) > MOST_BITS
            or not fits_double(number)
        ):
            raise self.error("does not fit double precision (2.3e-308 to 2.2e307)", term)
        return value

    def source(self, term: FormulaTerm) -> str:
        return self.text[term.start : term.end]

    def said(self, term: FormulaTerm) -> str:
        return shown(self.source(term), 40)

    def error(self, message: str, term: FormulaTerm, kind: type[FormulaError] = FormulaError) -> FormulaError:
        return kind(f"{self.said(term)} {message}", term.start, term.end)

    # Numbers and names.

    def _number(self, term: FormulaTerm, wanted: Dimension | None) -> WorkedOut:
        number = term.value
        assert isinstance(number, FormulaNumber)
        any_unit = number.bare and number.value == 0
        return WorkedOut(number_node(number.value, number.turns), None if any_unit else number.dimension)

    def _name(self, term: FormulaTerm, wanted: Dimension | None) -> WorkedOut:
        word = str(term.value)
        meaning = self.names.get(word)
        if meaning is not None:
            return WorkedOut(meaning.node, meaning.dimension)
        unit = symbol(word) if term.start in self.units_at else None
        if unit is not None:
            return WorkedOut(number_node(unit.factor, unit.turns), unit.dimension)
        if word in FUNCTIONS:
            raise FormulaError(f"the function {word} needs its argument: {word}(...)", term.start, term.end)
        hint = did_you_mean(word, self.names)
        if not hint and symbol(word):
            hint = "; a unit stands behind a number only"
        listed = ", ".join(self.names)
        message = f"unknown name {shown(word, 40)}{hint}; known here: {shown(listed, 300)}"
        raise FormulaError(message, term.start, term.end)

    def _negative(self, term: FormulaTerm, wanted: Dimension | None) -> WorkedOut:
        inner = self.of(term.parts[0], wanted)
        return WorkedOut(nodes.neg(inner.node), inner.dimension, inner.size + 2, inner.depth + 1)

    # Sums and products.

    def _sum(self, term: FormulaTerm, wanted: Dimension | None) -> WorkedOut:
        values = [self.of(part, wanted) for part in term.parts]
        unit = self.common(term, term.parts, values, wanted, " + ")
        signs = term.value
        assert isinstance(signs, tuple)
        terms = [(sign == "-", value) for sign, value in zip(signs, values, strict=True)]
        return self.joined_sum(terms)._replace(dimension=unit)

    def joined_sum(self, terms: list[tuple[bool, WorkedOut]]) -> WorkedOut:
        """The sum of terms, of which some are taken away; many are joined in halves."""
        if len(terms) > SHARES:
            middle = len(terms) // 2
            first, second = self.joined_sum(terms[:middle]), self.joined_sum(terms[middle:])
            return _joined(nodes.add(first.node, second.node), first, second)
        negative, total = terms[0]
        if negative:
            total = WorkedOut(nodes.neg(total.node), None, total.size + 2, total.depth + 1)
        for negative, value in terms[1:]:
            join = nodes.sub if negative else nodes.add
            total = _joined(join(total.node, value.node), total, value)
        return total

    def common(
        self,
        whole: FormulaTerm,
        parts: tuple[FormulaTerm, ...],
        values: list[WorkedOut],
        wanted: Dimension | None,
        sign: str,
    ) -> Dimension | None:
        """The one dimension of several parts. Raises UnitError, with the part that has another one."""
        units = [value.dimension for value in values if value.dimension is not None]
        unit = wanted if wanted in units else units[0] if units else None
        for part, value in zip(parts, values, strict=True):
            if value.dimension is not None and value.dimension != unit:
                assert unit is not None
                of_all = sign.join(called(one) for one in units)
                message = f"{self.said(part)} is {called(value.dimension)}, must be {called(unit)}"
                raise UnitError(f"{of_all}: {message}", part.start, part.end)
        return unit

    def _product(self, term: FormulaTerm, wanted: Dimension | None) -> WorkedOut:
        signs = term.value
        assert isinstance(signs, tuple)
        self.allow_units(term, signs)
        values = [self.of(part) for part in term.parts]
        unit: Dimension = PURE
        for sign, value in zip(signs, values, strict=True):
            unit = product(unit, value.dimension or PURE, 1 if sign == "*" else -1)
        total = values[0]
        for sign, part, value in zip(signs[1:], term.parts[1:], values[1:], strict=True):
            total = self.times(total, value) if sign == "*" else self.over(total, value, part)
        zero = total.node == ZERO and all(value.dimension is None for value in values)
        return total._replace(dimension=None if zero else unit)

    def allow_units(self, term: FormulaTerm, signs: tuple[str, ...]) -> None:
        """1/K and 1/m are units where no number has the name."""
        first = term.parts[0]
        is_one = first.kind == "number" and self.source(first) == "1"
        if not (is_one and signs[1] == "/"):
            return
        below = term.parts[1]
        self.units_at.add(below.parts[0].start if below.kind == "power" else below.start)

    @staticmethod
    def times(a: WorkedOut, b: WorkedOut) -> WorkedOut:
        return _joined(nodes.mul(a.node, b.node), a, b)

    def over(self, a: WorkedOut, b: WorkedOut, below: FormulaTerm) -> WorkedOut:
        try:
            return _joined(nodes.div(a.node, b.node), a, b)
        except ZeroDivisionError:
            message = f"division by zero: {self.said(below)} is 0"
            raise FormulaError(message, below.start, below.end) from None

    def _power(self, term: FormulaTerm, wanted: Dimension | None) -> WorkedOut:
        base, exponent = (self.of(part) for part in term.parts)
        below, above = term.parts
        self.pure(exponent, above, f"as the exponent in {self.said(term)}")
        number = nodes.value_of(exponent.node)
        unit = base.dimension or PURE
        if unit != PURE and number is None:
            what = f"so its exponent must be a number, not {self.said(above)}"
            message = f"{self.said(below)} is {called(unit)}, {what}"
            raise UnitError(message, above.start, above.end)
        if number is not None and unit != PURE:
            unit = self.powered(unit, number, term)
        try:
            node = _power_node(base.node, exponent.node)
        except ZeroDivisionError:
            raise FormulaError(f"division by zero in {self.said(term)}", term.start, term.end) from None
        except ValueError as error:
            raise FormulaError(f"{error}, got {self.said(term)}", term.start, term.end) from None
        whole = number is not None and number.denominator == 1
        size = base.size * max(1, abs(int(number or 0))) * 2 if whole else base.size + exponent.size + 3
        return WorkedOut(node, unit, size, max(base.depth + 14, exponent.depth) + 2)

    def powered(self, unit: Dimension, number: Fraction, term: FormulaTerm) -> Dimension:
        result = product(PURE, unit, number)
        if any(abs(one) > 10 * LARGEST_POWER or one.denominator > 1000 for one in result):
            raise UnitError(f"{self.said(term)} has no sensible unit", term.start, term.end)
        return result

    def pure(self, value: WorkedOut, part: FormulaTerm, where: str) -> None:
        if value.dimension not in (None, PURE):
            message = f"{self.said(part)} is {called(value.dimension or PURE)}, must be a pure number {where}"
            raise UnitError(message, part.start, part.end)

    # Functions.

    def _compare(self, term: FormulaTerm, wanted: Dimension | None) -> WorkedOut:
        """Left minus right, or the other way round: >= 0 where `where` takes its first branch or second."""
        left, right = (self.of(part) for part in term.parts)
        self.common(term, term.parts, [left, right], None, f" {term.value} ")
        if term.value in (">=", "<"):
            return _joined(nodes.sub(left.node, right.node), left, right)
        return _joined(nodes.sub(right.node, left.node), left, right)

    def _call(self, term: FormulaTerm, wanted: Dimension | None) -> WorkedOut:
        name = str(term.value)
        if name in PLAIN_FUNCTIONS:
            return self.plain(name, term)
        value: WorkedOut = getattr(self, f"_call_{name}")(term, wanted)
        return value

    def plain(self, name: str, term: FormulaTerm) -> WorkedOut:
        part = term.parts[0]
        value = self.of(part)
        self.pure(value, part, f"in {name}(...)")
        number = nodes.value_of(value.node)
        function = nodes.FUNCTIONS[name]
        if number is not None and not function.covers(number):
            raise FormulaError(f"{self.said(term)}: {_outside(name)}", term.start, term.end)
        if number is not None and number == function.known[0]:
            return WorkedOut(function.known[1], PURE)
        size = 2 * value.size + 1 if name == "tan" else value.size + 1
        return WorkedOut(nodes.call(name, value.node), PURE, size, value.depth + 2)

    def _call_sqrt(self, term: FormulaTerm, wanted: Dimension | None) -> WorkedOut:
        value = self.of(term.parts[0])
        number = nodes.value_of(value.node)
        if number is not None and number < 0:
            raise FormulaError(f"{self.said(term)}: the root of a negative number", term.start, term.end)
        unit = None if value.dimension is None else product(PURE, value.dimension, Fraction(1, 2))
        node = value.node if number in (0, 1) else nodes.call("sqrt", value.node)
        return WorkedOut(node, unit, value.size + 1, value.depth + 1)

    def _call_abs(self, term: FormulaTerm, wanted: Dimension | None) -> WorkedOut:
        value = self.of(term.parts[0], wanted)
        node = nodes.absolute(value.node, self.source(term))
        return WorkedOut(node, value.dimension, 3 * value.size + 2, value.depth + 2)

    def _call_sign(self, term: FormulaTerm, wanted: Dimension | None) -> WorkedOut:
        value = self.of(term.parts[0])
        if value.node == ZERO:
            return WorkedOut(ZERO, PURE)
        node = nodes.choose(value.node, ONE, nodes.num(-1), self.source(term))
        return WorkedOut(node, PURE, value.size + 3, value.depth + 1)

    def _call_step(self, term: FormulaTerm, wanted: Dimension | None) -> WorkedOut:
        value = self.of(term.parts[0])
        node = nodes.choose(value.node, ONE, ZERO, self.source(term))
        return WorkedOut(node, PURE, value.size + 3, value.depth + 1)

    def _call_min(self, term: FormulaTerm, wanted: Dimension | None) -> WorkedOut:
        return self.extreme(term, wanted)

    def _call_max(self, term: FormulaTerm, wanted: Dimension | None) -> WorkedOut:
        return self.extreme(term, wanted)

    def extreme(self, term: FormulaTerm, wanted: Dimension | None) -> WorkedOut:
        join = nodes.largest if term.value == "max" else nodes.smallest
        values = [self.of(part, wanted) for part in term.parts]
        unit = self.common(term, term.parts, values, wanted, ", ")
        total = values[0]
        for value in values[1:]:
            size = 2 * (total.size + value.size) + 2
            node = join(total.node, value.node, self.source(term))
            total = WorkedOut(node, None, size, max(total.depth, value.depth) + 2)
        return total._replace(dimension=unit)

    def _call_where(self, term: FormulaTerm, wanted: Dimension | None) -> WorkedOut:
        condition, *branches = term.parts
        guard = self.of(condition)
        first, second = values = [self.of(part, wanted) for part in branches]
        unit = self.common(term, tuple(branches), values, wanted, ", ")
        if condition.value in ("<", ">"):
            first, second = second, first
        node = nodes.choose(guard.node, first.node, second.node, self.source(term))
        size = guard.size + first.size + second.size + 1
        return WorkedOut(node, unit, size, max(guard.depth, first.depth, second.depth) + 1)

    def _call_mod(self, term: FormulaTerm, wanted: Dimension | None) -> WorkedOut:
        from vibsim.physics.formula_values import size_of

        values = [self.of(part, wanted) for part in term.parts]
        unit = self.common(term, term.parts, values, wanted, ", ")
        a, b = values
        below = term.parts[1]
        if nodes.reads([b.node], ("t", "x", "v", "phi", "w")):
            message = f"{self.said(below)} must be a number that does not change, in mod(a, b)"
            raise FormulaError(message, below.start, below.end)
        size = size_of(b.node)
        if size is None or size <= 0:
            raise FormulaError(f"{self.said(below)} must be > 0, in mod(a, b)", below.start, below.end)
        x, y = nodes.value_of(a.node), nodes.value_of(b.node)
        if x is None or y is None:
            node: Node = ("mod", a.node, b.node, self.source(term))
        else:
            node = nodes.num(x - y * (x // y))
        return WorkedOut(node, unit, a.size + b.size + 1, max(a.depth, b.depth) + 1)

    def _call_table(self, term: FormulaTerm, wanted: Dimension | None) -> WorkedOut:
        argument, pairs, *kind = term.parts
        if pairs.kind == "text":
            message = f"the table {self.said(pairs)} has not been read; a file is found from a case file only"
            raise FormulaError(message, pairs.start, pairs.end)
        if kind and kind[0].value not in ("linear", "cubic"):
            message = f'{self.said(kind[0])} is no way between pairs; there are "linear" and "cubic"'
            raise FormulaError(message, kind[0].start, kind[0].end)
        value = self.of(argument)
        table = self.table(pairs, str(kind[0].value) if kind else "linear")
        of_knots = value._replace(dimension=table.units[0])
        self.common(term, (argument, pairs), [value, of_knots], None, ", ")
        u = nodes.div(value.node, PI) if table.turns[0] else value.node
        node: Node = ("table", u, table.knots, table.pieces, shown(self.source(term), 60))
        node = nodes.mul(node, PI) if table.turns[1] else node
        return WorkedOut(node, table.units[1] or PURE, value.size + 3, value.depth + 3)

    def table(self, pairs: FormulaTerm, kind: str) -> "WorkedTable":
        """The table of pairs; of those that name nothing, each is worked out once."""
        try:
            return _plain_table(self.source(pairs), kind)
        except FormulaError:
            return self.worked_table(pairs, kind)

    def worked_table(self, pairs: FormulaTerm, kind: str) -> "WorkedTable":
        from vibsim.physics.formula_values import pieces_of

        columns, units, turns = [], [], []
        for column in (0, 1):
            parts = tuple(pair.parts[column] for pair in pairs.parts)
            numbers = [self.of(part) for part in parts]
            units.append(self.common(pairs, parts, numbers, None, ", ") if parts else None)
            exact = [self.exact(number, part) for number, part in zip(numbers, parts, strict=True)]
            turns.append(self.one_turn(exact, parts))
            columns.append([one for one, _ in exact])
        try:
            pieces = pieces_of(columns[0], columns[1], kind)
        except ValueError as error:
            raise FormulaError(str(error), pairs.start, pairs.end) from None
        return WorkedTable(tuple(columns[0]), pieces, tuple(units), tuple(turns))

    def exact(self, value: WorkedOut, part: FormulaTerm) -> tuple[Fraction, int]:
        """A number of a table, without its factor pi, and whether it has that."""
        number = nodes.value_of(value.node)
        if number is not None:
            return number, 0
        if value.node == PI:
            return Fraction(1), 1
        if value.node[0] == "mul" and value.node[1][0] == "num" and value.node[2] == PI:
            return value.node[1][1], 1
        message = f"{self.said(part)} must be a number, in a table"
        raise FormulaError(message, part.start, part.end)

    def one_turn(self, numbers: list[tuple[Fraction, int]], parts: tuple[FormulaTerm, ...]) -> int:
        """Whether all numbers of a column but 0 have a factor pi."""
        turns = {turn for number, turn in numbers if number}
        if len(turns) > 1:
            message = "a column of a table has one kind of unit: Hz, rpm and deg, or rad/s and rad"
            raise FormulaError(message, parts[0].start, parts[-1].end)
        return next(iter(turns), 0)


@lru_cache(maxsize=16)
def _plain_table(pairs: str, kind: str) -> WorkedTable:
    """The table of pairs that name nothing. Raises FormulaError, of places in the pairs alone."""
    text = f"table(0, {pairs})"
    return _Evaluation(text, {}).worked_table(parsed(text).parts[1], kind)


def _joined(node: Node, a: WorkedOut, b: WorkedOut) -> WorkedOut:
    return WorkedOut(node, None, a.size + b.size + 1, max(a.depth, b.depth) + 1)


def _power_node(base: Node, exponent: Node) -> Node:
    """base**exponent. Raises ZeroDivisionError for 0**p with p < 0, ValueError for powers not taken."""
    p, b = nodes.value_of(exponent), nodes.value_of(base)
    if p and b == 0:
        if p < 0:
            raise ZeroDivisionError
        return ZERO
    if p is not None and b is not None and b < 0 and p.denominator != 1:
        raise ValueError("a negative number to a power that is no whole number")
    if p is not None and abs(p) > nodes.MOST_EXACT:
        raise ValueError(f"powers beyond {nodes.MOST_EXACT} are not supported")
    return nodes.power(base, exponent)


def _outside(name: str) -> str:
    """Message for a number outside the domain of a function."""
    if name == "log":
        return "the logarithm of a number that is not above 0"
    of = nodes.FUNCTIONS[name]
    return f"{name} of a number beyond {of.least} to {of.most}"
