"""What the code cites, an equation of the paper or a publication, is on the page of equations."""

import re

import pytest

from tests.docs.pages import DOCS, ROOT

PAGE = (DOCS / "equations.md").read_text(encoding="utf-8")
SOURCES = PAGE.partition("\n## Sources\n")[2]
EQUATIONS = re.compile(r"Eqs?\. ?\(?(2\.\d+)\)?(?:(?: to |-|, | and )\(?(2\.\d+)\)?)*")
# "Jorba & Zou 2005", "Wilson (1927)", "Benettin et al. 1980": names, a year, and a bracket that closes
CITED = re.compile(r"([A-Z][A-Za-z']+)(?:(?:,? (?:&|and) |, )[A-Z][A-Za-z']+| et al\.)* \(?((?:19|20)\d\d)\)")
NO_AUTHORS = {"February", "January", "October", "RFC"}


def code():
    """Text of all sources of vibsim, lines joined."""
    for path in sorted((ROOT / "vibsim").rglob("*")):
        if path.suffix in (".py", ".c", ".h"):
            yield path.name, re.sub(r"\s*\n\s*", " ", path.read_text(encoding="utf-8"))


def equations(text):
    """Numbers of the paper's equations that a text cites."""
    return {number for match in EQUATIONS.finditer(text) for number in re.findall(r"2\.\d+", match.group())}


def publications(text):
    """(first name found, year) of the publications that a text cites."""
    return {(name, year) for name, year in CITED.findall(text) if name not in NO_AUTHORS}


def test_every_equation_that_is_cited_is_there():
    cited = {number for _, text in code() for number in equations(text)}
    assert len(cited) >= 8
    absent = {number for number in cited if f"({number})" not in PAGE}
    assert absent <= {"2.2"}  # (2.1) to (2.3) stand in one row


def test_every_publication_that_is_cited_is_among_the_sources():
    cited = {publication for _, text in code() for publication in publications(text)}
    assert len(cited) >= 12
    for name, year in cited:
        assert re.search(rf"{name}.*\({year}\)", SOURCES.replace("\n  ", " ")), (name, year)


def test_every_publication_on_the_page_is_among_the_sources():
    for name, year in publications(PAGE.partition("\n## Sources\n")[0]):
        assert re.search(rf"{name}.*\({year}\)", SOURCES), (name, year)


@pytest.mark.parametrize(
    ("text", "equation"), [("as Eq. (2.11) says", {"2.11"}), ("Eqs. (2.8) to (2.10)", {"2.8", "2.10"})]
)
def test_citations_of_equations_are_found(text, equation):
    assert equations(text) == equation


@pytest.mark.parametrize(
    ("text", "publication"),
    [
        ("(after Jorba & Zou 2005)", ("Jorba", "2005")),
        ("Wilson (1927): centre", ("Wilson", "1927")),
        ("(Benettin et al. 1980)", ("Benettin", "1980")),
    ],
)
def test_citations_of_publications_are_found(text, publication):
    assert publications(text) == {publication}
