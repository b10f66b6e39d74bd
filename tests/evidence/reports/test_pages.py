"""The pages: one HTML file that needs nothing else, and the same as text."""

import base64
import re
import shutil
import subprocess
from html.parser import HTMLParser
from itertools import pairwise

import pytest
from matplotlib.image import imread

from tests.evidence.reports.made import numbers
from vibsim.evidence.reports.claims import FAILS, HOLDS
from vibsim.evidence.reports.pages import (
    WIDTH,
    Document,
    PageSection,
    PageTable,
    Paragraph,
    Picture,
    render_html,
    render_text,
)
from vibsim.evidence.reports.paper_document import judge_claims, paper_document

PIXEL = base64.b64decode(
    "iVBORw0KGgoAAAANSUhEUgAAAAEAAAABCAYAAAAfFcSJAAAADUlEQVR42mNk+M9QDwADhgGAWjR9awAAAABJRU5ErkJggg=="
)
AUDIT = ("search", "growth", "load-curves", "regimes", "drift", "capture")
VOID = {"meta", "img", "br", "hr", "link", "input"}
CHROMIUM = shutil.which("chromium") or shutil.which("chromium-browser") or shutil.which("google-chrome")


class Reader(HTMLParser):
    """Notes what a page is made of, and whether every element is closed where it should be."""

    def __init__(self):
        super().__init__()
        self.open, self.elements, self.text = [], [], ""

    def handle_starttag(self, tag, attrs):
        self.elements.append((tag, dict(attrs)))
        if tag not in VOID:
            self.open.append(tag)

    def handle_endtag(self, tag):
        assert self.open.pop() == tag, f"</{tag}> closes something else"

    def handle_data(self, data):
        self.text += data

    def all(self, tag):
        return [attrs for name, attrs in self.elements if name == tag]


def read(page):
    """The page, parsed; nothing may be left open."""
    reader = Reader()
    reader.feed(page)
    reader.close()
    assert reader.open == []
    return reader


def assert_stands_alone(reader):
    """Everything is inside: no script, no style sheet, no picture and no link from elsewhere."""
    assert not reader.all("script") and not reader.all("link") and not reader.all("iframe")
    sources = [attrs["src"] for _, attrs in reader.elements if "src" in attrs]
    assert sources
    assert all(source.startswith("data:image/png;base64,") for source in sources)
    assert all(attrs["href"].startswith("#") for attrs in reader.all("a"))
    assert all(attrs["alt"].strip() for attrs in reader.all("img"))


def assert_accessible(reader):
    """A language, a title, landmarks, headings in order, and every link leads somewhere."""
    assert reader.all("html")[0]["lang"] == "en"
    assert all(len(reader.all(tag)) == 1 for tag in ("title", "h1", "main", "header", "footer", "nav"))
    levels = [int(tag[1]) for tag, _ in reader.elements if re.fullmatch("h[1-6]", tag)]
    assert levels[0] == 1
    assert all(below <= above + 1 for above, below in pairwise(levels))
    ids = [attrs["id"] for _, attrs in reader.elements if "id" in attrs]
    assert len(ids) == len(set(ids))
    assert {attrs["href"][1:] for attrs in reader.all("a")} <= set(ids)
    assert all(attrs["scope"] in ("row", "col") for attrs in reader.all("th"))


@pytest.fixture
def picture(tmp_path):
    (tmp_path / "fig-05.png").write_bytes(PIXEL)
    return Picture(tmp_path / "fig-05.png", "Fig. 5", "A caption.", 'what is <seen> & "said"')


@pytest.fixture
def document(picture, tmp_path):
    return paper_document(numbers(), [picture], audit_pictures(tmp_path))


def audit_pictures(folder):
    for name in AUDIT:
        (folder / f"{name}.png").write_bytes(PIXEL)
    words = {name: (name, f"Of the {name}.", f"The {name}, in words.") for name in AUDIT}
    return {name: Picture(folder / f"{name}.png", *said) for name, said in words.items()}


def test_the_page_stands_alone(document):
    page = render_html(document)
    reader = read(page)
    assert_stands_alone(reader)
    assert_accessible(reader)
    assert len(reader.all("img")) == 1 + len(AUDIT)
    for word in ("@media (prefers-color-scheme: dark)", "@media print", 'name="viewport"'):
        assert word in page


def test_pictures_are_inside_with_their_words(document):
    images = read(render_html(document)).all("img")
    assert images[0]["alt"] == 'what is <seen> & "said"'
    assert base64.b64decode(images[0]["src"].partition(",")[2]) == PIXEL


def test_text_is_escaped():
    hostile = '<script>alert("x")</script> & <b>'
    table = PageTable(hostile, (hostile,), ((hostile,),))
    section = PageSection("s", hostile, (Paragraph(hostile), table))
    reader = read(render_html(Document(hostile, hostile, (section,), ((hostile, hostile),))))
    assert not reader.all("script") and not reader.all("b")
    assert hostile in reader.text


@pytest.mark.parametrize("render", [render_html, render_text])
def test_both_pages_tell_every_claim(document, render):
    page = render(document)
    told = re.sub(r"\s+", " ", read(page).text if render is render_html else page)
    for claim, finding in judge_claims(numbers()):
        words = [claim.statement, claim.criterion, claim.whose, finding.remark]
        words += [verdict.condition for verdict in finding.verdicts]
        quoted = [text for quote in claim.quotes for text in (quote.text, quote.place)]
        for text in (*words, *quoted, *finding.measured):
            assert text in told
        for verdict in finding.verdicts:
            assert verdict.word in told.lower()


def test_figures_come_first_then_assumptions(document):
    """What the paper shows; then duration, start, g and solver, before any verdict."""
    assert [section.key for section in document.sections[:2]] == ["figures", "assumptions"]
    first = document.sections[1]
    rows = {row[0]: row[2] for row in first.blocks[0].rows}
    assert (rows["Duration"], rows["Gravity"]) == ("300 s", "9.81 m/s²")
    assert {"Start", "Solver, step, tolerance"} <= set(rows)


def test_a_deciding_picture_stands_with_its_claim(document):
    """Once, with the first claim that it decides; the others point to it."""
    page = render_html(document)
    article = page.partition('<article id="impacts-differ">')[2].partition("</article>")[0]
    assert '<figure id="drift">' in article
    later = page.partition('<article id="rates-higher">')[2].partition("</article>")[0]
    assert '<a href="#drift">' in later and "<figure" not in later
    assert page.count('<figure id="drift">') == 1


def test_a_wrong_number_is_told_otherwise(document, picture, tmp_path):
    table = numbers()
    table["runs"]["I-C"]["cycles"]["verdict"] = "some cycles"
    wrong = paper_document(table, [picture], audit_pictures(tmp_path))
    key = '<article id="impacts">'
    assert HOLDS in finding_in(render_html(document), key)
    assert FAILS in finding_in(render_html(wrong), key)


def finding_in(page, key):
    """The verdict on a claim, as the page shows it."""
    return page.partition(key)[2].partition('<p class="finding">')[2].partition("</p>")[0]


def test_the_text_fits_its_width(document):
    lines = render_text(document).splitlines()
    tabled = re.compile(r"\S  +\S|^ {20}")  # columns stand two spaces apart
    wide = [line for line in lines if len(line) > WIDTH and not tabled.search(line)]
    assert wide == []  # only tables may be wider
    assert all(line == line.rstrip() for line in lines)


@pytest.mark.skipif(CHROMIUM is None, reason="no headless browser")
def test_a_browser_shows_the_page(document, tmp_path):
    """With the network off: the page is drawn, and not blank."""
    page, shot = tmp_path / "report.html", tmp_path / "shot.png"
    page.write_text(render_html(document), encoding="utf-8")
    command = [
        CHROMIUM, "--headless", "--no-sandbox", "--disable-gpu", "--disable-quic", "--no-first-run",
        "--disable-background-networking", "--disable-component-update", "--disable-sync",
        "--proxy-server=127.0.0.1:9", f"--user-data-dir={tmp_path / 'profile'}",
        "--window-size=1000,1400", f"--screenshot={shot}", page.as_uri(),
    ]  # fmt: skip
    subprocess.run(command, capture_output=True, timeout=100, check=True)
    pixels = imread(shot)
    assert pixels.shape[1] == 1000
    assert 0.002 < (pixels[..., :3].mean(axis=2) < 0.5).mean() < 0.5  # ink on paper
