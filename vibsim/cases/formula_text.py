"""The text of a formula to a tree of its parts: tokens, grammar, places; nothing of it is ever run by Python.

sum      = product (("+" | "-") product)*
product  = signed (("*" | "/") signed)*
signed   = ("-" | "+")* power
power    = atom ("**" signed)?
atom     = number unit? | name | function "(" arguments ")" | "(" sum ")"
where    = "where(" sum ("<" | "<=" | ">" | ">=") sum "," sum "," sum ")"
table    = "table(" sum "," (text | "[" pairs "]") ("," text)? ")"
"""

import csv
import io
import re
from collections.abc import Callable, Iterator
from fractions import Fraction
from functools import lru_cache
from pathlib import Path
from typing import NamedTuple

from vibsim.cases.any_unit import PURE, AnyUnit, Dimension, any_quantity, read_unit
from vibsim.cases.problems import counted, did_you_mean, shown
from vibsim.cases.quantities import QuantityError, exact_number
from vibsim.physics import formulas as nodes

MOST_OPERATIONS = 2000  # of one formula: signs and functions
DEEPEST = 40  # brackets, functions, signs and powers inside one another
LONGEST_TEXT = 50_000  # characters, without those of tables
MOST_PAIRS = 10_000  # of a table

PLAIN_FUNCTIONS = tuple(nodes.FUNCTIONS)
ARGUMENTS = {
    **dict.fromkeys((*PLAIN_FUNCTIONS, "sqrt", "abs", "sign", "step"), (1, 1)),
    "min": (2, 20),
    "max": (2, 20),
    "mod": (2, 2),
    "where": (3, 3),
    "table": (2, 3),
}  # least and most number of arguments
FUNCTIONS = tuple(ARGUMENTS)
WITH_CORNERS = tuple(name for name in FUNCTIONS if name not in (*PLAIN_FUNCTIONS, "sqrt"))
COMPARISONS = ("<=", ">=", "<", ">")
ELSEWHERE = {
    **dict.fromkeys(COMPARISONS, "stands once, in where(a < b, then, else)"),
    "if": "is written where(a < b, then, else)",
    "else": "is written where(a < b, then, else)",
    "and": "is written where(a < b, where(c < d, then, else), else)",
    "or": "is written where(a < b, then, where(c < d, then, else))",
    "not": "is written where(a < b, else, then)",
}  # signs and words of other languages, and how a formula has them


class FormulaError(ValueError):
    """An error in a formula: its message, and from which character of the text to which."""

    def __init__(self, message: str, start: int, end: int):
        super().__init__(message)
        self.start, self.end = start, end

    def __reduce__(self) -> tuple[object, ...]:
        """For pickle, as between processes."""
        return type(self), (str(self), self.start, self.end)


class FormulaTerm(NamedTuple):
    """A part of a formula.

    Attributes
    ----------
    kind : "number", "name", "sum", "product", "negative", "power", "compare", "call", "text" or "pairs"
    start, end : where it stands in the text
    parts : what it is made of
    value : of a number (value, turns, dimension); of a sum and a product the signs; else its word
    """

    kind: str
    start: int
    end: int
    parts: tuple["FormulaTerm", ...] = ()
    value: object = None


class FormulaNumber(NamedTuple):
    """A number in a formula: value (2 pi)**turns, in SI units of its dimension."""

    value: Fraction
    turns: int
    dimension: Dimension
    bare: bool  # whether it has no unit


@lru_cache(maxsize=512)
def parsed(text: str) -> FormulaTerm:
    """The tree of a formula. Raises FormulaError."""
    return _Parser(text).formula()


@lru_cache(maxsize=512)
def names_in(text: str) -> tuple[str, ...]:
    """The names that a formula reads, each once, in order; of a text that is none, the words in it."""
    try:
        tree = parsed(text)
    except FormulaError:
        words = re.findall(r"(?<![\w.])[A-Za-z_]\w*", text, re.ASCII)
        return tuple(dict.fromkeys(word for word in words if word not in FUNCTIONS))
    return tuple(dict.fromkeys(str(term.value) for term in walk(tree) if term.kind == "name"))


def walk(term: FormulaTerm) -> Iterator[FormulaTerm]:
    """A part and all parts in it."""
    stack = [term]
    while stack:
        one = stack.pop()
        yield one
        stack += reversed(one.parts)


# Tokens.


class _Token(NamedTuple):
    kind: str  # number, name, sign, text or end
    text: str
    start: int
    end: int


_TOKEN = re.compile(
    r"""\s*(?:(?P<number>(?:\d+(?:\.\d*)?|\.\d+)(?:[eE][+-]?\d+)?)
          |(?P<name>[A-Za-z_][A-Za-z0-9_]*)
          |(?P<sign>\*\*|<=|>=|[-+*/(),<>\[\]])
          |(?P<text>"[^"\n]*"|'[^'\n]*'))""",
    re.VERBOSE | re.ASCII,
)
_BLANKS = re.compile(r"\s*")
_WRONG = {
    "^": "write a power with **, such as x**2",
    "\u2212": "write the minus sign as -",
    "=": "a formula has no =",
    ";": "a formula has no ;",
    ".": "a name has no parts; numbers begin with a digit",
    "\u00b7": "write a product with *",
    "\u00d7": "write a product with *",
    "\u00b2": "write a power with **, such as x**2",
    "\u00b3": "write a power with **, such as x**3",
    "\u03c0": "write pi",
    "|": "write abs(...)",
    "%": "write a remainder as mod(a, b)",
}


_BEFORE_COMMA = re.compile(r"[ ]*([A-Za-z][A-Za-z0-9^/ ]*)(?=[,\])])", re.ASCII)
_read_once = lru_cache(maxsize=256)(read_unit)


def _unit_at(text: str, at: int) -> tuple[AnyUnit | None, int]:
    """The unit behind a number; in long tables each of its few units is read once."""
    match = _BEFORE_COMMA.match(text, at)
    if match:
        unit, end = _read_once(match[1])
        if unit is not None and end == len(match[1]):
            return unit, match.end()
    return read_unit(text, at)


class _Parser:
    """Recursive descent, one token ahead. Numbers are read together with their units."""

    def __init__(self, text: str):
        self.text = text
        self.operations = self.depth = self.pairs = 0
        self.in_table = 0
        self.token = self._next(0)

    def formula(self) -> FormulaTerm:
        if not self.text.strip():
            raise FormulaError("is empty; a formula is written like k*d + c*v", 0, len(self.text))
        tree = self.sum()
        if self.token.kind != "end":
            self.unexpected(tree)
        return tree

    # Grammar.

    def sum(self) -> FormulaTerm:
        first = self.product()
        parts, signs = [first], ["+"]
        while self.token.text in ("+", "-") and self.token.kind == "sign":
            signs.append(self.token.text)
            self.step()
            parts.append(self.product())
        if len(parts) == 1:
            return first
        return FormulaTerm("sum", first.start, parts[-1].end, tuple(parts), tuple(signs))

    def product(self) -> FormulaTerm:
        first = self.signed()
        parts, signs = [first], ["*"]
        while self.token.text in ("*", "/") and self.token.kind == "sign":
            signs.append(self.token.text)
            self.step()
            parts.append(self.signed())
        if len(parts) == 1:
            return first
        return FormulaTerm("product", first.start, parts[-1].end, tuple(parts), tuple(signs))

    def signed(self) -> FormulaTerm:
        start, negative = self.token.start, False
        while self.token.kind == "sign" and self.token.text in ("-", "+"):
            negative ^= self.token.text == "-"
            self.step()
        inner = self.power()
        return FormulaTerm("negative", start, inner.end, (inner,)) if negative else inner

    def power(self) -> FormulaTerm:
        base = self.atom()
        if not (self.token.kind == "sign" and self.token.text == "**"):
            return base
        self.step()
        with self:
            exponent = self.signed()
        return FormulaTerm("power", base.start, exponent.end, (base, exponent))

    def atom(self) -> FormulaTerm:
        token = self.token
        if token.kind == "number":
            return self.number()
        if token.kind == "name":
            self.advance()
            return self.call(token) if self.token.text == "(" else self.name(token)
        if token.text == "(" and token.kind == "sign":
            self.advance()
            with self:
                inner = self.sum()
            end = self.expected(")", f"the bracket at character {token.start + 1} is not closed")
            return inner._replace(start=token.start, end=end)
        if token.text == "[":
            raise FormulaError("a list of pairs stands in table(...) only", token.start, token.end)
        if token.kind == "text":
            raise FormulaError("a text stands in table(...) only", token.start, token.end)
        return self.unexpected(None)

    def name(self, token: _Token) -> FormulaTerm:
        return FormulaTerm("name", token.start, token.end, (), token.text)

    def number(self) -> FormulaTerm:
        token = self.token
        end, unit = token.end, None
        try:
            value = exact_number(token.text)
            if not re.match(r"\d", self.text[end : end + 1]):
                unit, end = _unit_at(self.text, end)
        except QuantityError as error:
            raise FormulaError(str(error), token.start, token.end) from None
        self.token = self._next(end)
        if self.token.kind in ("name", "number") and self.token.text != "":
            self.no_sign_between(token)
        if unit is None:
            return FormulaTerm("number", token.start, end, (), FormulaNumber(value, 0, PURE, True))
        number = FormulaNumber(value * unit.factor, unit.turns, unit.dimension, False)
        return FormulaTerm("number", token.start, end, (), number)

    def no_sign_between(self, number: _Token) -> None:
        word = self.token
        if word.text in ELSEWHERE:
            self.unexpected(None)
        what = f"{shown(self.text[number.start : number.end])} and {shown(word.text)}"
        message = f"{shown(word.text)} is no unit; write a sign between {what}, such as *"
        raise FormulaError(message, word.start, word.end)

    def call(self, name: _Token) -> FormulaTerm:
        if name.text not in ARGUMENTS:
            hint = did_you_mean(name.text, FUNCTIONS)
            message = f"no function {shown(name.text)}{hint}; there are {', '.join(FUNCTIONS)}"
            raise FormulaError(message, name.start, name.end)
        self.step()
        with self:
            arguments = self.arguments(name)
        end = self.expected(")", f"{name.text}( at character {name.start + 1} is not closed")
        least, most = ARGUMENTS[name.text]
        if not least <= len(arguments) <= most:
            count = str(least) if least == most else f"{least} to {most}"
            message = f"{name.text} has {counted(count, 'argument')}, got {len(arguments)}"
            raise FormulaError(message, name.start, end)
        return FormulaTerm("call", name.start, end, tuple(arguments), name.text)

    def arguments(self, name: _Token) -> list[FormulaTerm]:
        arguments: list[FormulaTerm] = []
        while not (self.token.text == ")" and not arguments):
            first = not arguments
            if name.text == "where" and first:
                arguments.append(self.comparison())
            elif name.text == "table" and not first:
                arguments.append(self.table_argument(len(arguments)))
            else:
                arguments.append(self.sum())
            if self.token.text != "," or self.token.kind != "sign":
                break
            self.advance()
        return arguments

    def comparison(self) -> FormulaTerm:
        left = self.sum()
        sign = self.token
        if sign.text not in COMPARISONS:
            message = "where(...) begins with a comparison, such as where(t < 1 s, a, b)"
            raise FormulaError(message, left.start, left.end)
        self.step()
        right = self.sum()
        return FormulaTerm("compare", left.start, right.end, (left, right), sign.text)

    def table_argument(self, place: int) -> FormulaTerm:
        token = self.token
        if token.kind == "text":
            self.advance()
            return FormulaTerm("text", token.start, token.end, (), token.text[1:-1])
        if place == 1 and token.text == "[":
            return self.list_of_pairs()
        what = "a list of pairs or the name of a CSV file in quotes" if place == 1 else '"linear" or "cubic"'
        raise FormulaError(f"here table(...) has {what}", token.start, token.end)

    def list_of_pairs(self) -> FormulaTerm:
        start = self.token.start
        self.advance()
        self.in_table += 1
        rows: list[FormulaTerm] = []
        while self.token.text != "]":
            begin = self.token.start
            self.expected("[", "a table is a list of pairs, such as [[0 s, 0 N], [1 s, 3 N]]")
            x = self.sum()
            self.expected(",", "a pair has two numbers, such as [1 s, 3 N]")
            y = self.sum()
            end = self.expected("]", "a pair has two numbers, such as [1 s, 3 N]")
            rows.append(FormulaTerm("pair", begin, end, (x, y)))
            self.pairs += 1
            if self.pairs > MOST_PAIRS:
                raise FormulaError(f"more than {MOST_PAIRS} pairs in tables", begin, end)
            if self.token.text != ",":
                break
            self.advance()
        self.in_table -= 1
        end = self.expected("]", "the list of pairs is not closed")
        return FormulaTerm("pairs", start, end, tuple(rows))

    # Tokens and bounds.

    def __enter__(self) -> None:
        self.depth += 1
        if self.depth > DEEPEST:
            message = f"nested more than {DEEPEST} deep"
            raise FormulaError(message, self.token.start, self.token.end)

    def __exit__(self, *_: object) -> None:
        self.depth -= 1

    def step(self) -> None:
        """Past the sign of an operation, which is counted."""
        self.operations += not self.in_table
        if self.operations > MOST_OPERATIONS:
            message = f"more than {MOST_OPERATIONS} operations"
            raise FormulaError(message, self.token.start, self.token.end)
        self.advance()

    def advance(self) -> None:
        self.token = self._next(self.token.end)

    def expected(self, sign: str, message: str) -> int:
        token = self.token
        if token.text != sign or token.kind != "sign":
            if token.text in ELSEWHERE:
                self.unexpected(None)
            raise FormulaError(f"{message}; {self.here()}", token.start, token.end)
        self.advance()
        return token.end

    def here(self) -> str:
        return "the formula ends" if self.token.kind == "end" else f"got {shown(self.token.text)}"

    def unexpected(self, before: FormulaTerm | None) -> FormulaTerm:
        token = self.token
        if token.kind == "end":
            raise FormulaError("ends where a number, a name or a bracket is due", token.start, token.end)
        if token.text in ELSEWHERE:
            message = f"{token.text} {ELSEWHERE[token.text]}"
        elif before is None:
            message = f"a number, a name or a bracket is due, got {shown(token.text)}"
        elif token.text == ")":
            message = "a bracket is closed that was not opened"
        elif token.kind in ("name", "number") or token.text == "(":
            message = f"a sign such as * is due before {shown(token.text)}"
        else:
            message = f"{shown(token.text)} has no place here"
        raise FormulaError(message, token.start, token.end)

    def _next(self, at: int) -> _Token:
        match = _TOKEN.match(self.text, at)
        if match is not None:
            kind = str(match.lastgroup)
            start, end = match.span(kind)
            if start > LONGEST_TEXT and not self.in_table and self.pairs == 0:
                raise FormulaError(f"longer than {LONGEST_TEXT} characters", start, end)
            return _Token(kind, match[kind], start, end)
        blanks = _BLANKS.match(self.text, at)
        start = blanks.end() if blanks else at
        if start == len(self.text):
            return _Token("end", "", start, start)
        character = self.text[start]
        hint = f"; {_WRONG[character]}" if character in _WRONG else ""
        if character in "'\"":
            hint = "; a quote is not closed"
        raise FormulaError(f"{shown(character)} has no place in a formula{hint}", start, start + 1)


# Tables in CSV files: they become lists of pairs in the text of the formula, so that a case holds all of it.


LARGEST_TABLE = 1_000_000  # bytes of a CSV file


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
    for sign, word in ((";", "semicolons"), ("\t", "tabs")):
        if any(sign in cell for cell in rows[0]):
            raise ValueError(f"columns are separated by commas, and decimals have a point; got {word}")
    if len(rows[0]) != 2:
        raise ValueError(f"must have two columns, got {len(rows[0])}")
    units = [_unit_of_column(cell) for cell in rows[0]]
    if len(rows) > MOST_PAIRS:
        raise ValueError(f"has more than {MOST_PAIRS} rows")
    pairs = []
    for i, row in enumerate(rows[1:], 2):
        if len(row) != 2:
            raise ValueError(f"row {i} has {counted(len(row), 'column')}, must have 2")
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
