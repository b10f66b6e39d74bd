"""How every picture looks: 8 pt, thin lines, colours that survive colour blindness and grey print."""

from __future__ import annotations

import warnings
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

import matplotlib

# Okabe and Ito, "Color Universal Design" (2008), dark and light in turn: they print in different greys.
BLUE, ORANGE, BLACK, SKY, VERMILLION, PINK, GREEN = (
    "#0072B2", "#E69F00", "#000000", "#56B4E9", "#D55E00", "#CC79A7", "#009E73",
)  # fmt: skip
YELLOW = "#F0E442"  # of theirs too, for areas alone
GREY = "0.45"
SHADE = "0.90"


_COLOURS = (BLUE, ORANGE, BLACK, SKY, VERMILLION, PINK, GREEN)

THIN = 0.6  # line width of data [pt]
STEP, WIDEST = 0.8, 2.6  # by how much the lines of several files differ in width, and the widest [pt]

SETTINGS: Any = {
    "font.family": "sans-serif",
    "font.sans-serif": ["DejaVu Sans"],  # comes with matplotlib: the same picture on every machine
    "font.size": 8,
    "axes.titlesize": 8,
    "axes.labelsize": 8,
    "xtick.labelsize": 7,
    "ytick.labelsize": 7,
    "legend.fontsize": 7,
    "legend.frameon": False,
    "legend.borderpad": 0.0,
    "legend.borderaxespad": 0.0,
    "legend.handlelength": 2.4,
    "legend.columnspacing": 1.4,
    "axes.linewidth": 0.5,
    "axes.labelpad": 2.5,
    "axes.xmargin": 0.0,
    "axes.ymargin": 0.06,
    "axes.formatter.useoffset": False,
    "axes.formatter.limits": (-5, 7),
    "xtick.direction": "in",
    "ytick.direction": "in",
    "xtick.top": True,
    "ytick.right": True,
    "xtick.major.width": 0.5,
    "ytick.major.width": 0.5,
    "xtick.major.size": 2.5,
    "ytick.major.size": 2.5,
    "lines.linewidth": THIN,
    "hatch.linewidth": THIN,
    "lines.solid_joinstyle": "round",
    "savefig.dpi": 300,
    "figure.dpi": 300,
    "agg.path.chunksize": 20000,
    "pdf.fonttype": 42,  # TrueType, as journals ask
    "ps.fonttype": 42,
    "svg.fonttype": "none",  # text: an editor and a search find the words
    "svg.hashsalt": "vibsim",  # the same ids in every run: pictures can be compared
}


@contextmanager
def applied() -> Iterator[None]:
    """Draw and save under these settings, whatever the user's matplotlibrc says."""
    with matplotlib.rc_context(), warnings.catch_warnings():
        warnings.filterwarnings("ignore", "Glyph .* missing from font")  # a title in such signs shows boxes
        matplotlib.rcdefaults()
        matplotlib.rcParams.update(SETTINGS)
        yield


def overlay(index: int) -> dict[str, Any]:
    """Colour of the subject number `index` in a picture of several; solid, as in the legend."""
    return {"color": _COLOURS[index % len(_COLOURS)]}


def nested(index: int, count: int, narrowest: float = THIN) -> dict[str, Any]:
    """Colour and width of one of `count` lines that may run into one another.

    The first is the widest: where lines coincide, each shows as a rim of the next.
    """
    step = min(STEP, (WIDEST - narrowest) / max(count - 1, 1))
    return {**overlay(index), "linewidth": narrowest + step * (count - 1 - index)}
