"""What a notebook shows of a case."""

from html.parser import HTMLParser

import pytest

from vibsim import load_case
from vibsim.cases.quantities import number
from vibsim.cases.validation import derived_facts


class Tags(HTMLParser):
    """Open tags of a page, and its text."""

    def __init__(self):
        super().__init__()
        self.open, self.text = [], ""

    def handle_starttag(self, tag, attrs):
        if tag != "br":
            self.open.append(tag)

    def handle_endtag(self, tag):
        assert self.open.pop() == tag

    def handle_data(self, data):
        self.text += data


@pytest.mark.parametrize("name", ("II-B", "gallery/stack-of-blocks"))
def test_a_case_says_what_it_is(name):
    case, page = load_case(name), Tags()
    page.feed(case._repr_html_())
    assert page.open == []
    assert page.text.startswith(repr(case)[1:-1]) and case.title in page.text and case.to_yaml() in page.text
    for fact in derived_facts(case.scene()):
        assert fact.meaning in page.text and f"{number(fact.value, 6)} {fact.unit}".strip() in page.text


def test_what_a_user_wrote_is_no_mark_up():
    html = load_case("II-B", {"title": "k < 3 & <script>"})._repr_html_()
    assert "<script>" not in html and "k &lt; 3 &amp; &lt;script&gt;" in html
