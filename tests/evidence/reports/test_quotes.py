"""What the report, docs/paper.md and case files put into quotation marks is the paper's, word for word."""

import re
from hashlib import sha256
from html.parser import HTMLParser
from pathlib import Path

import pytest

from tests.evidence.reports.made import numbers, plane, reading
from tests.evidence.reports.test_pages import audit_pictures
from tests.plots.artists import collections
from vibsim.cases import load_case
from vibsim.evidence.reports import readings
from vibsim.evidence.reports.claims import QUOTES
from vibsim.evidence.reports.figures import draw_search, points_of
from vibsim.evidence.reports.measurements import SHIPPED_READINGS as CASES
from vibsim.evidence.reports.measurements import MeasurementInterrupted
from vibsim.evidence.reports.pages import render_html, render_text
from vibsim.evidence.reports.paper_document import captured_by, paper_claims, paper_document, readings_table
from vibsim.evidence.reports.readings import (
    FREE,
    POINTS,
    READINGS,
    SHIPPED,
    SPREAD,
    STATEMENTS,
    keeps_table_1,
    search_plane,
    search_readings,
)
from vibsim.fitting.plan import Search, make_plan
from vibsim.plots import style

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


# The readings of the printed numbers: ranked by `vibsim fit`, told in a table and a map.


def motors(**changes):
    return [load_case(name, changes) for name in ("II-B", "II-C")]


def test_every_reading_and_range_suits_both_motors():
    statements = [said.text for said in STATEMENTS]
    plan = make_plan(motors(), FREE, statements, READINGS, {}, 2, SPREAD, Search())
    assert len(plan.readings) == len(READINGS) == len({str(each) for each in plan.readings})


def test_the_shipped_cases_are_the_shipped_reading():
    statements = [said.text for said in STATEMENTS]
    (changes,) = make_plan(motors(), {}, statements, [SHIPPED], {}, 0, {}, Search()).readings
    for name, printed in zip(CASES, motors(), strict=True):
        assert load_case(name).sha256 == printed.with_values(changes).sha256


def test_readings_are_judged_from_all_starts(monkeypatch):
    monkeypatch.setattr(readings, "READINGS", (SHIPPED, "c=0.03 N s/m"))
    monkeypatch.setattr(readings, "PARAMETER_SEARCH_STARTS", 2)
    told = []
    found = search_readings(motors(**{"run.t_end": "20 s"}), lambda *done: told.append(done) or True)
    assert len(found["ranking"]) == 3
    assert {each["of"] for row in found["ranking"] for each in row["statements"]} == {3}
    assert told[-1] == (6, 6)


def test_the_plane_is_covered(monkeypatch):
    monkeypatch.setattr(readings, "POINTS", 8)
    found = search_plane(motors(**{"run.t_end": "10 s"}), lambda *done: True)
    places, shares = points_of(found["ranking"], (0, 1))
    assert len(places) == len(shares) == 8
    assert all(0.5 <= inertia <= 20 and 0.001 <= damping <= 0.05 for inertia, damping in places)


def test_the_search_stops_when_told():
    with pytest.raises(MeasurementInterrupted):
        search_readings(motors(**{"run.t_end": "10 s"}), lambda done, total: done < 3)


def test_the_map_shows_the_least_share_of_its_statements():
    places, shares = points_of(plane(), (0, 1))
    assert len(places) == POINTS and set(shares) == {0.0}
    places, shares = points_of(plane(), (0,))
    assert shares == [float(inertia > 5) for inertia, _ in places]
    with style.applied():
        figure = draw_search({"ranking": plane()}, (1.0, 0.001), (8.5, 0.0035))
        figure.canvas.draw()
    panels = [axes for axes in figure.axes if axes.get_title()]
    (left,) = collections(panels[0], "share")
    assert sorted(left.get_array()) == sorted(shares)
    assert [line.get_marker() for line in panels[1].lines] == ["x", "o"]


def test_the_table_says_what_each_reading_changes_and_explains():
    table = readings_table(numbers()["search"]["readings"]["ranking"])
    assert [row[0] for row in table.rows][:2] == ["J = 0.0085 kg m², c = 0.0035 N s/m", "no stop"]
    assert table.rows[0][1:4] == ("kept", "25/25", "0/25")
    assert table.rows[3][0] == "nothing, as printed"
    assert table.rows[4][:2] == ("m3 = 54 g", "contradicted")
    assert all(len(row) == len(table.columns) for row in table.rows)


def test_single_numbers_that_capture_are_named():
    said = captured_by(numbers()["search"]["readings"]["ranking"])
    assert said == "Of single changes, c = 0.03 N s/m, no stop capture II-B for good."
    assert "none tried" in captured_by([reading({}, 0, 0.6)])


def test_m3_and_e_are_those_of_table_1():
    assert keeps_table_1({"excitation.J": "0.01"}) and keeps_table_1({})
    assert not keeps_table_1({"excitation.m3": "62 g", "coupling.c": "0.00175"})
