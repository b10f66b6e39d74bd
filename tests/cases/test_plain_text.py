"""User text is shown as text, whatever it holds."""

import unicodedata

import pytest
from hypothesis import given
from hypothesis import strategies as st

from vibsim.cases.problems import one_line, plain_text
from vibsim.cases.quantities import number


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
