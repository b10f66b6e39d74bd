"""What the report, docs/paper.md and case files put into quotation marks is the paper's, word for word."""

import re
from hashlib import sha256
from html.parser import HTMLParser
from pathlib import Path

import pytest

from tests.evidence.reports.made import numbers
from tests.evidence.reports.test_pages import audit_pictures
from vibsim.evidence.reports.claims import QUOTES
from vibsim.evidence.reports.pages import render_html, render_text
from vibsim.evidence.reports.paper_document import paper_claims, paper_document

ROOT = Path(__file__).resolve().parents[3]
PLACES = {"Abstract", "Eq. (2.11)", "Section 1", "Section 2.1", "Section 2.2", "Section 3", "Section 4"}
LONGEST = 200  # characters: short quotes only
TEXTS = {quote.text for quote in QUOTES.values()}
MARKED = re.compile(r"“([^”]*)”")

# of all texts and places, as they were read in the paper; change it only after reading them there again
READ_IN_THE_PAPER = "0bc87fcb27023d27"


class Quoted(HTMLParser):
    """The contents of all <q>, and the text outside of them."""

    def __init__(self):
        super().__init__()
        self.inside, self.quotes, self.rest = False, [], ""

    def handle_starttag(self, tag, attrs):
        if tag == "q":
            self.inside = True
            self.quotes.append("")

    def handle_endtag(self, tag):
        self.inside = self.inside and tag != "q"

    def handle_data(self, data):
        if self.inside:
            self.quotes[-1] += data
        else:
            self.rest += data


@pytest.fixture
def document(tmp_path):
    return paper_document(numbers(), [], audit_pictures(tmp_path))


def test_the_quotes_are_as_read_in_the_paper():
    text = "\n".join(f"{quote.text} | {quote.place}" for _, quote in sorted(QUOTES.items()))
    assert sha256(text.encode()).hexdigest()[:16] == READ_IN_THE_PAPER


def test_quotes_are_short_and_say_where_they_stand():
    assert all(0 < len(quote.text) <= LONGEST for quote in QUOTES.values())
    assert {quote.place for quote in QUOTES.values()} <= PLACES
    assert len(TEXTS) == len(QUOTES)


def test_every_quote_of_the_page_is_in_the_list(document):
    reader = Quoted()
    reader.feed(render_html(document))
    assert set(reader.quotes) == TEXTS  # none invented, and none left unused
    assert "“" not in reader.rest


def test_every_quote_of_the_text_is_in_the_list(document):
    text = re.sub(r"\s+", " ", render_text(document))
    text = re.sub(r"(?<=\w)- (?=\w)", "-", text)  # a line may end behind a hyphen
    assert set(MARKED.findall(text)) == TEXTS


def test_every_claim_quotes_the_paper():
    assert all(quote in QUOTES.values() for claim in paper_claims() for quote in claim.quotes)


def test_the_page_on_the_paper_quotes_it_rightly():
    page = (ROOT / "docs" / "paper.md").read_text(encoding="utf-8")
    quoted = re.findall(r'"([^"]+)"', re.sub(r"\s+", " ", page))
    assert quoted
    assert [words for words in quoted if not any(words in text for text in TEXTS)] == []


def test_case_files_cite_their_own_figures():
    """I-A is Figs. 5 and 11 alone, and so on; as the paper's captions say."""
    for i, letter in enumerate("ABC"):
        ideal, motor = ((ROOT / "cases" / f"{kind}-{letter}.yaml").read_text() for kind in ("I", "II"))
        assert _figures(ideal) == {5 + i, 11 + i}
        assert _figures(motor) == {8 + i, 11 + i, 14 + i}


def _figures(text):
    header = "".join(line for line in text.splitlines() if line.startswith("#"))
    assert "Figs." not in header
    return {int(number) for number in re.findall(r"Fig\. (\d+)", header)}
