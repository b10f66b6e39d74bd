"""The figures as files: one for each, and one page with all of the paper's."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.figure import Figure
from matplotlib.image import imread

from vibsim.branches.branch import Branch
from vibsim.evidence.reports.figures.evidence_figures import draw_capture, draw_drift, draw_regimes
from vibsim.evidence.reports.figures.paper_figures import PAGE_CM, PAGE_ROWS, PaperFigure
from vibsim.evidence.reports.figures.search_figure import draw_search
from vibsim.evidence.reports.load_curves import draw_load_curves
from vibsim.evidence.reports.measured.measurements import Numbers
from vibsim.evidence.reports.measured.paper_numbers import Tell
from vibsim.evidence.reports.measured.paper_runs import READINGS, Interrupted
from vibsim.evidence.reports.measured.regimes_nearby import STARTS
from vibsim.evidence.reports.pages.document import Picture
from vibsim.files.output_file import output_file
from vibsim.plots.page.sheet import CM
from vibsim.plots.picture import DPI, drawn
from vibsim.plots.subject import Subject

FORMATS = ("png", "pdf")
PNG_DPI = 200  # a figure is then 1400 pixels wide: sharp on a screen, and the report stays a few megabytes
HEADING_CM = 0.7


def write_figures(
    figures: Sequence[PaperFigure],
    subjects: Mapping[str, Subject],
    folder: Path,
    formats: Sequence[str],
    tell: Tell,
) -> list[Picture]:
    """Draw each figure into FOLDER/KEY.FORMAT; the PNGs as pictures. Raises Interrupted."""
    pictures = []
    for done, figure in enumerate(figures, start=1):
        path = save(figure.figure(subjects), folder / figure.key, formats)
        known = known_from([subjects[name] for name in figure.runs])
        pictures.append(Picture(path, figure.heading, f"{figure.caption}{known}", figure.alt))
        if not tell("drawing", done, len(figures)):
            raise Interrupted
    return pictures


def known_from(subjects: Sequence[Subject]) -> str:
    """How the motions shown were had, a sentence each, where they were not simply run."""
    how = {subject.name: subject.result.attrs.get("comment") for subject in subjects}
    return "".join(f" {name}: {words}." for name, words in how.items() if words)


def write_page(pictures: Sequence[Picture], folder: Path, formats: Sequence[str]) -> Path:
    """All pictures of the paper's figures on one sheet, FOLDER/all-figures.FORMAT."""
    return save(page_of(pictures), folder / "all-figures", formats)


def write_search(numbers: Numbers, folder: Path, formats: Sequence[str]) -> Picture:
    """The map of the search, FOLDER/search.FORMAT."""
    changes = numbers["runs"][READINGS[0]]["changes"]
    J, c = ([float(text.split()[0]) for text in changes[key]] for key in ("J", "c"))
    reading, printed = ((1e3 * J[i], c[i]) for i in (0, 1))
    figure = draw_search(numbers["search"]["plane"], printed, reading)
    return Picture(
        save(figure, folder / "search", formats),
        "Search",
        "Quasi-random points over moment of inertia J and damping c, all else as printed: share of three "
        "starts from which II-B is captured for good (left), and from which II-C is held, gets away 67 to "
        "150 s after the start and ends at 6.1 to 6.3 Hz (right). Cross: as printed; ring: the two cases.",
        "Two maps over J and c. II-B is captured above a line that falls from left to right, towards smaller "
        "c at larger J. II-C does as said in a region of larger J and small c. The ring lies where the two "
        "meet, the cross far from either.",
    )


def write_load_curves(branches: Mapping[str, Branch], folder: Path, formats: Sequence[str]) -> Picture:
    """Why motors are held or not, FOLDER/load-curves.FORMAT."""
    return Picture(
        save(draw_load_curves(branches), folder / "load-curves", formats),
        "Load curves",
        "Fig. 4 completed: mean torque that the vibration takes against the mean speed, along the branch of "
        "orbits of one turn, for the motor as printed and for the reading; grey: the motors of 3.5, 5.5 and "
        "6.5 Hz. Dots: the motor stays there; half dots: it stays near, though that orbit is unstable; "
        "rings: it leaves.",
        "Two curves that rise steeply near 3.7 Hz and turn back. That of the printed motor turns back far "
        "below the lines of 5.5 and 6.5 Hz; that of the reading reaches just above the line of 5.5 Hz.",
    )


def write_evidence(numbers: Numbers, folder: Path, formats: Sequence[str]) -> dict[str, Picture]:
    """The pictures that decide claims, FOLDER/NAME.FORMAT, by name."""
    return {
        name: Picture(save(draw(numbers), folder / name, formats), heading, caption, alt)
        for name, (draw, heading, caption, alt) in EVIDENCE.items()
    }


EVIDENCE = {
    "regimes": (
        draw_regimes,
        "Regimes",
        f"Regime of the ideal source's motion between 150 and 300 s that most of {len(STARTS)} starts have "
        "(rest; x1 displaced by 0.6 and 1.2 mm to either side): rows for the law of the amplitude and the "
        "damping c in N s/m; white dots: the starts disagree; crosses: the shipped cases.",
        "Four rows of coloured cells over frequency. With the amplitude of Table 1 nearly all are periodic, "
        "those at 3.8 and 3.9 Hz chaotic; with that of Eq. (2.11) most are chaotic or transient.",
    ),
    "drift": (
        draw_drift,
        "Drift",
        "Rates of displacement of block 2 from 48 perturbed starts in each case (points), and from rest "
        "(rings): over the whole run, and in its second half; less than a micrometre per second is drawn at "
        "the lower edge.",
        "Two panels of point clouds on a logarithmic scale, nine cases side by side. II-A lies above I-A; "
        "the clouds of II-B and II-C are wide and overlap those of I-B and I-C; with equal force the ideal "
        "source is fastest overall.",
    ),
    "capture": (
        draw_capture,
        "Holds",
        "Left: mean speed of the motor while it is held, from 48 perturbed starts in each case; dashed: the "
        "paper's 4.1 Hz. Right: final speed against the time until which it is held, 300 s being the end; "
        "shaded: 67 to 150 s, and 6.0 to 6.4 Hz.",
        "Left: all clouds lie below the dashed line or far above it. Right: where the starts of each case "
        "end in time of release and final speed.",
    ),
}  # after the functions that they name


def save(figure: Figure, stem: Path, formats: Sequence[str]) -> Path:
    """Write a figure in each format, PNG always; the PNG's path."""
    for kind in dict.fromkeys(("png", *formats)):
        with output_file(f"{stem}.{kind}", force=True) as file:
            dpi = PNG_DPI if kind == "png" else DPI[f".{kind}"]
            file.write(drawn(figure, f".{kind}", dpi))
    return stem.with_name(f"{stem.name}.png")


def page_of(pictures: Sequence[Picture]) -> Figure:
    """A sheet with the pictures below their headings; A, B and C side by side."""
    by_key = {picture.path.stem: picture for picture in pictures}
    images = {key: _pixels(picture.path) for key, picture in by_key.items()}
    heights = [max(_height_cm(images[key]) for key in row if key) + HEADING_CM for row in PAGE_ROWS]
    columns, whole = max(map(len, PAGE_ROWS)), sum(heights)
    page = Figure(figsize=(columns * PAGE_CM * CM, whole * CM))
    top = whole
    for row, height in zip(PAGE_ROWS, heights, strict=True):
        for column, key in enumerate(row):
            if key:
                _place(page, images[key], by_key[key].heading, (column / columns, top / whole), whole)
        top -= height
    return page


def _place(page: Figure, image: Any, heading: str, corner: tuple[float, float], page_cm: float) -> None:
    """One picture below its heading; upper left corner in shares of the page's width and height."""
    left, top = corner
    middle = top - 0.45 * HEADING_CM / page_cm
    page.text(left + 0.004, middle, heading, fontsize=10, fontweight="bold", va="center")
    width = image.shape[1] / PNG_DPI / page.get_figwidth()
    height = _height_cm(image) / page_cm
    axes = page.add_axes((left, top - HEADING_CM / page_cm - height, width, height))
    axes.imshow(image, interpolation="none")
    axes.set_axis_off()


def _pixels(path: Path) -> Any:
    """Colours (height, width, 3) of an opaque PNG as bytes; matplotlib reads them as floats, with opacity."""
    return np.rint(255 * imread(path)[..., :3]).astype(np.uint8)


def _height_cm(image: Any) -> float:
    return float(image.shape[0] / PNG_DPI / CM)
