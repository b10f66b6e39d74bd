"""Pictures drawn from Python: into axes that the user gives, or a figure of their own."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from math import inf
from numbers import Real
from os import PathLike, fspath
from typing import TYPE_CHECKING, Any

from vibsim.plots import style as styles
from vibsim.plots.errors import PlotError
from vibsim.plots.picture import chosen_kinds
from vibsim.plots.subject import Subject, open_subject, subject_of, told_apart
from vibsim.plots.view import WIDTHS_CM, Span, View, parse_span

if TYPE_CHECKING:
    from matplotlib.axes import Axes


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

    Raises PlotError for what does not fit, CaseError and ResultFileError.

    >>> import matplotlib.pyplot as plt, vibsim
    >>> result = vibsim.simulate(vibsim.load_case("II-B", {"run.t_end": "2 s"}))
    >>> figure, (left, right) = plt.subplots(1, 2)
    >>> vibsim.plot(result, "relative", ax=left) is left
    True
    >>> vibsim.plot(result, x="x1", y="v1", ax=right, style=False).get_ylabel()
    'v1 (m s-1)'
    """
    _check(kind, width, size, font_size)
    subjects, canvas = _subjects(result), _canvas(ax)
    with styles.applied(style, font_size):
        view = View(_span(window), _span(detail), width, size, x, y, canvas)
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
    """What makes the figure. To be called outside the style: pyplot's first import may note settings."""
    from matplotlib.axes import Axes

    if ax is None:
        import matplotlib.pyplot as pyplot

        dpi = _own_dpi()
        return lambda **options: pyplot.figure(dpi=dpi, **options)
    from vibsim.plots.given_axes import GivenAxes

    flat = getattr(ax, "flat", ax)
    axes = list(flat) if isinstance(flat, Iterable) else [ax]
    if not axes or not all(isinstance(each, Axes) for each in axes):
        raise PlotError(f"ax must be axes of matplotlib, or a list of them, got {ax!r:.80}")
    return GivenAxes(axes)


def _own_dpi() -> float:
    """Dots per inch of a figure on the screen, as matplotlib has it: vibsim's own are for files."""
    import matplotlib

    return float(matplotlib.rcParamsDefault["figure.dpi"])
