"""From files to pictures: choose the kinds, draw, and write PNG, PDF or SVG, the same bytes every time."""

from __future__ import annotations

import re
import warnings
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from io import BytesIO
from pathlib import Path
from typing import TYPE_CHECKING, Any

from vibsim.files.signals import interrupted_with
from vibsim.plots.errors import PlotError
from vibsim.plots.registry import COLUMNS, KINDS, Kind, choose
from vibsim.plots.subject import Subject, open_subjects
from vibsim.plots.view import View

if TYPE_CHECKING:
    from matplotlib.figure import Figure

FORMATS = (".png", ".pdf", ".svg")
PAGE = ".html"  # which is no picture: it answers
DPI = {".png": 300, ".pdf": 600, ".svg": 600}  # of a vector file: what is rasterized in it
NAMED_AT_MOST = 3  # subjects spelt out in a default file name


def draw_files(
    paths: Sequence[str],
    names: Sequence[str] | None,
    view: View,
    out: str | None = None,
    force: bool = False,
    sheet: str | bool = True,
    font_size: float | None = None,
) -> list[str]:
    """Draw what is in some files, one picture per kind; the names of the pictures written.

    Parameters
    ----------
    paths : result files, or cases where the kinds need no more; several are laid over each other
    names : names of kinds, ["all"], or None for what suits the files
    out : the picture; None for `<file>-<kind>.png` here. Several kinds become the pages of a PDF, or
    `<out>-<kind>` files
    force : replace existing pictures
    sheet, font_size : see `style.applied`

    Raises PlotError, CaseError and ResultFileError; nothing is drawn before all of that is checked.
    """
    subjects = open_subjects(paths)
    if out is not None and Path(out).suffix.lower() == PAGE:
        if names is not None or view != View():
            raise PlotError(
                f"{out}: a page shows everything of a result; leave out --kind, --x, --y, --window, "
                "--detail, --width and --size"
            )
        from vibsim.plots.live.html_file import write_page

        return write_page(subjects, out, force)
    kinds = chosen_kinds(subjects, names, view)
    targets = name_targets(subjects, kinds, out)
    check_targets(targets, force)
    from vibsim.plots import style

    with style.applied(sheet, font_size):
        return _draw(subjects, kinds, view, targets, force)


def chosen_kinds(subjects: Sequence[Subject], names: Sequence[str] | None, view: View) -> list[Kind]:
    """The kinds to draw; two columns that the view names take their place. Raises PlotError."""
    if names is not None and (view.x is not None or view.y is not None):
        raise PlotError(f"kind {', '.join(names)}: two columns are drawn in the place of a kind; choose one")
    kinds = choose(names, subjects) if view.x is None and view.y is None else [COLUMNS]
    for span in ("window", "detail"):
        if getattr(view, span) is not None and not any(span in kind.spans for kind in kinds):
            shown = ", ".join(kind.name for kind in kinds)
            fitting = ", ".join(kind.name for kind in KINDS if span in kind.spans)
            raise PlotError(f"{span}: kind {shown} has none; kinds that have: {fitting}")
    return kinds


def name_targets(subjects: Sequence[Subject], kinds: Sequence[Kind], out: str | None) -> list[str]:
    """The file of each kind; one for all of them when several make a PDF."""
    if out is None:
        return [f"{_stem(subjects)}-{kind.name}.png" for kind in kinds]
    suffix = picture_suffix(out, f"; a page is {PAGE}")
    if len(kinds) == 1 or suffix == ".pdf":
        return [out]
    path = Path(out)
    return [str(path.with_name(f"{path.stem}-{kind.name}{path.suffix}")) for kind in kinds]


def picture_suffix(out: str, besides: str = "") -> str:
    """Suffix of a picture, in lower case; PlotError for a format that vibsim does not write.

    besides : what else would be allowed, for the message
    """
    suffix = Path(out).suffix.lower()
    if suffix not in FORMATS:
        suffix_text = f"suffix {suffix}" if suffix else "no suffix"
        raise PlotError(
            f"{out}: {suffix_text}; pictures are {', '.join(FORMATS[:-1])} or {FORMATS[-1]}{besides}"
        )
    return suffix


def check_targets(targets: Sequence[str], force: bool) -> None:
    """Raise ResultFileError for a target that exists (unless `force`) or cannot be written."""
    from vibsim.files.output_file import check_output

    for target in targets:
        check_output(target, force)


def _stem(subjects: Sequence[Subject]) -> str:
    names = [re.sub(r"[^\w.+-]+", "_", subject.stem) for subject in subjects]
    more = len(names) - NAMED_AT_MOST
    return "+".join(names[:NAMED_AT_MOST]) + (f"+{more}-more" if more > 0 else "")


def _draw(
    subjects: Sequence[Subject], kinds: Sequence[Kind], view: View, targets: Sequence[str], force: bool
) -> list[str]:
    figures = (kind.draw(subjects, view.for_kind(kind.width)) for kind in kinds)
    for target in targets:
        with _room_enough(target), interrupted_with(lambda target=target: f"{target} is not written"):  # type: ignore[misc]
            if len(targets) < len(kinds):
                _write_pages(list(figures), target, force)
            else:
                write_figure(next(figures), target, force)
    return list(targets)


@contextmanager
def _room_enough(target: str) -> Iterator[None]:
    """PlotError where words leave no room for axes, which matplotlib warns of and draws over each other."""
    from kiwisolver import UnsatisfiableConstraint  # matplotlib's, which lays out the axes by it

    with warnings.catch_warnings():
        warnings.filterwarnings("error", "constrained_layout not applied", UserWarning)
        try:
            yield
        except (UserWarning, UnsatisfiableConstraint):
            advice = "make it larger (--size, --width page) or its text smaller (--font-size)"
            raise PlotError(f"{target}: too small for what it shows: {advice}") from None


def write_figure(figure: Figure, target: str, force: bool) -> None:
    """Write one figure as PNG, PDF or SVG. Raises PlotError and ResultFileError."""
    from vibsim.files.output_file import output_file

    suffix = picture_suffix(target)
    with output_file(target, force) as file:
        if suffix == ".png":
            _write_opaque(figure, file)
        else:
            file.write(drawn(figure, suffix, DPI[suffix]))


def drawn(figure: Figure, suffix: str, dpi: float) -> bytes:
    """A figure as PNG, PDF or SVG, in memory: a disk that is full leaves matplotlib's files in disorder."""
    if suffix == ".pdf":
        return _pages([figure], dpi)
    picture = BytesIO()
    figure.savefig(picture, format=suffix[1:], dpi=dpi, metadata=METADATA[suffix])
    return picture.getvalue()


def _pages(figures: Sequence[Figure], dpi: float) -> bytes:
    """A PDF with a page for each figure."""
    from vibsim.plots.page.pdf_pages import LeanPages

    sheets = BytesIO()
    with LeanPages(sheets, metadata=METADATA[".pdf"]) as pages:
        for figure in figures:
            pages.savefig(figure, dpi=dpi)
    return sheets.getvalue()


def _write_opaque(figure: Figure, target: Any) -> None:
    """A PNG without the transparency that matplotlib writes: the same picture, a seventh smaller."""
    from PIL import Image
    from PIL.PngImagePlugin import PngInfo

    picture, metadata = BytesIO(), PngInfo()
    figure.savefig(picture, format="png", dpi=DPI[".png"])
    for name, value in METADATA[".png"].items():
        metadata.add_text(name, value)
    dpi = (DPI[".png"], DPI[".png"])
    Image.open(picture).convert("RGB").save(target, format="png", dpi=dpi, pnginfo=metadata)


def _write_pages(figures: Sequence[Figure], target: str, force: bool) -> None:
    from vibsim.files.output_file import output_file

    with output_file(target, force) as file:
        file.write(_pages(figures, DPI[".pdf"]))


# No dates: the same picture is the same file, so pictures can be compared byte by byte.
METADATA: dict[str, dict[str, Any]] = {
    ".png": {"Software": "vibsim"},
    ".pdf": {"Creator": "vibsim", "CreationDate": None},
    ".svg": {"Creator": "vibsim", "Date": None},
}
