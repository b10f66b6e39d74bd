"""The figures of the report: the paper's, and those that decide a claim."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.colors import ListedColormap
from matplotlib.figure import Figure
from matplotlib.image import imread
from matplotlib.patches import Patch, Rectangle

from vibsim.cases import load_case
from vibsim.cases.quantities import parse_quantity
from vibsim.evidence.reports.claims import ABOUT_100, NATURAL_HZ, members
from vibsim.evidence.reports.claims import Numbers as claims_Numbers
from vibsim.evidence.reports.measurements import (
    EQUAL_FORCE,
    MOTORS,
    PRINTED,
    PRINTED_MOTOR,
    SHIPPED_READINGS,
    MeasurementInterrupted,
    Numbers,
    Tell,
)
from vibsim.evidence.reports.motor_claims import JUMPED_HZ
from vibsim.evidence.reports.pages import Picture
from vibsim.evidence.reports.paper_figures import PAGE_CM, PAGE_ROWS, PaperFigure, draw_load_curves
from vibsim.evidence.reports.readings import DAMPINGS, FREQUENCIES, LAWS, REGIMES_NEARBY_STARTS
from vibsim.orbits.branches.branch import Branch
from vibsim.plots.fit_and_bench import scatter_shares
from vibsim.plots.picture import DPI, drawn
from vibsim.plots.sheet import CM, Level, draw_levels, legend_below, letter_panels, sheet
from vibsim.plots.style import BLACK, BLUE, GREEN, GREY, ORANGE, SHADE, SKY, VERMILLION
from vibsim.plots.subject import Subject, View
from vibsim.plots.sweep_curves import alone, curves, draw_curve, frequencies
from vibsim.results.output_files import output_file
from vibsim.sweeps import SweepResult, sweep

# Pictures that decide a claim: drift over ensembles, holds and escapes, regimes beside Table 1.


PAGE = View(width="page")
SLOWEST = 1e-3  # [mm/s] less is drawn here: 0.3 mm in 300 s
SIDEWAYS = 0.28  # half width of a cloud of points, in the distance of two cases
KINDS = {
    "periodic": "0.85", "transient": SKY, "quasi-periodic": ORANGE, "chaotic": VERMILLION, "undecided": BLACK,
}  # fmt: skip
KIND_HATCHES = {"quasi-periodic": "////", "chaotic": "xxxx"}  # what prints like another colour
CAPTURED = ("II-B", "II-C", *SHIPPED_READINGS)
COLOURS = dict(zip(CAPTURED, (BLUE, ORANGE, GREEN, VERMILLION), strict=True))
RING: dict[str, Any] = {"color": BLACK, "markersize": 5, "markerfacecolor": "none", "markeredgewidth": 1.0}
DISAGREE: dict[str, Any] = {
    "color": "white",
    "markersize": 2,
    "markeredgecolor": "0.3",
    "markeredgewidth": 0.3,
}
CROSS: dict[str, Any] = {"color": BLACK, "markersize": 5, "markeredgecolor": "white", "markeredgewidth": 0.6}
SOURCES = ((BLUE, "ideal, Table 1"), (SKY, "ideal, equal force"), (ORANGE, "motor"))
MARKS = dict(zip(CAPTURED, "osD^", strict=True))


def draw_drift(numbers: claims_Numbers) -> Figure:
    """Rates of displacement of every perturbed start, case by case: overall, and in the second half."""
    figure = sheet(PAGE, 8.0)
    names = [name for three in zip(PRINTED, EQUAL_FORCE, MOTORS, strict=True) for name in three]
    panels = figure.subplots(1, 2, sharey=True)
    for axes, key, title in zip(panels, ("overall", "drift"), ("Overall", "Second half"), strict=True):
        for place, name in enumerate(names):
            rates = [1e3 * abs(each[key]) for each in members(numbers, name) if each.get(key) is not None]
            colour = ORANGE if name in MOTORS else SKY if name in EQUAL_FORCE else BLUE
            _cloud(axes, place, np.maximum(rates, SLOWEST), colour, name)
            axes.plot(place, max(1e3 * abs(_from_rest(numbers, name, key)), SLOWEST), "o", **RING)
        axes.set_yscale("log")
        axes.set_title(title, fontsize=8, fontweight="bold")
        _name_places(axes, names)
    panels[0].set_ylabel("Rate of displacement $|dx_2/dt|$ (mm/s)")
    handles = [Patch(facecolor=colour, label=label) for colour, label in SOURCES]
    legend_below(figure, handles, [label for _, label in SOURCES], handlelength=1.2)
    return figure


def _from_rest(numbers: claims_Numbers, name: str, key: str) -> float:
    run = numbers["runs"][name]
    return float(run["overall"] if key == "overall" else run["drift"]["rate"] or np.nan)


def draw_capture(numbers: claims_Numbers) -> Figure:
    """Speed while held, beside final speed against the time of release, of every perturbed start."""
    figure = sheet(PAGE, 7.6)
    speeds, ends = figure.subplots(1, 2, width_ratios=(1, 1.6))
    speeds.axhline(NATURAL_HZ, color=GREY, linewidth=0.8, linestyle="--")
    ends.axvspan(*ABOUT_100, color=SHADE, linewidth=0, zorder=0)
    ends.axhspan(*JUMPED_HZ, color=SHADE, linewidth=0, zorder=0)
    for place, name in enumerate(CAPTURED):
        held = [each for each in members(numbers, name) if each.get("since") is not None]
        _cloud(speeds, place, [each["speed_hz"] for each in held], COLOURS[name], name)
        last = numbers["runs"][name]["t_end"]
        times = [last if each["until"] is None else each["until"] for each in held]
        ends.plot(
            times, [each["final_hz"] for each in held], MARKS[name], color=COLOURS[name], markersize=3,
            alpha=0.7, markeredgewidth=0, label=name, gid=name,
        )  # fmt: skip
    speeds.set_ylabel("Speed while held (Hz)")
    speeds.margins(y=0.1)
    _name_places(speeds, CAPTURED)
    ends.set_xlabel("Held until (s)")
    ends.set_ylabel("Final speed (Hz)")
    ends.set_xlim(0, 1.03 * max(numbers["runs"][name]["t_end"] for name in CAPTURED))
    legend_below(figure, *ends.get_legend_handles_labels())
    return figure


def draw_regimes(numbers: claims_Numbers) -> Figure:
    """Regime of most starts at each frequency of the ideal source, a row for each law and damping."""
    figure = sheet(PAGE, 5.4)
    axes = figure.subplots()
    rows = [(law, c) for law in LAWS for c in DAMPINGS]
    regimes = {(row["law"], row["c"], row["hz"]): row["regime"] for row in numbers["nearby"]}
    kinds = list(KINDS)
    classes = np.array([[_class(kinds, regimes.get((*row, hz))) for hz in FREQUENCIES] for row in rows])
    half = (FREQUENCIES[1] - FREQUENCIES[0]) / 2
    edges = [hz - half for hz in FREQUENCIES] + [FREQUENCIES[-1] + half]
    colours = ListedColormap(list(KINDS.values()))
    axes.pcolormesh(
        edges, range(len(rows) + 1), classes, cmap=colours, vmin=-0.5, vmax=len(kinds) - 0.5,
        edgecolors="white", linewidth=0.4, gid="regimes",
    )  # fmt: skip
    for kind, hatch in KIND_HATCHES.items():
        for j, i in np.argwhere(classes == kinds.index(kind)):
            look: dict[str, Any] = {"facecolor": "none", "edgecolor": "0.2", "linewidth": 0, "hatch": hatch}
            axes.add_patch(Rectangle((edges[i], j), 2 * half, 1, gid=f"hatch {kind}", **look))
    for row in numbers["nearby"]:
        if len({str(each["regime"]) for each in row["starts"]}) > 1:
            place = rows.index((row["law"], row["c"])) + 0.5
            axes.plot(row["hz"], place, "o", gid="disagree", **DISAGREE)
    for hz in (3.5, 5.5, 6.5):
        for law in LAWS:
            axes.plot(hz, rows.index((law, DAMPINGS[1])) + 0.75, "X", **CROSS)
    axes.set_yticks(np.arange(len(rows)) + 0.5, [f"{law}, c = {c:g}" for law, c in rows])
    axes.tick_params(length=0)
    axes.set_xlabel(r"Frequency of the ideal source $\omega/2\pi$ (Hz)")
    edge: dict[str, Any] = {"edgecolor": "0.3", "linewidth": 0.4}
    handles = [Patch(facecolor=KINDS[kind], hatch=KIND_HATCHES.get(kind), **edge) for kind in kinds]
    legend_below(figure, handles, kinds, handlelength=1.2)
    return figure


def _class(kinds: Sequence[str], regime: str | None) -> float:
    return kinds.index(regime) if regime in kinds else float("nan")


def _cloud(axes: Axes, place: int, values: Any, colour: str, gid: str) -> None:
    """Values above a place, side by side in their order."""
    beside = place + np.linspace(-SIDEWAYS, SIDEWAYS, len(values)) if len(values) > 1 else [place]
    beside = beside[: len(values)]
    axes.plot(beside, values, "o", color=colour, markersize=2.2, alpha=0.7, markeredgewidth=0, gid=gid)


def _name_places(axes: Axes, names: Sequence[str]) -> None:
    axes.set_xticks(range(len(names)), names, rotation=30, ha="right", rotation_mode="anchor")
    axes.tick_params(axis="x", length=0)
    axes.set_xlim(-0.6, len(names) - 0.4)


# The figures as files: one for each, and one page with all of the paper's.


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
            raise MeasurementInterrupted
    return pictures


def known_from(subjects: Sequence[Subject]) -> str:
    """Origin of the motions shown, a sentence each, where they were not simply run."""
    how = {subject.name: subject.result.attrs.get("comment") for subject in subjects}
    return "".join(f" {name}: {words}." for name, words in how.items() if words)


def write_page(pictures: Sequence[Picture], folder: Path, formats: Sequence[str]) -> Path:
    """All pictures of the paper's figures on one sheet, FOLDER/all-figures.FORMAT."""
    return save(page_of(pictures), folder / "all-figures", formats)


def write_search(numbers: Numbers, folder: Path, formats: Sequence[str]) -> Picture:
    """The map of the search, FOLDER/search.FORMAT."""
    changes = numbers["runs"][SHIPPED_READINGS[0]]["changes"]
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
    """Load curves, by which motors are held or not, FOLDER/load-curves.FORMAT."""
    return Picture(
        save(draw_load_curves(branches), folder / "load-curves", formats),
        "Load curves",
        "Fig. 4 completed: mean torque that the vibration takes against the mean speed, along the branch of "
        "orbits of one turn, for the motor as printed and for the reading; grey: the motors of 3.5, 5.5 and "
        "6.5 Hz. Solid: stable orbits, dashed: unstable ones; crosses, squares and diamonds: folds, period "
        "doublings and Neimark-Sacker points, with the labels of their list. Dots: the motor stays there; "
        "half dots: it stays near, though that orbit is unstable; rings: it leaves. The inset enlarges the "
        "dotted frame: the curves about half the bilinear frequency (dashed), where they turn back.",
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
        "Regime of the ideal source's motion between 150 and 300 s that most of "
        f"{len(REGIMES_NEARBY_STARTS)} starts have (rest; x1 displaced by 0.6 and 1.2 mm to either side): "
        "rows for the law of the amplitude and the damping c in N s/m; white dots: the starts disagree; "
        "crosses: the shipped cases.",
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


# The Sommerfeld diagram: speed and amplitude over the no-load speed, up and down, with and without the stop.


SPEEDS = "3:7:0.05 Hz"
SETTLING = {"run.t_end": "300 s"}  # at every no-load speed; half of it is left out
SWEEPS: dict[str, dict[str, str]] = {"with the stop": {}, "without the stop": {"stop": "none"}}
SOMMERFELD_CM = 10.5
ROWS = (
    ("mean_speed", 1.0, "Mean motor speed $\\langle\\dot\\varphi\\rangle/2\\pi$ (Hz)"),
    ("amplitude_relative", 1e3, "Amplitude of $x_1 - x_2$ (mm)"),
)  # column, factor, label


def obtain_sweeps(folder: Path, tell: Tell, fresh: bool = False) -> dict[str, SweepResult]:
    """The printed motor over its no-load speed, there and back, each point from the end of the one before;
    taken over from FOLDER where it is there. Raises Interrupted when `tell` says to stop.
    """
    sweeps = {}
    for done, (name, changes) in enumerate(SWEEPS.items(), start=1):
        case = load_case(PRINTED_MOTOR, {**SETTLING, **changes})
        path = folder / f"{name.replace(' ', '-')}.h5"
        sweeps[name] = sweep(
            case, {"Omega0": SPEEDS}, direction="both", carry_state=True, section=0, out=path, force=fresh
        )
        if not tell("sweeping the motor", done, len(SWEEPS)):
            raise MeasurementInterrupted
    return sweeps


def write_sommerfeld(sweeps: Mapping[str, SweepResult], folder: Path, formats: Sequence[str]) -> Picture:
    """Speed and amplitude over the no-load speed, FOLDER/sommerfeld.FORMAT."""
    return Picture(
        save(draw_sommerfeld(sweeps), folder / "sommerfeld", formats),
        "Sommerfeld diagram",
        "The printed motor while its no-load speed is raised (filled, blue) and lowered again (rings, "
        "dashed, orange) in steps of 0.05 Hz, 300 s at each, means of the second half: mean speed above, "
        "mean amplitude per turn of x1 − x2 below; (a), (c) with the stop, (b), (d) without it. Thin line: "
        "no-load speed. Dashed levels: natural frequencies, with the stop the bilinear one and its half.",
        "Four panels. Above, speeds that follow the no-load speed but for plateaus below it; below, the "
        "amplitude, which is large on the plateaus.",
    )


def draw_sommerfeld(sweeps: Mapping[str, SweepResult]) -> Figure:
    """A column for each sweep, a row for each of ROWS."""
    figure = sheet(PAGE, SOMMERFELD_CM)
    grid = figure.subplots(len(ROWS), len(sweeps), sharex=True, squeeze=False)
    for column, (name, result) in enumerate(sweeps.items()):
        subject = Subject(f"{name}.h5", name, "sweep", result.case, result)
        drawn = [alone(curve) for curve in curves([subject])]
        for row, (axes, (quantity, factor, label)) in enumerate(zip(grid[:, column], ROWS, strict=True)):
            for curve in drawn:
                draw_curve(axes, curve, factor * curve.values(quantity), f"{quantity} {curve.label}")
            if column == 0:
                axes.set_ylabel(label)
            if row == 0:
                axes.set_title(name, loc="left")
        _add_speeds(grid[0, column], subject)
        grid[1, column].set_ylim(bottom=0)
        grid[1, column].set_xlabel(r"No-load speed $\Omega_0/2\pi$ (Hz)")
    legend_below(figure, *grid[0, 0].get_legend_handles_labels())
    letter_panels(list(grid.ravel()))
    return figure


def _add_speeds(axes: Axes, subject: Subject) -> None:
    """The no-load speed as a line, natural frequencies as levels."""
    span = axes.get_xlim()
    axes.plot(span, span, color=GREY, linewidth=0.5, scalex=False, scaley=False, zorder=1, gid="no-load")
    levels = [Level(f.hz, f"{f.label}  {f.hz:.2f}", {"linestyle": "--"}) for f in frequencies([subject])]
    draw_levels(axes, levels, SOMMERFELD_CM / 2 * 28)


# Where in the plane of J and c the motors do what the paper says of them.


KEYS = ("excitation.J", "coupling.c")
DIMENSIONS = {"excitation.J": "inertia", "coupling.c": "damping"}
PANELS = (
    ("II-B captured for good", (0,)),
    ("II-C held, away in time, ends at 6.2 Hz", (1, 2, 3)),
)
Point = tuple[float, float]  # J in g m^2, c in N s/m


def draw_search(plane: Numbers, printed: Point, reading: Point) -> Figure:
    """Share of the starts from which statements hold, at every point; printed: cross, reading: ring.

    plane : of `parameter_search.search_plane`. Of several statements the least share counts.
    """
    figure = sheet(View(width="page"), 8.2)
    panels = figure.subplots(1, len(PANELS), sharex=True, sharey=True)
    for axes, (title, statements) in zip(panels, PANELS, strict=True):
        places, shares = points_of(plane["ranking"], statements)
        scatter_shares(axes, places, shares, "Share of starts")
        _mark(axes, printed, reading)
        axes.set(xscale="log", yscale="log", xlabel="Moment of inertia $J$ (g m²)", title=title)
    panels[0].set_ylabel("Damping $c$ (N s/m)")
    return figure


def points_of(ranking: Sequence[Numbers], statements: Sequence[int]) -> tuple[list[Point], list[float]]:
    """Places of the candidates that change both numbers, and the least share of the statements there."""
    moved = [row for row in ranking if all(key in row["changes"] for key in KEYS)]
    places = [place_of(row["changes"]) for row in moved]
    return places, [min(_share(row, each) for each in statements) for row in moved]


def place_of(changes: Numbers) -> Point:
    """J [g m^2] and c [N s/m] of changes in the units of a case."""
    inertia, damping = (parse_quantity(changes[key], DIMENSIONS[key]).number() for key in KEYS)
    return 1e3 * inertia, damping


def _share(row: Numbers, statement: int) -> float:
    counts = row["statements"][statement]
    return float(counts["count"] / counts["of"])


def _mark(axes: Axes, printed: Point, reading: Point) -> None:
    axes.plot(*printed, "x", color="black", markersize=7, markeredgewidth=1.4, clip_on=False)
    axes.plot(*reading, "o", color="black", markersize=9, markerfacecolor="none", markeredgewidth=1.4)
