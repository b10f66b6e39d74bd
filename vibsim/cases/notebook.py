"""What a notebook shows of a case: what it is, what follows from its numbers, and its text when opened."""

from html import escape
from typing import TYPE_CHECKING

from vibsim.cases.derived_facts import derived_facts
from vibsim.cases.number import number

if TYPE_CHECKING:
    from vibsim.cases.case import Case

CELL = 'style="text-align:left;padding:0 1em 0 0;vertical-align:top"'


def html_of_case(case: "Case") -> str:
    """The short text of the case, its title, a table of derived numbers and the folded case file; colours are
    the page's own.
    """
    rows = "".join(
        _row(fact.name, f"{number(fact.value, 6)} {fact.unit}".strip(), fact.meaning)
        for fact in derived_facts(case.scene())
    )
    return (
        f"<div><b>{escape(repr(case)[1:-1])}</b><br>{escape(case.title)}<table>{rows}</table>"
        f"<details><summary>case file</summary><pre>{escape(case.to_yaml())}</pre></details></div>"
    )


def _row(*cells: str) -> str:
    return "<tr>" + "".join(f"<td {CELL}>{escape(cell)}</td>" for cell in cells) + "</tr>"
