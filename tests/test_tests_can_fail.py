"""No assertion under tests/ is of a form that cannot fail."""

import ast
from pathlib import Path

import pytest

FILES = sorted(Path(__file__).parent.rglob("*.py"))


def always_true(test):
    """Why an asserted expression cannot fail, or asserts less than it seems to; None where it can."""
    if isinstance(test, ast.Tuple):
        return "a tuple is true"
    if isinstance(test, ast.IfExp):
        return "`assert a if c else b` asserts b alone where c is false; give the expected value a name"
    if isinstance(test, ast.BoolOp) and isinstance(test.op, ast.Or) and any(map(is_constant, test.values)):
        return "`or` with a constant"
    if isinstance(test, ast.Constant) and test.value:
        return "a constant"
    return "both sides are the same expression" if compares_with_itself(test) else None


def is_constant(node):
    return isinstance(node, ast.Constant)


def compares_with_itself(test):
    """True for `a == a` and `a is a`."""
    if not isinstance(test, ast.Compare) or not isinstance(test.ops[0], ast.Eq | ast.Is):
        return False
    return ast.dump(test.left) == ast.dump(test.comparators[0])


def faults(source):
    """Line and reason of every such assertion in a source text."""
    nodes = (node for node in ast.walk(ast.parse(source)) if isinstance(node, ast.Assert))
    return [(node.lineno, reason) for node in nodes if (reason := always_true(node.test))]


def test_every_assertion_can_fail():
    found = {path: faults(path.read_text(encoding="utf-8")) for path in FILES}
    assert len(FILES) > 100 and {path: lines for path, lines in found.items() if lines} == {}


@pytest.mark.parametrize(
    "line",
    ["assert (a, b)", "assert a if c else b", "assert a == 1 or 2", "assert True", "assert a == a",
     "assert a is a"],
)  # fmt: skip
def test_what_cannot_fail_is_found(line):
    assert [number for number, _ in faults(line)] == [1]


@pytest.mark.parametrize(
    "line", ["assert a", "assert a == (1, 2)", "assert a or b", "assert a == (b if c else d)"]
)
def test_what_can_fail_is_let_through(line):
    assert faults(line) == []
