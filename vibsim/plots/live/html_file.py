"""A page as one file: style, data and script in it, nothing from elsewhere."""

from __future__ import annotations

import base64
import json
from collections.abc import Sequence
from html import escape
from pathlib import Path
from string import Template
from typing import Any

import numpy as np

from vibsim.cases.plain_text import one_line
from vibsim.files.output_file import output_file
from vibsim.files.plain_data import plain
from vibsim.labelled.labelled import Labelled
from vibsim.plots.errors import PlotError
from vibsim.plots.subject import Subject

ROOM = Path(__file__).parent


def write_page(subjects: Sequence[Subject], out: str, force: bool = False) -> list[str]:
    """Write the page of a run, or of any other result of points, to `out`; the names of the files written.

    Raises PlotError for several results and for what has no page, ResultFileError where it cannot be written.
    """
    if len(subjects) > 1:
        raise PlotError(f"{out}: a page shows one result; give one FILE")
    (subject,) = subjects
    if subject.reads == "trajectory":
        from vibsim.plots.live.run_page import KEYS, run_data

        text = page(subject, ("run.js",), KEYS, run_data(subject))
    elif isinstance(subject.result, Labelled):
        from vibsim.plots.live.points_page import KEYS, points_data

        text = page(subject, ("lines.js", "points.js"), KEYS, points_data(subject))
    else:
        shown = f"{subject.path} is a {subject.reads}"
        raise PlotError(f"{out}: a page shows a run or a table of points, and {shown}")
    with output_file(out, force, "utf-8") as file:
        file.write(text)
    return [out]


def page(subject: Subject, scripts: tuple[str, ...], keys: str, data: dict[str, Any]) -> str:
    """The HTML text; scripts: behind the one that every page has."""
    case = subject.case
    title = one_line(f"{case.name}: {case.title}" if case.title else case.name)
    about = "; ".join(f"{label} {text}" for label, text in subject.result.lines() if label in ABOUT)
    scripts = ("axes.js", *scripts)
    return Template((ROOM / "page.html").read_text(encoding="utf-8")).substitute(
        title=escape(title),
        about=escape(one_line(f"{subject.result.heading()}; {about}" if about else subject.result.heading())),
        style=(ROOM / "page.css").read_text(encoding="utf-8"),
        script="\n".join((ROOM / name).read_text(encoding="utf-8") for name in scripts),
        keys=escape(keys),
        data=script_text(data),
    )


ABOUT = ("motion", "right", "certificate", "start")  # lines of a result that stand below the title


def script_text(data: dict[str, Any]) -> str:
    """JSON that may stand in a script element: no text in it ends the element."""
    text = json.dumps(plain(data), allow_nan=False, ensure_ascii=False, separators=(",", ":"))
    return text.replace("<", "\\u003c").replace("\u2028", "\\u2028").replace("\u2029", "\\u2029")


def packed(values: Any, dtype: str) -> str:
    """Numbers as base64, little endian."""
    return base64.b64encode(np.ascontiguousarray(values, dtype=f"<{dtype}").tobytes()).decode("ascii")
