"""What is cited: equations of the paper by their own numbers, publications that are among the sources.

The numbers were read in the paper, by hand: MEANINGS says what stands under each.
"""

import re
from pathlib import Path

import pytest

from tests.docs.pages import DOCS, ROOT

PAGE = (DOCS / "equations.md").read_text(encoding="utf-8")
SOURCES = PAGE.partition("\n## Sources\n")[2]
NUMBER = r"\(?(2\.(?:1[01]|[1-9]))\)?"
# "Eq. 2.5", "Eqs. (2.8)-(2.10)", "(2.1) to (2.3)"; not carriage(2.1)
EQUATIONS = re.compile(
    rf"(?:Eqs?\.\s+{NUMBER}|(?<![\w.])\(2\.(?:1[01]|[1-9])\))(?:(?: to |-|, | and ){NUMBER})*"
)

AROUND = 120  # characters before and behind a citation in which its quantity is named
# numbers of the paper's equations -> a word that a text uses which cites just these: what they are
MEANINGS = {
    "2.1 2.2": r"F_h - S",  # motion under an ideal source, without and with impact
    "2.1 2.9": r"without impact",
    "2.2 2.10": r"in contact",
    "2.1 2.2 2.9 2.10": r"contact while x2 . x1 . G",
    "2.2": r"contact while g >= 0",
    "2.1 2.2 2.3": r"A sin\(omega t\)|harmonic",  # the ideal source and what it moves
    "2.3": r"A sin\(omega t\)|A \\sin|A is a force",
    "2.4": r"k_1 \(x_1 - x_2\)",
    "2.4 2.6": r"[Ss]pring.* and damper",
    "2.4 2.5": r"F_s1 \+ F_s2",
    "2.4 2.5 2.6": r"F_s1 \+ F_d \(\+ F_s2",  # what block 1 passes to block 2
    "2.5": r"impact spring|k2 \(y \+ G\)|k_2 \(x_1 - x_2 \+ G\)|carries no",
    "2.6": r"c \(v_1 - v_2\)",
    "2.7": r"[Ff]riction|mu m2 g|sgn|symbol g",
    "2.8": r"[Tt]orque",
    "2.9 2.10": r"[Rr]otor|phi|a1 |ddot x_1",  # motion with the motor, without and with impact
    "2.8 2.9 2.10": r"[Mm]otor",  # the motor and what it moves
    # the amplitude that the unbalance would give, beside that of Table 1
    "2.11": r"m3 ?e ?(?:omega\^2|Omega0\^2|ω²)|m_3 e|[Aa]mplitude|Table 1|\"chaotic\"|Section 2\.1",
    "2.1 2.2 2.3 2.4 2.5 2.6 2.7 2.8 2.9 2.10 2.11": r"numbers",
}
TREE = ("vibsim", "docs", "tests", "cases", "README.md", "CHANGELOG.md", "CONTRIBUTING.md")
TEXTS = {".py", ".c", ".h", ".md", ".yaml", ".js", ".html"}


# "Jorba & Zou 2005", "Wilson (1927)", "Benettin et al. 1980": names, a year, and a bracket that closes
CITED = re.compile(r"([A-Z][A-Za-z']+)(?:(?:,? (?:&|and) |, )[A-Z][A-Za-z']+| et al\.)* \(?((?:19|20)\d\d)\)")
NO_AUTHORS = {"February", "January", "October", "RFC"}


def texts(*tree):
    """(path, text with single blanks) of all written files under the top of the repository but this one."""
    for top in (ROOT / name for name in tree):
        for path in sorted(top.rglob("*")) if top.is_dir() else [top]:
            if path.suffix in TEXTS and "generated" not in path.parts and path != Path(__file__):
                yield str(path.relative_to(ROOT)), re.sub(r"\s+", " ", path.read_text(encoding="utf-8"))


def equations(citation):
    """All numbers that one citation names, in order, those within a range too."""
    numbers: list[int] = []
    end = 0
    for match in re.finditer(r"2\.(\d+)", citation):
        number, ranges = int(match[1]), re.search(r" to |-", citation[end : match.start()])
        numbers += range(numbers[-1] + 1, number + 1) if numbers and ranges else [number]
        end = match.end()
    return " ".join(f"2.{number}" for number in numbers)


def citations(text):
    """(numbers, text around) of every citation of equations of the paper in a text with single blanks."""
    for match in EQUATIONS.finditer(text):
        yield equations(match.group()), text[max(0, match.start() - AROUND) : match.end() + AROUND]


def publications(text):
    """(first name found, year) of the publications that a text cites."""
    return {(name, year) for name, year in CITED.findall(text) if name not in NO_AUTHORS}


def test_every_equation_is_cited_by_the_number_that_it_has_in_the_paper():
    found = [(name, *citation) for name, text in texts(*TREE) for citation in citations(text)]
    assert len(found) > 80
    wrong = [(name, numbers) for name, numbers, _ in found if numbers not in MEANINGS]
    assert not wrong  # numbers that belong to no quantity: say in MEANINGS what the paper has there
    assert [
        (name, numbers) for name, numbers, around in found if not re.search(MEANINGS[numbers], around)
    ] == []


def test_the_page_has_all_equations_of_the_paper():
    rows = [line for line in PAGE.splitlines() if line.startswith("| (2.")]
    cited = " ".join(equations(row.split("|")[1]) for row in rows)
    assert cited.split() == [f"2.{number}" for number in range(1, 12)]


def test_every_publication_that_is_cited_is_among_the_sources():
    cited = {publication for _, text in texts("vibsim") for publication in publications(text)}
    assert len(cited) >= 12
    for name, year in cited:
        assert re.search(rf"{name}.*\({year}\)", SOURCES.replace("\n  ", " ")), (name, year)


def test_every_publication_on_the_page_is_among_the_sources():
    for name, year in publications(PAGE.partition("\n## Sources\n")[0]):
        assert re.search(rf"{name}.*\({year}\)", SOURCES), (name, year)


@pytest.mark.parametrize(
    ("text", "numbers"),
    [
        ("as Eq. (2.11) says", ["2.11"]),
        ("Eqs. (2.8) to (2.10)", ["2.8 2.9 2.10"]),
        ("(Eqs. 2.1-2.3) or (2.5)", ["2.1 2.2 2.3", "2.5"]),
        ("Eqs. (2.4), (2.6) and (2.9)", ["2.4 2.6 2.9"]),
        ("carriage(2.1)", []),
    ],
)
def test_citations_of_equations_are_found(text, numbers):
    assert [found for found, _ in citations(text)] == numbers


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
