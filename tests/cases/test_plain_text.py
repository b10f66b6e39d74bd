"""User text is shown as text, whatever it holds."""

import unicodedata

import pytest
from hypothesis import given
from hypothesis import strategies as st

from vibsim.cases.plain_text import one_line, plain_text


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
