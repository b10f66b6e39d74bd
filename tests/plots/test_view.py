import math

import pytest

from vibsim.plots.subject import PlotError, parse_span


@pytest.mark.parametrize(
    ("text", "span"),
    [("100:110", (100, 110)), (":20", (-math.inf, 20)), ("1.5:", (1.5, math.inf)), ("1e2:2e2", (100, 200))],
)
def test_spans(text, span):
    assert parse_span(text) == span


@pytest.mark.parametrize("text", ["100", "a:b", "nan:3", "1:2:3", ""])
def test_what_is_no_span(text):
    with pytest.raises(PlotError, match="write FIRST:LAST in seconds"):
        parse_span(text)


@pytest.mark.parametrize("text", ["3:3", "5:2"])
def test_empty_spans(text):
    with pytest.raises(PlotError, match="is empty"):
        parse_span(text)
