"""From files to pictures: choose the kinds, draw, write PNG, PDF or SVG, the same bytes every time.

Two columns that the view names, of any result, take the place of the kinds.
"""

from __future__ import annotations

import re
import warnings
from collections.abc import Iterable, Iterator, Sequence
from contextlib import contextmanager
from io import BytesIO
from math import inf
from numbers import Real
from os import PathLike, fspath
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.backend_bases import get_registered_canvas_class
from matplotlib.figure import Figure

from vibsim.cases.problems import counted, did_you_mean
from vibsim.plots import style
from vibsim.plots import style as styles
from vibsim.plots.registry import COLUMNS, KINDS, NOT_OF_BODIES, PictureKind, choose
from vibsim.plots.samples import rows, window_of
from vibsim.plots.sheet import LeanPages, legend_above, sheet
from vibsim.plots.style import BLUE, overlay
from vibsim.plots.subject import (
    WIDTHS_CM,
    PlotError,
    Span,
    Subject,
    View,
    as_text,
    check_one_unit,
    open_subject,
    open_subjects,
    parse_span,
    subject_of,
    told_apart,
)
from vibsim.plots.traces import LINE_UP_TO, VECTOR_UP_TO, Trace, one_per_pixel, trace
from vibsim.results.labelled import Arrays, Labelled, Tidy
from vibsim.results.output_files import check_output, output_file
from vibsim.signals import interrupted_with

FORMATS = (".png", ".pdf", ".svg")
PAGE = ".html"  # which is no picture: it answers
DPI = {".png": 300, ".pdf": 600, ".svg": 600}  # of a vector file: what is rasterized in it
POINTS_PER_INCH = 72  # the resolution at which matplotlib lays out a vector file
WORDS_ABREAST = 4  # words beside each other along an axis; more of them stand upright
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
        from vibsim.plots.html_pages import write_page

        return write_page(subjects, out, force)
    kinds = chosen_kinds(subjects, names, view)
    targets = name_targets(subjects, kinds, out)
    check_targets(targets, force)

    with style.applied(sheet, font_size):
        return _draw(subjects, kinds, view, targets, force)


def chosen_kinds(subjects: Sequence[Subject], names: Sequence[str] | None, view: View) -> list[PictureKind]:
    """The kinds to draw; two columns that the view names take their place. Raises PlotError."""
    if names is not None and (view.x is not None or view.y is not None):
        raise PlotError(f"kind {', '.join(names)}: two columns are drawn in the place of a kind; choose one")
    kinds = choose(names, subjects) if view.x is None and view.y is None else [COLUMNS]
    for span in ("window", "detail", "poincare"):
        if getattr(view, span) not in (None, False) and not any(span in kind.spans for kind in kinds):
            shown = ", ".join(kind.name for kind in kinds)
            fitting = ", ".join(kind.name for kind in KINDS if span in kind.spans)
            raise PlotError(f"{span}: kind {shown} has none; kinds that have: {fitting}")
    for kind in kinds:
        if kind.name not in NOT_OF_BODIES:
            for column in dict.fromkeys(name for subject in subjects for name in subject.columns_in("m")):
                having = [subject for subject in subjects if column in subject.columns_in("m")]
                units = [(subject.path, subject.unit("m", column)) for subject in having]
                check_one_unit(f"kind {kind.name}, {column}", units)
    return kinds


def name_targets(subjects: Sequence[Subject], kinds: Sequence[PictureKind], out: str | None) -> list[str]:
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

    for target in targets:
        check_output(target, force)


def _stem(subjects: Sequence[Subject]) -> str:
    names = [re.sub(r"[^\w.+-]+", "_", subject.stem) for subject in subjects]
    more = len(names) - NAMED_AT_MOST
    return "+".join(names[:NAMED_AT_MOST]) + (f"+{more}-more" if more > 0 else "")


def _draw(
    subjects: Sequence[Subject], kinds: Sequence[PictureKind], view: View, targets: Sequence[str], force: bool
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
    with _laid_out(figure, suffix, dpi):
        figure.savefig(picture, format=suffix[1:], dpi=dpi, metadata=METADATA[suffix])
    return picture.getvalue()


@contextmanager
def _laid_out(figure: Figure, suffix: str, dpi: float) -> Iterator[None]:
    """Lay the figure out for a format. matplotlib draws all of it a first time to that end, unseen."""
    engine, canvas, resolution = figure.get_layout_engine(), figure.canvas, figure.dpi
    if engine is None:
        yield
        return
    try:
        get_registered_canvas_class(suffix[1:])(figure)
        figure.dpi = dpi if suffix == ".png" else POINTS_PER_INCH
        engine.execute(figure)
        figure.set_layout_engine(None)
        yield
    finally:  # it may be drawn in other formats too
        figure.set_layout_engine(engine)
        figure.set_canvas(canvas)
        figure.dpi = resolution


def _pages(figures: Sequence[Figure], dpi: float) -> bytes:
    """A PDF with a page for each figure."""

    sheets = BytesIO()
    with LeanPages(sheets, metadata=METADATA[".pdf"]) as pages:
        for figure in figures:
            with _laid_out(figure, ".pdf", dpi):
                pages.savefig(figure, dpi=dpi)
    return sheets.getvalue()


def _write_opaque(figure: Figure, target: Any) -> None:
    """A PNG without the transparency that matplotlib writes: the same picture, a seventh smaller.

    What matplotlib writes is read at once, so it is not compressed.
    """
    from PIL import Image
    from PIL.PngImagePlugin import PngInfo

    picture, metadata = BytesIO(), PngInfo()
    with _laid_out(figure, ".png", DPI[".png"]):
        figure.savefig(picture, format="png", dpi=DPI[".png"], pil_kwargs={"compress_level": 0})
    for name, value in METADATA[".png"].items():
        metadata.add_text(name, value)
    dpi = (DPI[".png"], DPI[".png"])
    Image.open(picture).convert("RGB").save(target, format="png", dpi=dpi, pnginfo=metadata)


def _write_pages(figures: Sequence[Figure], target: str, force: bool) -> None:
    with output_file(target, force) as file:
        file.write(_pages(figures, DPI[".pdf"]))


# No dates: the same picture is the same file, so pictures can be compared byte by byte.
METADATA: dict[str, dict[str, Any]] = {
    ".png": {"Software": "vibsim"},
    ".pdf": {"Creator": "vibsim", "CreationDate": None},
    ".svg": {"Creator": "vibsim", "Date": None},
}


# Pictures drawn from Python: into axes that the user gives, or a figure of their own.


def plot(
    result: Any,
    kind: str | None = None,
    *,
    ax: Axes | Sequence[Axes] | None = None,
    window: Span | str | None = None,
    detail: Span | str | None = None,
    width: str | None = None,
    size: tuple[float, float] | None = None,
    font_size: float | None = None,
    style: bool | str | PathLike[str] = True,
    x: str | None = None,
    y: str | None = None,
    poincare: bool = False,
) -> Any:
    """Draw what `vibsim plot` draws and return the axes: of one panel these, of several a list.

    Parameters
    ----------
    result : a Result, SweepResult and so on, a Case, the name of a file or of a shipped case; or a list of
        them, laid over each other
    kind : as `vibsim plot --list` names them; None: what suits the result
    ax : axes to draw into, or as many as the picture has panels; None: a new figure of pyplot
    window, detail : spans to show and to enlarge: (first, last) [s], or "100:110"
    width : "column" or "page"
    size : width and height [cm] of a new figure
    font_size : [pt]
    style : True: vibsim's; False: the settings of matplotlib in force; or a style sheet, laid over vibsim's
    x, y : names of two columns to draw against each other, in the place of a kind
    poincare : whether a phase portrait carries the points of the Poincare section, one per period

    Raises PlotError for what does not fit, CaseError and ResultFileError.

    >>> import matplotlib.pyplot as plt, vibsim
    >>> result = vibsim.simulate(vibsim.load_case("II-B", {"run.t_end": "2 s"}))
    >>> figure, (left, right) = plt.subplots(1, 2)
    >>> vibsim.plot(result, "relative", ax=left) is left
    True
    >>> vibsim.plot(result, x="x1", y="v1", ax=right, style=False).get_ylabel()
    'v1 (m/s)'
    """
    _check(kind, width, size, font_size)
    subjects, canvas = _subjects(result), _canvas(ax)
    with styles.applied(style, font_size):
        view = View(_span(window), _span(detail), width, size, x, y, canvas, bool(poincare))
        kinds = chosen_kinds(subjects, None if kind is None else [kind], view)
        if len(kinds) > 1:
            kinds = kinds[:1]
        figure = kinds[0].draw(subjects, view.for_kind(kinds[0].width))
        if ax is not None:
            return ax
        panels = [axes for axes in figure.axes if axes.get_label() != "<colorbar>"]
        return panels[0] if len(panels) == 1 else panels


def _span(span: Any) -> Span | None:
    """A span of the user's. Raises PlotError for what is none."""
    return None if span is None else parse_span(span)


def _check(kind: Any, width: Any, size: Any, font_size: Any) -> None:
    """Raises PlotError for what names no kind, and measures of a figure that are none."""
    if not isinstance(kind, str | None):
        raise PlotError(f"kind must be a name such as 'relative', got {kind!r:.60}")
    if width is not None and width not in WIDTHS_CM:
        raise PlotError(f"width must be one of {', '.join(WIDTHS_CM)}, got {width!r:.60}")
    lengths = [] if size is None else list(size) if isinstance(size, list | tuple) else [None]
    if size is not None and (len(lengths) != 2 or not all(_is_positive(each) for each in lengths)):
        raise PlotError(f"size must be (width, height) in cm, such as (12, 8), got {size!r:.60}")
    if font_size is not None and not _is_positive(font_size):
        raise PlotError(f"font_size must be a number of points, such as 8, got {font_size!r:.60}")


def _is_positive(number: Any) -> bool:
    return isinstance(number, Real) and not isinstance(number, bool) and 0 < float(number) < inf


def _subjects(result: Any) -> list[Subject]:
    several = list(result) if isinstance(result, list | tuple) else [result]
    if not several:
        raise PlotError("there is nothing to draw: give a result, or a list of them")
    subjects = []
    for each in several:
        named = isinstance(each, str | PathLike)
        subjects.append(open_subject(fspath(each)) if named else subject_of(each))
    return told_apart(subjects, [subject.path for subject in subjects])


def _canvas(ax: Any) -> Any:
    """Maker of the figure. To be called outside the style: pyplot's first import may note settings."""
    from matplotlib.axes import Axes

    if ax is None:
        import matplotlib.pyplot as pyplot

        dpi = _own_dpi()
        return lambda **options: pyplot.figure(dpi=dpi, **options)

    flat = getattr(ax, "flat", ax)
    axes = list(flat) if isinstance(flat, Iterable) else [ax]
    if not axes or not all(isinstance(each, Axes) for each in axes):
        raise PlotError(f"ax must be axes of matplotlib, or a list of them, got {ax!r:.80}")
    return GivenAxes(axes)


def _own_dpi() -> float:
    """Dots per inch of a figure on the screen, as matplotlib has it: vibsim's own are for files."""
    import matplotlib

    return float(matplotlib.rcParamsDefault["figure.dpi"])


# Any two columns of a result against each other.


EVENTS = "events/"  # before the name of a column of events


def columns_picture(subjects: Sequence[Subject], view: View) -> Figure:
    """Column `view.y` against column `view.x`: of the samples of a run within the window a line, as smooth as
    the motion where both are states; of everything else points, those whose x lies within the window.
    """
    if not view.x or not view.y:
        raise PlotError("two columns go against each other: give both of them, x and y")
    figure = sheet(view, 6.4)
    axes, named = figure.subplots(), list[tuple[str, str]]()
    for i, subject in enumerate(subjects):
        table, names = _table(subject, (view.x, view.y))
        of_samples = table.dims == ("time",)
        drawn = _of_samples(subject, table, names, view) if of_samples else _points(table, names, view)
        look = overlay(i) if len(subjects) > 1 else {"color": BLUE}
        if not drawn.joined:
            look |= {"linestyle": "none", "marker": "o", "markersize": 1.5}
        many = len(drawn.x) > VECTOR_UP_TO
        axes.plot(drawn.x, drawn.y, label=subject.name, gid="columns", linewidth=0.5, rasterized=many, **look)
        units = (printed_units(table.arrays.column(name).units or "1") for name in names)
        named += [(subject.path, " and ".join(units))]
        check_one_unit(f"{names[0]} and {names[1]}", named)
        if i == 0:
            _label(axes, table, names)
    axes.margins(0.04)
    if len(subjects) > 1:
        legend_above(axes)
    return figure


def _of_samples(subject: Subject, table: Tidy, names: Sequence[str], view: View) -> Trace:
    """The samples within the window [s]; of states also instants between them."""
    span, result = window_of(subject, view.window), subject.result
    if set(names) <= {"time", *subject.tables.states}:
        columns = tuple(dict.fromkeys(("time", *names)))
        return trace(result, columns, lambda block: (block[names[0]], block[names[1]]), span)
    within = rows(result, span)
    x, y = (np.asarray(table.values(name, within), float) for name in names)
    return Trace(x, y, True) if len(x) <= LINE_UP_TO else Trace(*one_per_pixel(lambda: [(x, y)]), False)


def _points(table: Tidy, names: Sequence[str], view: View) -> Trace:
    """The rows in which both columns are known, x within the window. Raises PlotError for none."""
    x, y = (np.asarray(table.values(name), float) for name in names)
    low, high = view.window or (-np.inf, np.inf)
    known = (x >= low) & (x <= high) & ~np.isnan(x) & ~np.isnan(y)
    if not known.any():
        raise PlotError("nothing is known of both columns" + (" within the window" if view.window else ""))
    x, y = x[known], y[known]
    if len(x) > LINE_UP_TO:
        x, y = one_per_pixel(lambda: [(x, y)])
    return Trace(x, y, joined=False)


def _table(subject: Subject, names: tuple[str, str]) -> tuple[Tidy, list[str]]:
    """The table that has both columns, and their names in it. Raises PlotError."""
    arrays = _arrays(subject, names)
    inner = [name.removeprefix(EVENTS) for name in names]
    inner = ["t" if name == EVENTS + "time" else short for name, short in zip(names, inner, strict=True)]
    for name in inner:
        if name not in arrays.datasets:
            near = did_you_mean(name, arrays.datasets)
            raise PlotError(
                f"{subject.path} has no column {name!r}{near}; it has {', '.join(arrays.datasets)}"
            )
    further = {d for name in inner for d in arrays.datasets[name].dims} & set(arrays.further)
    if len(further) > 1:
        raise PlotError(f"{names[0]} and {names[1]} have no rows in common: they run along {sorted(further)}")
    return Tidy(arrays, *further), inner


def _arrays(subject: Subject, names: tuple[str, str]) -> Arrays:
    result = subject.result
    if not isinstance(result, Labelled):
        raise PlotError(f"{subject.path} has no columns to draw: x and y are for results")
    of_events = [name.startswith(EVENTS) for name in names]
    if any(of_events) and subject.reads != "trajectory":
        raise PlotError(f"{subject.path} has no events")
    if any(of_events) and not all(of_events):
        raise PlotError(f"{names[0]} and {names[1]}: one is of events and one is not")
    return subject.result.events.arrays() if any(of_events) else result.arrays()


def _label(axes: Axes, table: Tidy, names: Sequence[str]) -> None:
    for name, axis in zip(names, (axes.xaxis, axes.yaxis), strict=True):
        column = table.arrays.column(name)
        unit = f" ({printed_units(column.units)})" if column.units and column.units != "1" else ""
        axis.set_label_text(as_text(name) + unit)
        if column.flags:
            axis.set_ticks(list(column.flags.values()), list(column.flags))
            if axis is axes.xaxis and len(column.flags) > WORDS_ABREAST:
                axes.tick_params(axis="x", labelrotation=90)


def printed_units(units: str) -> str:
    """Units of a file as axes print them.

    >>> printed_units("m s-1"), printed_units("kg m2 s-2"), printed_units("s-1")
    ('m/s', 'kg m²/s²', '1/s')
    """
    above: list[str] = []
    below: list[str] = []
    for unit in units.split():
        name, power = unit.rstrip("-0123456789"), unit[len(unit.rstrip("-0123456789")) :]
        raised = name + power.lstrip("-").replace("1", "").translate(SUPERSCRIPTS)
        (below if power.startswith("-") else above).append(raised)
    return "/".join(filter(None, [" ".join(above) or "1", " ".join(below)]))


SUPERSCRIPTS = str.maketrans("23456789", "²³⁴⁵⁶⁷⁸⁹")


# Axes of the user's, in the place of a figure that a kind of picture would make for itself.


class GivenAxes:
    """Stands for a figure whose panels are these axes; everything else is asked of their own figure.

    Raises PlotError where a picture needs another number of panels.
    """

    def __init__(self, axes: Sequence[Axes]):
        self._axes = list(axes)
        self._figure = axes[0].get_figure(root=True)

    def __call__(self, **_: Any) -> GivenAxes:
        """Itself, as `matplotlib.figure.Figure` would be made."""
        return self

    def subplots(
        self, nrows: int = 1, ncols: int = 1, *, squeeze: bool = True, gridspec_kw: Any = None, **_: Any
    ) -> Any:
        """The axes in the shape asked for."""
        self._check(nrows * ncols)
        grid = np.array(self._axes, dtype=object).reshape(nrows, ncols)
        if not squeeze:
            return grid
        return grid[0, 0] if grid.size == 1 else grid.squeeze()

    def _check(self, count: int) -> None:
        if count != len(self._axes):
            raise PlotError(
                f"this picture has {counted(count, 'panel')}, and ax gives {len(self._axes)}: give as many, "
                "or leave ax out"
            )

    def add_gridspec(self, *args: Any, **options: Any) -> Any:
        """Pictures of unequal panels lay out a whole sheet."""
        raise PlotError("this picture lays out a whole sheet of panels: leave ax out")

    add_axes = add_subplot = add_gridspec

    def suptitle(self, *args: Any, **options: Any) -> None:
        """The title of the whole sheet is the user's."""

    def legend(self, handles: Any, labels: Any, **_: Any) -> Any:
        """A legend of the picture stands in its last panel."""
        return self._axes[-1].legend(handles, labels)

    def __getattr__(self, name: str) -> Any:
        return getattr(self._figure, name)
