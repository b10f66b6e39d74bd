"""What a figure shows, for the tests to look at."""

from functools import lru_cache

import numpy as np
from matplotlib.figure import Figure

from vibsim.plots.registry import kind_named
from vibsim.plots.subject import View, open_subject

BLANK = np.nan  # a cell of a map where nothing is drawn


def figure_of(kind, subjects, **view):
    """The picture of a kind, a column wide where nothing else is said."""
    return kind_named(kind).draw(subjects, View(**{"width": "column", **view}))


@lru_cache(maxsize=16)
def laid_out(kind, path, width="column"):
    """The picture of a kind for a file, laid out on its paper: no text is cut off. It is only read."""
    return on_paper(figure_of(kind, [open_subject(str(path))], width=width))


def on_paper(figure):
    """The figure, laid out on its paper: no text is cut off, no legend covers anything."""
    figure.draw_without_rendering()
    assert clipped_texts(figure) == []
    assert colliding_legends(figure) == []
    return figure


def panels(shown):
    """The axes of a figure, or the ones that are given."""
    return shown.axes if isinstance(shown, Figure) else [shown]


def lines(shown, gid):
    """The lines of a figure or of axes that carry a name, in drawing order."""
    return [line for axes in panels(shown) for line in axes.get_lines() if line.get_gid() == gid]


def letters(figure):
    """The letters of the panels."""
    return words(figure, "letter")


def patches(shown, gid):
    """The areas of a figure or of axes that carry a name."""
    return [patch for axes in panels(shown) for patch in axes.patches if patch.get_gid() == gid]


def collections(shown, gid):
    """The meshes, filled areas and bars of a figure or of axes that carry a name."""
    return [each for axes in panels(shown) for each in axes.collections if each.get_gid() == gid]


def notes(shown, gid):
    """The texts within the axes that carry a name."""
    return [text for axes in panels(shown) for text in axes.texts if text.get_gid() == gid]


def words(shown, gid):
    """What these texts say."""
    return [text.get_text() for text in notes(shown, gid)]


def legend(figure):
    """The names in the legends beside the panels."""
    return [text.get_text() for each in figure.legends for text in each.get_texts()]


def points(line):
    """Data of a line, (x, y)."""
    return np.asarray(line.get_xdata(), dtype=float), np.asarray(line.get_ydata(), dtype=float)


def assert_cells(mesh, expected):
    """A map shows these cells as rows from below, those between values far apart among them."""
    np.testing.assert_array_equal(mesh.get_array().filled(BLANK), expected)


def clipped_texts(figure):
    """Texts that reach beyond the paper by more than a pixel; the figure has been laid out."""
    paper = figure.bbox.padded(1)
    shown = [text for text in texts(figure) if text.get_visible() and text.get_text().strip()]
    boxes = [(text.get_text(), text.get_window_extent()) for text in shown]
    return [
        text
        for text, box in boxes
        if box.x0 < paper.x0 or box.y0 < paper.y0 or box.x1 > paper.x1 or box.y1 > paper.y1
    ]


def texts(figure):
    """Every text on the page: headings, labels, labels of the ticks in range, legends, notes."""
    yield from figure.texts
    for axes in figure.axes:
        yield from (axes.title, axes._left_title, axes._right_title, axes.xaxis.label, axes.yaxis.label)
        yield from axes.texts
        if axes.get_legend():
            yield from axes.get_legend().get_texts()
        for axis in (axes.xaxis, axes.yaxis):
            low, high = sorted(axis.get_view_interval())
            yield from (tick.label1 for tick in axis.get_major_ticks() if low <= tick.get_loc() <= high)


def colliding_legends(figure):
    """Boxes of the axes and notes that legends reach into; the figure has been laid out."""
    found = []
    for axes in figure.axes:
        if axes.get_legend() is None:
            continue
        box = axes.get_legend().get_window_extent()
        covers = [other.bbox for other in figure.axes]
        if axes.get_title(loc="right"):
            covers.append(axes._right_title.get_window_extent())
        found += [cover for cover in covers if _overlap(box, cover)]
    return found


def _overlap(a, b):
    return a.x0 < b.x1 - 1 and b.x0 < a.x1 - 1 and a.y0 < b.y1 - 1 and b.y0 < a.y1 - 1
