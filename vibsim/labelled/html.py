"""What a notebook shows of a result: its telling lines, and its columns when they are opened."""

from collections.abc import Iterable
from html import escape

from vibsim.files.declarations import Column
from vibsim.labelled.arrays import Arrays

CELL = 'style="text-align:left;padding:0 1em 0 0;vertical-align:top"'


def html_of(heading: str, lines: Iterable[tuple[str, str]], arrays: Arrays | None = None) -> str:
    """The heading, a table of the lines, and a folded one of the columns; colours are the page's own."""
    rows = "".join(_row(label, text) for label, text in lines)
    columns = "" if arrays is None else _columns(arrays)
    return f"<div><b>{escape(heading)}</b><table>{rows}</table>{columns}</div>"


def _columns(arrays: Arrays) -> str:
    columns = "".join(_column(name, arrays) for name in arrays.datasets)
    head = "".join(f"<th {CELL}>{word}</th>" for word in ("name", "dimensions", "unit", "what it is"))
    return (
        f"<details><summary>{len(arrays.datasets)} columns</summary>"
        f"<table><thead><tr>{head}</tr></thead><tbody>{columns}</tbody></table></details>"
    )


def _row(label: str, text: str) -> str:
    return f"<tr><td {CELL}>{escape(label)}</td><td {CELL}>{escape(text)}</td></tr>"


def _column(name: str, arrays: Arrays) -> str:
    dataset = arrays.datasets[name]
    dims = ", ".join(dataset.dims)
    cells = (name, dims, _unit(dataset.column), dataset.column.long_name)
    return "<tr>" + "".join(f"<td {CELL}>{escape(cell)}</td>" for cell in cells) + "</tr>"


def _unit(column: Column) -> str:
    return ", ".join(column.flags) if column.flags else column.units or ""
