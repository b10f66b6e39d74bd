"""The figures of the paper: what each shows, of which runs, and how it is laid out.

Figs. 1 and 3 are sketches of the two models and are not drawn again. Figures 9 and 10, 15 and 16 are drawn a
second time, from the readings of the parameters under which the paper's account of them holds.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

from matplotlib.figure import Figure

from vibsim.evidence.reports.figures.layouts import (
    draw_displacements,
    draw_growth,
    draw_motors,
    draw_passage,
    draw_portraits,
    draw_stiffness,
)
from vibsim.plots.page.sheet import sheet
from vibsim.plots.subject import Subject
from vibsim.plots.view import View

LETTERS = "ABC"
HERTZ = {"A": "3.5", "B": "5.5", "C": "6.5"}
READINGS = {"B": "II-B-captured", "C": "II-C-escape"}
PAGE_CM = 17.8

# keys as on the page with all figures: A, B and C side by side
PAGE_ROWS = (
    ("fig-02", "fig-04"),
    ("fig-05", "fig-06", "fig-07"),
    ("fig-08", "fig-09", "fig-10"),
    ("", "fig-09-reading", "fig-10-reading"),
    ("fig-11", "fig-12", "fig-13"),
    ("fig-14", "fig-15", "fig-16"),
    ("", "fig-15-reading", "fig-16-reading"),
)


@dataclass(frozen=True)
class PaperFigure:
    """One figure.

    Attributes
    ----------
    key : file name without suffix, such as "fig-05"
    heading : "Fig. 5"
    caption : one sentence, as under a figure
    alt : what is to be seen, in words, for those who do not see it
    runs : names of the cases shown, in their order
    height_cm : at the width of a page
    draw : draws it on an empty sheet
    """

    key: str
    heading: str
    caption: str
    alt: str
    runs: tuple[str, ...]
    height_cm: float
    draw: Callable[[Figure, Sequence[Subject]], None]

    def figure(self, subjects: Mapping[str, Subject]) -> Figure:
        """It, drawn; call under `vibsim.plots.style.applied()`."""
        empty = sheet(View(width="page"), self.height_cm)
        self.draw(empty, [subjects[name] for name in self.runs])
        return empty


def paper_figures() -> list[PaperFigure]:
    """All of them, in the order of the paper."""
    return [
        _stiffness(),
        _motors(),
        *(_displacements_ideal(letter) for letter in LETTERS),
        *(_displacements_motor(letter) for letter in LETTERS),
        *(_displacements_reading(letter) for letter in READINGS),
        *(_portraits(letter) for letter in LETTERS),
        *(_passage(letter) for letter in LETTERS),
        *(_passage_reading(letter) for letter in READINGS),
    ]


def growth_figure() -> PaperFigure:
    """Why one motor stays and the other leaves; no figure of the paper."""
    return PaperFigure(
        "growth",
        "Growth",
        "How far the vibration has grown, in the two readings: the greatest x1 − x2 in each second.",
        "Two rising curves that start together. That of II-C-escape is the higher one until the motor "
        "escapes, then falls; that of II-B-captured goes on and levels off.",
        tuple(READINGS.values()),
        5.6,
        draw_growth,
    )


def _stiffness() -> PaperFigure:
    return PaperFigure(
        "fig-02",
        "Fig. 2",
        "Stiffness: force of the two springs against the relative displacement.",
        "A line of slope k1 that turns steeper, to slope k1 + k2, where x1 - x2 falls below -G = -1 mm.",
        ("I-A",),
        6.0,
        draw_stiffness,
    )


def _motors() -> PaperFigure:
    return PaperFigure(
        "fig-04",
        "Fig. 4",
        "Characteristics of the motor: torque against speed, for the three motor constants. Filled points: "
        "where each motor runs in the end; square: where it is held on the way; open circles: no load.",
        "Three straight lines that fall from 5 mN m at standstill to zero at 3.5, 5.5 and 6.5 Hz, each with "
        "an operating point near its lower end; the line of 5.5 Hz has a square at 3.7 Hz as well.",
        ("II-A", "II-B", "II-C"),
        6.0,
        draw_motors,
    )


def _displacements_ideal(letter: str) -> PaperFigure:
    number = 5 + LETTERS.index(letter)
    return PaperFigure(
        f"fig-{number:02}",
        f"Fig. {number}",
        f"Case I-{letter}, ideal source at {HERTZ[letter]} Hz: (a) displacements over 300 s, (b) a detail "
        "with impacts (contact shaded); above with the amplitude of Table 1, below with that of Eq. (2.11).",
        "Four panels. Left: x1 and x2 against time over 300 s, x1 a band that vibrates about the drifting "
        f"x2; right: about ten periods with each impact marked. Ideal source, {HERTZ[letter]} Hz.",
        (f"I-{letter}", f"I-{letter}-eq211"),
        11.0,
        draw_displacements,
    )


def _displacements_motor(letter: str) -> PaperFigure:
    number = 8 + LETTERS.index(letter)
    return PaperFigure(
        f"fig-{number:02}",
        f"Fig. {number}",
        f"Case II-{letter}, motor constant {HERTZ[letter]} Hz: (a) displacements over 300 s, (b) a detail "
        "with impacts.",
        "Two panels: x1 and x2 against time over 300 s, and about ten turns of the motor with each impact "
        f"marked. Motor constant {HERTZ[letter]} Hz, printed parameters.",
        (f"II-{letter}",),
        5.6,
        draw_displacements,
    )


def _displacements_reading(letter: str) -> PaperFigure:
    number = 8 + LETTERS.index(letter)
    return PaperFigure(
        f"fig-{number:02}-reading",
        f"Fig. {number}, reading",
        f"The same from {READINGS[letter]}, the reading under which the account of II-{letter} holds.",
        "Two panels: x1 and x2 against time over 300 s, and a detail with impacts, for the case "
        f"{READINGS[letter]}.",
        (READINGS[letter],),
        5.6,
        draw_displacements,
    )


def _portraits(letter: str) -> PaperFigure:
    number = 11 + LETTERS.index(letter)
    return PaperFigure(
        f"fig-{number}",
        f"Fig. {number}",
        f"Phase portraits at {HERTZ[letter]} Hz, the last periods: (a) ideal source, with the amplitude of "
        "Table 1 and with that of Eq. (2.11); (b) motor. Blocks 1 and 2, and at the right their relative "
        "motion, which no drift smears.",
        "Nine panels of velocity against displacement: rows for I as printed, I with equal force, and II; "
        "columns for blocks 1 and 2 and for x1 − x2.",
        (f"I-{letter}", f"I-{letter}-eq211", f"II-{letter}"),
        14.5,
        draw_portraits,
    )


def _passage(letter: str) -> PaperFigure:
    number = 14 + LETTERS.index(letter)
    return PaperFigure(
        f"fig-{number}",
        f"Fig. {number}",
        f"Case II-{letter}: (a) motor speed against time, (b) displacements against motor frequency.",
        "Left: motor speed over 300 s with the levels of the natural frequencies; right: x1 and x2 against "
        f"the speed of the motor. Motor constant {HERTZ[letter]} Hz, printed parameters.",
        (f"II-{letter}",),
        7.8,
        draw_passage,
    )


def _passage_reading(letter: str) -> PaperFigure:
    number = 14 + LETTERS.index(letter)
    return PaperFigure(
        f"fig-{number}-reading",
        f"Fig. {number}, reading",
        f"The same from {READINGS[letter]}, the reading under which the account of II-{letter} holds.",
        "Left: motor speed over 300 s with the levels of the natural frequencies; right: x1 and x2 against "
        f"the speed of the motor. Case {READINGS[letter]}.",
        (READINGS[letter],),
        7.8,
        draw_passage,
    )
