"""The look of every picture: 8 pt, thin lines, colours that survive colour blindness and grey print."""

from __future__ import annotations

import logging
import warnings
from collections.abc import Iterator
from contextlib import contextmanager
from os import PathLike, fspath
from os.path import exists, isfile
from pathlib import Path
from typing import Any

import matplotlib

from vibsim.plots.subject import PlotError
from vibsim.results.hdf5_reading import reason

# Okabe and Ito, "Color Universal Design" (2008), dark and light in turn: they print in different greys.
BLUE, ORANGE, BLACK, SKY, VERMILLION, PINK, GREEN = (
    "#0072B2", "#E69F00", "#000000", "#56B4E9", "#D55E00", "#CC79A7", "#009E73",
)  # fmt: skip
YELLOW = "#F0E442"  # of theirs too, for areas alone
PALE = "#A9D7F2"  # SKY half way to white, for areas alone
GREY = "0.45"
SHADE = "0.90"


_COLOURS = (BLUE, ORANGE, BLACK, SKY, VERMILLION, PINK, GREEN)

# of lines and points that share a panel, in turn with the colours: without them, and where lines coincide
DASHES: tuple[Any, ...] = (
    "-", (0, (6, 2)), (0, (1.5, 1.5)), (0, (6, 1.5, 1.5, 1.5)), (0, (3, 1.5)), (0, (9, 3)),
    (0, (6, 1.5, 1.5, 1.5, 1.5, 1.5)),
)  # fmt: skip
MARKERS = ("o", "s", "^", "D", "v", "P", "X")

THIN = 0.6  # line width of data [pt]
FEW, LARGEST_PT, SMALLEST_PT = 60, 3.0, 1.4  # points of a panel that are drawn large; sizes
STEP, WIDEST = 0.8, 2.6  # by how much the lines of several files differ in width, and the widest [pt]

SHEET = Path(__file__).with_name("house.mplstyle")
SETTINGS: Any = dict(matplotlib.rc_params_from_file(SHEET, use_default_template=False))
FONTS = [
    *("font.size", "axes.titlesize", "axes.labelsize", "xtick.labelsize", "ytick.labelsize"),
    "legend.fontsize",
]


@contextmanager
def applied(sheet: str | PathLike[str] | bool = True, font_size: float | None = None) -> Iterator[None]:
    """Draw and save under these settings, whatever the user's matplotlibrc says.

    sheet : a matplotlib style sheet (its file or name) laid over them; False: the settings in force instead
    font_size : size of the text [pt]; all other sizes of text keep their ratio to it

    Raises PlotError for a style sheet that matplotlib does not read.
    """
    with _settings_given_back(), warnings.catch_warnings():
        warnings.filterwarnings("ignore", "Glyph .* missing from font")  # a title in such signs shows boxes
        _list_own_fonts()
        if sheet is not False:
            matplotlib.rcdefaults()
            matplotlib.rcParams.update(SETTINGS)
        if not isinstance(sheet, bool):
            _lay_over(sheet)
        if font_size is not None:
            factor = font_size / float(SETTINGS["font.size"])
            sizes: Any = {name: SETTINGS[name] * factor for name in FONTS}
            matplotlib.rcParams.update(sizes)
        yield


@contextmanager
def _settings_given_back() -> Iterator[None]:
    """Give matplotlib's settings back behind it, but for whether it is interactive.

    A notebook's backend, which the first figure loads, turns that on; without it no later figure is shown.
    """
    interactive = matplotlib.is_interactive()
    try:
        with matplotlib.rc_context():
            try:
                yield
            finally:
                interactive = matplotlib.is_interactive()
    finally:
        matplotlib.interactive(interactive)


def _list_own_fonts() -> None:
    """Add to matplotlib's list of fonts those of its own that it lacks.

    The list is a file among the user's. One that was written while matplotlib was being removed or installed
    lacks them for good: pictures are then drawn in other fonts, and each says so in some 20 lines.
    """
    from matplotlib import font_manager

    fonts = font_manager.fontManager
    own = {str(path) for path in Path(matplotlib.get_data_path(), "fonts").rglob("*.[at][ft][mf]")}
    for path in sorted(own - {font.fname for font in [*fonts.ttflist, *fonts.afmlist]}):
        fonts.addfont(path)


def _lay_over(sheet: str | PathLike[str]) -> None:
    """Lay a style sheet over the settings in force."""
    from matplotlib import style

    complaints: list[str] = []
    try:
        with _complaints_of_matplotlib(complaints), warnings.catch_warnings():
            warnings.simplefilter("ignore")  # of keys that this matplotlib has given up
            if isfile(sheet):
                open(sheet).close()  # of one that must not be read matplotlib says only that it is no style
            style.use(fspath(sheet))
    except (OSError, ValueError, UnicodeDecodeError) as error:
        if not exists(sheet) and sheet not in style.library:
            raise PlotError(f"{sheet}: must be a file, or a style of matplotlib such as ggplot") from None
        raise PlotError(f"{sheet} is no style sheet of matplotlib: {reason(error):.120}") from None
    if complaints:
        raise PlotError(f"{sheet} is no style sheet of matplotlib: {complaints[0]:.160}")


@contextmanager
def _complaints_of_matplotlib(complaints: list[str]) -> Iterator[None]:
    """Collect the first lines of what matplotlib logs of keys and values that it leaves out, in silence."""

    def collected(record: logging.LogRecord) -> bool:
        complaints.append(record.getMessage().strip().partition("\n")[0])
        return False

    log = logging.getLogger("matplotlib")
    log.addFilter(collected)
    try:
        yield
    finally:
        log.removeFilter(collected)


def points(size: float) -> float:
    """A size of text [pt] as it is in vibsim's own 8 pt, at the size in force."""
    return size * float(matplotlib.rcParams["font.size"]) / float(SETTINGS["font.size"])


def overlay(index: int) -> dict[str, Any]:
    """Colour of the subject number `index` in a picture of several; solid, as in the legend."""
    return {"color": _COLOURS[index % len(_COLOURS)]}


def dashed(index: int) -> dict[str, Any]:
    """Colour and dashes of line number `index` of one run: told apart in grey print, and where one lies upon
    another, which shows through its gaps. Where the colours begin again the dashes do not: 49 lines differ.
    """
    return {**overlay(index), "linestyle": DASHES[(index + index // len(_COLOURS)) % len(DASHES)]}


def dot_size(count: int) -> float:
    """Diameter of each of `count` points of a panel [pt]: few are large enough to be found."""
    return float(min(max(LARGEST_PT * (FEW / max(count, 1)) ** 0.5, SMALLEST_PT), LARGEST_PT))


def nested(index: int, count: int, narrowest: float = THIN) -> dict[str, Any]:
    """Colour and width of one of `count` lines that may run into one another.

    The first is the widest: where lines coincide, each shows as a rim of the next.
    """
    step = min(STEP, (WIDEST - narrowest) / max(count - 1, 1))
    return {**overlay(index), "linewidth": narrowest + step * (count - 1 - index)}
