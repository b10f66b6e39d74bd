"""The figures of the paper: what each shows, of which runs, and how it is laid out.

Figs. 1 and 3, the sketches of the two models, are drawn from the cases. Figures 9 and 10, 15 and 16 are drawn
a second time, from the readings of the parameters under which the paper's account of them holds.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from math import pi
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure, SubFigure
from matplotlib.patches import Rectangle
from matplotlib.ticker import MaxNLocator

from vibsim.analysis import judge_capture
from vibsim.cases import load_case
from vibsim.evidence.reports.claims import hz, words_of
from vibsim.evidence.reports.measurements import (
    MOTORS,
)
from vibsim.evidence.reports.pages import PageTable
from vibsim.orbits.branches.branch import Branch
from vibsim.plots.branch_curves import draw_branches
from vibsim.plots.frequency_pictures import displacement_frequency_panels
from vibsim.plots.load_curves import LOAD_CURVE_MARKED, LoadCurve, MotorLine, load_curve_panel, motor_panel
from vibsim.plots.machine import machine_panel, machine_size
from vibsim.plots.overview import stiffness_panel
from vibsim.plots.portraits import moving, phase_panels, relative_panel
from vibsim.plots.samples import common_window, detail_span, motor_of, natural_frequencies, window_of
from vibsim.plots.sheet import Scale, legend_above, legend_below, letter_panels, sheet, time_axis
from vibsim.plots.slow_passages import power_panels
from vibsim.plots.style import GREY, overlay
from vibsim.plots.subject import Subject, View
from vibsim.plots.time_histories import DISPLACEMENT, SPEED, Panel, curve_groups, histories, motor_speed_panel
from vibsim.plots.traces import mark_detail

LETTERS = "ABC"
HERTZ = {"A": "3.5", "B": "5.5", "C": "6.5"}
READINGS = {"B": "II-B-captured", "C": "II-C-escape"}
PAGE_CM = 17.8

# keys as on the page with all figures: A, B and C side by side
PAGE_ROWS = (
    ("fig-01", "fig-02"),
    ("fig-03", "fig-04"),
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
        _sketch("fig-01", "I-A", "ideal"),
        PaperFigure(
            "fig-02",
            "Fig. 2",
            "Stiffness: force of the two springs against the relative displacement (solid); dashed: where "
            "the stop is met.",
            "A line of slope k1 that turns steeper, to slope k1 + k2, where x1 - x2 falls below -G = -1 mm.",
            ("I-A",),
            6.0,
            draw_stiffness,
        ),
        _sketch("fig-03", "II-A", "non-ideal"),
        PaperFigure(
            "fig-04",
            "Fig. 4",
            "Characteristics of the motor: torque against speed, for the three motor constants. Filled "
            "points: where each motor runs in the end; square: where it is held on the way; open circles: "
            "no load.",
            "Three straight lines that fall from 5 mN m at standstill to zero at 3.5, 5.5 and 6.5 Hz, each "
            "with an operating point near its lower end; the line of 5.5 Hz has a square at 3.7 Hz as well.",
            ("II-A", "II-B", "II-C"),
            6.0,
            draw_motors,
        ),
        *_of_letters(
            5,
            "Case I-{letter}, ideal source at {hz} Hz: (a) displacements over 300 s, (b) a detail with each "
            "impact as a ring and contact shaded grey. The frame in (a) is what (b) enlarges, the ticks at "
            "its foot are impacts. Above with the amplitude of Table 1, below with that of Eq. (2.11).",
            "Four panels. Left: x1 and x2 against time over 300 s, x1 a band that vibrates about the "
            "drifting x2; right: about ten periods with each impact marked. Ideal source, {hz} Hz.",
            ("I-{letter}", "I-{letter}-eq211"),
            11.0,
            draw_displacements,
        ),
        *_of_letters(
            8,
            "Case II-{letter}, motor constant {hz} Hz: (a) displacements over 300 s, (b) a detail "
            "with each impact as a ring and contact shaded grey. The frame in (a) is what (b) enlarges, the "
            "ticks at its foot are impacts.",
            "Two panels: x1 and x2 against time over 300 s, and about ten turns of the motor with each "
            "impact marked. Motor constant {hz} Hz, printed parameters.",
            ("II-{letter}",),
            5.6,
            draw_displacements,
        ),
        *_of_letters(
            8,
            "The same from {reading}, the reading under which the account of II-{letter} holds; rings, "
            "shades, frame and ticks as there.",
            "Two panels: x1 and x2 against time over 300 s, and a detail with impacts, for the case "
            "{reading}.",
            ("{reading}",),
            5.6,
            draw_displacements,
            letters=READINGS,
        ),
        *_of_letters(
            11,
            "Phase portraits at {hz} Hz, the last periods: (a) ideal source, with the amplitude of "
            "Table 1 and with that of Eq. (2.11); (b) motor. Blocks 1 and 2, and at the right their relative "
            "motion, which no drift smears. Black dots or rings: impacts; dashed: where the stop is met.",
            "Nine panels of velocity against displacement: rows for I as printed, I with equal force, and "
            "II; columns for blocks 1 and 2 and for x1 − x2.",
            ("I-{letter}", "I-{letter}-eq211", "II-{letter}"),
            14.5,
            draw_portraits,
        ),
        *_of_letters(
            14,
            "Case II-{letter}: (a) motor speed against time, pale at every instant, dark the mean of 12 "
            "turns; solid level: no-load speed, dashed levels: natural frequencies, the bilinear one and "
            "its half; (b) displacements against motor frequency, pale, and on them the least and the "
            "greatest of every turn as dots, coloured by time.",
            "Left: motor speed over 300 s with the levels of the natural frequencies; right: x1 and x2 "
            "against the speed of the motor. Motor constant {hz} Hz, printed parameters.",
            ("II-{letter}",),
            7.8,
            draw_passage,
        ),
        *_of_letters(
            14,
            "The same from {reading}, the reading under which the account of II-{letter} holds; lines, "
            "levels and colours as there.",
            "Left: motor speed over 300 s with the levels of the natural frequencies; right: x1 and x2 "
            "against the speed of the motor. Case {reading}.",
            ("{reading}",),
            7.8,
            draw_passage,
            letters=READINGS,
        ),
    ]


def growth_figure() -> PaperFigure:
    """Growth of the vibration, by which one motor stays and the other leaves; no figure of the paper."""
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


def powers_figure() -> PaperFigure:
    """Power of the motors and what takes it; no figure of the paper."""
    return PaperFigure(
        "powers",
        "Powers",
        "Power over time in the two readings, each point the mean of whole turns: what the motor gives "
        "(black), what damper and friction take (dashed, as the legend has them), and what goes into motion "
        "and springs (pale; below 0 it comes back). What is given is what is taken and stored.",
        "Two panels of power over time. In both the motor first sets itself and the blocks in motion; then "
        "damper and friction take more and more. In that of II-C-escape they take less again behind its "
        "escape.",
        tuple(READINGS.values()),
        6.4,
        draw_powers,
    )


def _sketch(key: str, name: str, source: str) -> PaperFigure:
    case = load_case(name)
    machine = "the force of the source on block 1" if source == "ideal" else "the unbalanced rotor on block 1"
    return PaperFigure(
        key,
        f"Fig. {int(key[-2:])}",
        f"The model with the {source} source, drawn from case {name}: blocks 1 and 2 with their masses, the "
        "spring k1 (blue coil) and the damper c (green) between them, the stop of stiffness k2 (orange) that "
        "is met when the blocks have come nearer by the gap G, dry friction (orange line on hatches) under "
        f"block 2, and {machine}; the arrow x is the positive direction.",
        f"Two boxes side by side joined by a spring, a damper and a stop; {machine}; the second box stands "
        "on a hatched floor.",
        (name,),
        machine_size(case.long_values())[1],
        draw_sketch,
    )


def _of_letters(
    number: int,
    caption: str,
    alt: str,
    runs: Sequence[str],
    height_cm: float,
    draw: Callable[[Figure, Sequence[Subject]], None],
    letters: Iterable[str] = LETTERS,
) -> Iterator[PaperFigure]:
    """A figure of each of the cases A, B and C, that of A with a number; or of those that have a reading.

    caption, alt, runs : with {letter}, {hz} and {reading} where that of the case belongs
    """
    key, heading = ("-reading", ", reading") if letters is READINGS else ("", "")
    for letter in letters:
        own = {"letter": letter, "hz": HERTZ[letter], "reading": READINGS.get(letter)}
        place = number + LETTERS.index(letter)
        yield PaperFigure(
            f"fig-{place:02}{key}",
            f"Fig. {place}{heading}",
            caption.format(**own),
            alt.format(**own),
            tuple(run.format(**own) for run in runs),
            height_cm,
            draw,
        )


# How the paper lays out its figures, from the panels of `vibsim.plots`.


WHOLE = View()
NARROW = 0.55  # width of a lone characteristic, of the page
SECOND = 1.0  # [s] in which the greatest x1 - x2 is looked for: several vibrations of every motor


def draw_sketch(sheet: Figure, subjects: Sequence[Subject]) -> None:
    """The machine, to scale, in the middle of the sheet."""
    machine_panel(sheet.subplots(), subjects[0].case.long_values())


def draw_powers(sheet: Figure, subjects: Sequence[Subject]) -> None:
    """Powers over time, the runs side by side."""
    panels = list(sheet.subplots(1, len(subjects), squeeze=False, sharey=True)[0])
    power_panels(panels, subjects, [window_of(subject, None) for subject in subjects])
    for axes in panels[1:]:
        axes.set_ylabel("")
    legend_below(sheet, *panels[0].get_legend_handles_labels())
    letter_panels(panels)


def draw_stiffness(sheet: Figure, subjects: Sequence[Subject]) -> None:
    """Spring force against x1 - x2."""
    stiffness_panel(_centred(sheet), subjects[:1])


def draw_motors(sheet: Figure, subjects: Sequence[Subject]) -> None:
    """Torque against speed of several motors, and where each of them runs: in the end, and while held."""
    axes = _centred(sheet)
    motor_panel(axes, subjects)
    for i, subject in enumerate(subjects):
        capture, colour = judge_capture(subject.result), overlay(i)["color"]
        if capture.final_speed_hz is not None:
            place = _layouts_point(subject, capture.final_speed_hz)
            axes.plot(*place, "o", color=colour, markersize=4.5, gid="final")
        if capture.until is not None and capture.speed_hz is not None:
            axes.plot(
                *_layouts_point(subject, capture.speed_hz), "s", color=colour, markersize=4,
                markerfacecolor="white",
                gid="held",
            )  # fmt: skip


def _layouts_point(subject: Subject, speed_hz: float) -> tuple[float, float]:
    """Mean speed [Hz] and torque [mN m]: the torque is linear in the speed, and so are their means."""
    motor = motor_of(subject.scene)
    return speed_hz, 1e3 * motor.M0 * (1 - 2 * np.pi * speed_hz / motor.Omega0)


def draw_displacements(sheet: Figure, subjects: Sequence[Subject]) -> None:
    """A row for each run: displacements of both blocks, and a detail with impacts."""
    rows = sheet.subfigures(len(subjects), 1, squeeze=False)[:, 0]
    for row, subject in zip(rows, subjects, strict=True):
        _title(row, subject)
        whole, detail = row.subplots(1, 2, gridspec_kw={"width_ratios": (1.5, 1)})
        span = detail_span([subject], WHOLE)
        curves = curve_groups([subject], DISPLACEMENT)[0]
        window = common_window([subject], None)
        histories([Panel(whole, curves, window), Panel(detail, curves, span)], DISPLACEMENT)
        mark_detail(whole, span)
        legend_above(whole)
        letter_panels([whole, detail])


def draw_portraits(sheet: Figure, subjects: Sequence[Subject]) -> None:
    """A row for each run: portraits of blocks 1 and 2, and of their relative motion, free of drift."""
    rows = sheet.subfigures(len(subjects), 1, squeeze=False)[:, 0]
    for row, subject in zip(rows, subjects, strict=True):
        mark = "(b)" if subject.scene.has_motor else "(a)"
        row.suptitle(f"{mark} {subject.name}: {subject.case.title}", x=0.01, ha="left", fontsize=8)
        panels: Any = row.subplots(1, 3)
        phase_panels(panels[:2], [subject], WHOLE, moving([subject]))
        relative_panel(panels[2], [subject], WHOLE)
        panels[2].set_xlabel(panels[2].get_xlabel().removeprefix("Relative displacement "))
        panels[2].set_ylabel(panels[2].get_ylabel().removeprefix("Relative velocity "))
        for axes in panels:
            axes.xaxis.set_major_locator(MaxNLocator(4, steps=[1, 2, 5, 10]))


def draw_passage(sheet: Figure, subjects: Sequence[Subject]) -> None:
    """Motor speed against time, beside the displacements against the motor's speed."""
    _title(sheet, subjects[0])
    left, right = sheet.subfigures(1, 2, width_ratios=(1.25, 1), squeeze=False)[0]
    speed = left.subplots()
    motor_speed_panel(speed, subjects, WHOLE, height_cm=7.0)
    legend_above(speed)
    panels = right.subplots(2, 1, sharex=True)
    shown = displacement_frequency_panels(panels, subjects, WHOLE, moving(subjects))
    if shown is not None:
        right.colorbar(shown, ax=list(panels), label="Time (s)", pad=0.02, aspect=40)
    panels[-1].set_xlabel(f"Motor speed {SPEED} (Hz)")
    for axes in panels:
        axes.set_ylabel(axes.get_ylabel().removeprefix("Displacement "))
    letter_panels([speed, panels[0]])
    right.align_ylabels()


def draw_growth(sheet: Figure, subjects: Sequence[Subject]) -> None:
    """Greatest x1 - x2 in each second [mm] against time, of several runs."""
    axes = sheet.subplots()
    for i, subject in enumerate(subjects):
        t, reach = reach_by_second(subject.result)
        axes.plot(t, 1e3 * reach, label=subject.name, linewidth=1.0, gid="reach", **overlay(i))
    axes.set_ylim(bottom=0)
    axes.set_ylabel("Greatest $x_1 - x_2$ (mm)")
    time_axis(axes, common_window(subjects, None))
    legend_above(axes)


def reach_by_second(result: Any) -> tuple[np.ndarray, np.ndarray]:
    """Middle of each whole second of a run [s], and the greatest x1 - x2 of its samples [m]."""
    time, y = result["time"], result["x1"] - result["x2"]
    edges = np.arange(time[0], time[-1] + SECOND / 2, SECOND)
    starts = np.searchsorted(time, edges[:-1])
    return (edges[:-1] + edges[1:]) / 2, np.maximum.reduceat(y, starts)


def _centred(sheet: Figure) -> Axes:
    """Axes in the middle of the sheet."""
    side = (1 - NARROW) / 2
    axes: Axes = sheet.subfigures(1, 3, width_ratios=(side, NARROW, side), squeeze=False)[0, 1].subplots()
    return axes


def _title(sheet: Figure | SubFigure, subject: Subject) -> None:
    known = " (true motion)" if "comment" in subject.result.attrs else ""  # the caption says how it was had
    sheet.suptitle(f"{subject.name}: {subject.title}{known}", x=0.01, ha="left", fontsize=8)


# Load curves of the motors, as printed and in the readings.


DRAWN = ("as printed", "the reading")
HEIGHT_CM = 8.0


def draw_load_curves(branches: Mapping[str, Branch]) -> Figure:
    """Both load curves, with the lines of the paper's three motors."""
    figure = sheet(View(width="page"), HEIGHT_CM)
    subjects = [Subject(f"{name}.h5", name, "branch", branches[name].case, branches[name]) for name in DRAWN]
    axes = figure.subplots()
    load_curve_panel(figure, axes, subjects, View(width="page"), no_load_speeds())
    _enlarge(axes, subjects)
    return figure


INSET = (0.56, 0.52, 0.33, 0.40)  # place of the enlargement, in shares of the axes
ABOUT = 0.03  # share of half the bilinear frequency that it reaches to either side


def _enlarge(axes: Axes, subjects: Sequence[Subject]) -> None:
    """Enlarge the load curves about half the bilinear frequency, where they rise and turn back."""
    (half,) = [f.hz for f in natural_frequencies(subjects[0].scene) if f.name == "half bilinear"]
    inset = axes.inset_axes(INSET, gid="inset")
    scale = Scale(1e3, "mN m")
    curves = [LoadCurve(subject.result, scale) for subject in subjects]
    draw_branches(inset, subjects, [(curve.speed, curve.torque) for curve in curves], LOAD_CURVE_MARKED)
    inset.set_xlim(half * (1 - ABOUT), half * (1 + ABOUT))
    inset.set_ylim(axes.get_ylim()[0], max(y for curve in curves for _, y in curve.places()) * 1.05)
    stall = 1e3 * motor_of(subjects[0].scene).M0
    for speed in no_load_speeds():
        MotorLine(speed, stall).draw(inset)
    inset.axvline(half, color=GREY, linewidth=0.6, linestyle=(0, (4, 2)), zorder=1, gid="half bilinear")
    inset.set_title(f"about ½ bilinear, {half:.2f} Hz", fontsize=6.5, pad=2)
    inset.tick_params(labelsize=6)
    x, y = inset.get_xlim(), inset.get_ylim()
    frame: dict[str, Any] = {
        "edgecolor": "0.2",
        "linewidth": 0.7,
        "linestyle": ":",
        "zorder": 4,
        "gid": "inset-frame",
    }
    axes.add_patch(Rectangle((x[0], y[0]), x[1] - x[0], y[1] - y[0], fill=False, **frame))


def no_load_speeds() -> list[float]:
    """Of the paper's motors [Hz]."""
    motors = [load_case(name).scene().motor for name in MOTORS]
    return [motor.Omega0 / (2 * pi) for motor in motors if motor is not None]


def ends_table(ends: Mapping[str, Any]) -> PageTable:
    """Greatest no-load speeds of held orbits, for every combination of the two numbers."""
    kinds = {"fold": "fold", "neimark-sacker": "Neimark–Sacker point before the fold"}
    rows = tuple(
        (
            name,
            f"{end['no_load_hz']:.4f} Hz",
            f"{end['speed_hz']:.3f} Hz",
            f"{1e3 * end['torque']:.2f} mN m",
            kinds.get(end["kind"], end["kind"]),
        )
        for name, end in ends.items()
    )
    columns = ("II with", "Held up to a no-load speed of", "Mean speed there", "Torque taken", "Ends in")
    return PageTable("Where orbits held near half the bilinear frequency end", columns, rows)


def load_words(ends: Mapping[str, Any]) -> str:
    """Conclusions from the load curves on the motors of 5.5 and 6.5 Hz, in words."""
    printed, reading = (ends[name] for name in DRAWN)
    return (
        "A motor can run where its line meets the curve of the torque that the vibration takes. Orbits held "
        "near half the bilinear frequency end where that curve turns back: beyond, no line meets it, and the "
        "motor leaves along its own. As printed there are such orbits up to a no-load speed of "
        f"{hz(printed['no_load_hz'])}, where the vibration takes {1e3 * printed['torque']:.2f} mN m: "
        f"{_held(printed)}. In the reading there are such orbits up to {reading['no_load_hz']:.3f} Hz: "
        f"{_held(reading)}. This bounds what any start can come to; whether a motor is caught where it can "
        "be held depends on the start."
    )


def _held(end: Mapping[str, Any]) -> str:
    """Sentence on which of the two faster motors can be held."""
    faster = no_load_speeds()[1:]
    held = [f"{speed:g} Hz" for speed in faster if speed <= end["no_load_hz"]]
    lost = [f"{speed:g} Hz" for speed in faster if speed > end["no_load_hz"]]
    if not held:
        return f"they hold neither the motor of {' nor that of '.join(lost)}"
    return f"they can hold the motor of {words_of(held)}" + (
        f", not that of {words_of(lost)}" if lost else ""
    )
