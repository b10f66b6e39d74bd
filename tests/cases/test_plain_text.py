"""User text is shown as text, whatever it holds."""

import ast
import random
import re
import unicodedata
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

import vibsim
from vibsim.cases import yaml_nodes
from vibsim.cases.problems import counted, one_line, plain_text
from vibsim.cases.quantities import number
from vibsim.cases.yaml_nodes import BOTH_READ, FAST_PARSER, read_yaml


@pytest.mark.parametrize(
    ("text", "plain"),
    [
        ("Motor, 5.5 Hz", "Motor, 5.5 Hz"),
        ("Schwingförderer 振動 5,5\u00a0Hz", "Schwingförderer 振動 5,5\u00a0Hz"),
        ("x\x1b[2J\x1b]0;PWN\x07", "x\\x1b[2J\\x1b]0;PWN\\x07"),
        ("\x9b31m\x7f", "\\x9b31m\\x7f"),
        ("a\u202eb\u2066c\u200bd", "a\\u202eb\\u2066c\\u200bd"),
        ("line\nbreak\ttab", "line\\nbreak\\ttab"),
        ("file\udcff", "file\\udcff"),
    ],
)
def test_what_would_be_obeyed_is_written_out(text, plain):
    assert plain_text(text) == plain


def test_some_may_be_kept_and_white_space_is_one_blank():
    assert plain_text("a\nb\x07", allowed="\n") == "a\nb\\x07"
    assert one_line(" a\n\t b\u2028c ") == "a b c"


@given(st.text(st.characters(codec=None)))
def test_nothing_is_left_to_obey(text):
    plain = plain_text(text)
    assert {unicodedata.category(ch)[0] for ch in plain} <= set("LMNPSZ")
    assert not {"\u2028", "\u2029"} & set(plain)
    plain.encode("utf-8")


@pytest.mark.parametrize(
    ("x", "digits", "text"),
    [(1e-6, 2, "1e-6"), (-8.5165e-5, 4, "-8.517e-5"), (0.0025, 2, "0.0025"), (2.34e8, 2, "2.3e8"),
     (1e-12, 1, "1e-12"), (1e100, 3, "1e100"), (0.0, 3, "0"), (float("inf"), 2, "inf"), (12.5, 6, "12.5")],
)  # fmt: skip
def test_exponents_are_as_short_as_can_be(x, digits, text):
    assert number(x, digits) == text
    assert float(text) == float(f"{x:.{digits}g}")


# Case files are read alike whether PyYAML has libyaml or not.


CASES = Path(__file__).parents[2] / "cases"
TEXTS = [path.read_text(encoding="utf-8") for path in sorted(CASES.rglob("*.yaml"))]
PUT = "abz019 :-.,#'\"[]{}?|>!&*%@`\n\t~=<>_/+\\()$;^\r\x00"

needs_libyaml = pytest.mark.skipif(FAST_PARSER is None, reason="PyYAML was built without libyaml")


def mutant(draw: random.Random) -> str:
    """A few lines of a shipped case, some characters put in, cut out or moved."""
    lines = draw.choice(TEXTS).splitlines(keepends=True)
    begin = draw.randrange(len(lines))
    text = "".join(lines[begin : begin + draw.randrange(1, 14)])
    for _ in range(draw.randrange(6)):
        at, other = draw.randrange(len(text) + 1), draw.randrange(len(text) + 1)
        cut = draw.randrange(4)
        changed = (
            text[:at] + draw.choice(PUT) * draw.choice((1, 1, 2, 3)) + text[at:],
            text[:at] + text[at + cut :],
            text[:at] + text[other : other + 4 * cut] + text[at:],
        )
        text = draw.choice(changed)
    return text


@needs_libyaml
def test_shipped_cases_are_read_by_libyaml(monkeypatch):
    def read(*_):
        raise AssertionError("read by Python")

    monkeypatch.setattr(yaml_nodes.yaml, "SafeLoader", read)
    plain = [text for text in TEXTS if "*" not in text]  # as in formulas, where Python reads
    assert len(plain) > 30
    for text in plain:
        assert BOTH_READ.fullmatch(text) and not read_yaml(text, "case")[1]


@needs_libyaml
@pytest.mark.parametrize("seed", range(4))
def test_what_libyaml_reads_python_reads_alike(seed, monkeypatch):
    draw, texts = random.Random(seed), []
    while len(texts) < 300:
        text = mutant(draw)
        if BOTH_READ.fullmatch(text):
            texts.append(text)
    with_libyaml = [read_yaml(text, "case") for text in texts]
    monkeypatch.setattr(yaml_nodes, "FAST_PARSER", None)
    assert with_libyaml == [read_yaml(text, "case") for text in texts]
    assert sum(not problems for _, problems in with_libyaml) > 100


# A number before its word, in all texts.


@pytest.mark.parametrize(
    ("number", "word", "text"),
    [
        (0, "impact", "0 impacts"),
        (1, "impact", "1 impact"),
        (2, "impact", "2 impacts"),
        ("1", "point", "1 point"),
        ("1 or 2", "member", "1 or 2 members"),
        (1, "rank loss", "1 rank loss"),
        (2, "rank loss", "2 rank losses"),
        (2, "body", "2 bodies"),
        (2, "day", "2 days"),
        (2, "box", "2 boxes"),
        (2, "branch", "2 branches"),
    ],
)
def test_a_count_has_the_form_of_its_word(number, word, text):
    assert counted(number, word) == text


COUNTED = (
    "blocks columns cycles events frames impacts periods points reversals rows runs samples starts values"
)
MANY = re.compile(rf"(?<!of )%(?: [a-z]+)? (?:{'|'.join(COUNTED.split())})(?![a-z]| are too)")


def counts_of(source):
    """Lines of the texts in which the length of something stands before a word that is always plural."""
    for node in ast.walk(ast.parse(source)):
        if isinstance(node, ast.JoinedStr) and MANY.search("".join(map(shape_of, node.values))):
            yield node.lineno


def shape_of(part):
    """% for what has a length, # for another value, and the text itself."""
    if isinstance(part, ast.Constant):
        return part.value
    call = part.value
    return "%" if isinstance(call, ast.Call) and ast.unparse(call.func) in ("len", "sum") else "#"


def test_no_text_has_a_plural_where_there_may_be_one():
    """In the reports on the paper the counts are known."""
    assert list(counts_of('f"{len(x)} points"')) == list(counts_of('f"{sum(x)} late impacts"')) == [1]
    assert not [*counts_of('f"1 of {len(x)} points"'), *counts_of('f"{len(x)} pointsmen"')]
    found = {
        f"{path.name}:{line}"
        for path in Path(vibsim.__file__).parent.rglob("*.py")
        if path.parent.name != "reports"
        for line in counts_of(path.read_text("utf-8"))
    }
    assert not found
