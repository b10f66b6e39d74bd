"""Docstrings of the site: what a name means is no type, and lists end where they end."""

import pytest

pytest.importorskip("sphinx.ext.napoleon")

from sphinx.ext.napoleon import Config, NumpyDocstring

from from_code.docstrings import after_napoleon, before_napoleon


def as_rest(text, what="function"):
    lines = text.splitlines()
    before_napoleon(None, what, "", None, None, lines)
    lines = str(NumpyDocstring(lines, Config(napoleon_use_rtype=False), what=what)).splitlines()
    after_napoleon(None, what, "", None, None, lines)
    return "\n".join(lines)


def test_meanings_are_no_types():
    parameters = "key : of the case: its name,\n    long or short\na, b : numbers"
    text = as_rest(f"Follow it.\n\nParameters\n----------\n{parameters}\n")
    assert ":param key: of the case: its name,\n            long or short" in text
    assert ":param a: numbers" in text and ":type" not in text


@pytest.mark.parametrize("what", ["attribute", "property"])
def test_first_lines_of_properties_are_whole(what):
    text = "The events as a circle: the least of them."
    assert as_rest(text, what) == text


def test_lists_end_before_a_paragraph():
    text = as_rest("Draw.\n\nParameters\n----------\na : a number\n\nReturns a picture of |x|.\n")
    assert ":param a: a number\n" in text
    assert text.rstrip().endswith("\nReturns a picture of \\|x\\|.")


def test_examples_stay_as_they_are():
    assert ">>> a | b : c" in as_rest("Or.\n\n>>> a | b : c\n")
