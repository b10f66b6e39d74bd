"""One page about a run, or a few: machine, displacements, detail, relative portrait, speed; and the
characteristics of springs and stops, before anything moves.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import pairwise
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.layout_engine import ConstrainedLayoutEngine

from vibsim.cases.problems import counted
from vibsim.physics.connections import Pair, joined_pairs
from vibsim.physics.formulas import Node
from vibsim.physics.parts import GROUND, Link, RigidStop, Scene, Stop
from vibsim.physics.rates import motor_columns
from vibsim.plots.machine import machine_panel, machine_size
from vibsim.plots.portraits import relative_panel
from vibsim.plots.samples import (
    common_window,
    detail_span,
    difference,
    draw_stop_line,
    stop_label,
    stop_position,
    stops_between,
)
from vibsim.plots.sheet import (
    CM,
    LABEL_SHARE,
    LEGEND_LINE_CM,
    NamedQuantity,
    Scale,
    amount,
    beside_levels,
    characters,
    label_axes,
    legend_above,
    legend_lines,
    letter_panels,
    note,
    scale_for,
    sheet,
    symbol,
    write_names,
)
from vibsim.plots.style import BLUE, SHADE, nested, points
from vibsim.plots.subject import Subject, View, measured, unit_for
from vibsim.plots.time_histories import (
    DISPLACEMENT,
    VELOCITY,
    HistoryCurve,
    Panel,
    curve_groups,
    histories,
    is_short,
    motor_speed_panel,
    rotor_speed_panel,
    rotor_speeds,
)
from vibsim.plots.traces import folded_angles, mark_detail
from vibsim.results.columns import PairMotion

PANEL_CM = 5.2
BESIDE_CM = 10.5  # width of a machine up to which the portrait has room beside it
LARGEST = 1.02  # width of a machine that is drawn, relative to the sheet: its margins give way a little
HEADING_CM = 0.7
APART_CM = 0.3  # between the machine and what is below it
LABEL_CM = 1.8  # what labels of axes take of the width beside the machine


@dataclass(frozen=True)
class Page:
    """The axes of the page, in the order in which they are read.

    tops : the displacements, of all bodies or of one each
    middle : the detail; None where single periods are seen above
    machine : the drawing of the machine; None where runs are several, or it is too wide for the page
    portrait_first : whether the portrait stands above the others, beside the machine
    narrow : whether all stand one below the other
    """

    tops: list[Axes]
    middle: Axes | None
    portrait: Axes
    bottom: Axes
    machine: Axes | None = None
    portrait_first: bool = False
    narrow: bool = False

    @property
    def panels(self) -> list[Axes]:
        """All of them but the machine."""
        middle = [] if self.middle is None else [self.middle]
        if self.portrait_first:
            return [self.portrait, *self.tops, *middle, self.bottom]
        return [
            *self.tops,
            *middle,
            *([self.portrait, self.bottom] if middle or self.narrow else [self.bottom, self.portrait]),
        ]


def overview_picture(subjects: Sequence[Subject], view: View) -> Figure:
    """The machine, and panels that suit what the scenes have: a page of them, or a column."""
    groups = curve_groups(subjects, DISPLACEMENT)
    alone = len(subjects) == 1
    window = common_window(subjects, view.window)
    whole = alone and view.detail is None and is_short(subjects[0], window)
    detail = window if whole else detail_span(subjects, view)
    page = _page(view, subjects, len(groups), whole)
    figure = page.portrait.get_figure(root=True)
    assert isinstance(figure, Figure)
    shown = [Panel(axes, group, window) for axes, group in zip(page.tops, groups, strict=True)]
    motors, speed = all(motor_columns(subject.scene) for subject in subjects), _shows_speed(subjects)
    velocities = [] if speed else [Panel(page.bottom, _first(subjects), detail if alone else window)]
    if page.middle is not None and alone:
        shown.append(Panel(page.middle, groups[0], detail))
        mark_detail(page.tops[0], detail)
    elif page.middle is not None:
        velocities.append(Panel(page.middle, _first(subjects), detail))
    histories(shown, DISPLACEMENT)
    if velocities:
        histories(velocities, VELOCITY)
    relative_panel(page.portrait, subjects, view)
    if speed:
        panel = motor_speed_panel if motors else rotor_speed_panel
        panel(page.bottom, subjects, view, PANEL_CM)
    if page.machine is not None:
        machine_panel(page.machine, subjects[0].case.long_values())
    _finish(figure, page, subjects)
    return figure


def _shows_speed(subjects: Sequence[Subject]) -> bool:
    """Whether the last panel is of the speed of a motor, or of rotors."""
    motors = all(motor_columns(subject.scene) for subject in subjects)
    return motors or all(rotor_speeds(subject.scene) for subject in subjects)


def _first(subjects: Sequence[Subject]) -> list[HistoryCurve]:
    """Velocities of all bodies of one run, or of the first one of several."""
    return curve_groups(subjects, VELOCITY)[0]


def _finish(figure: Figure, page: Page, subjects: Sequence[Subject]) -> None:
    if len(subjects) == 1:
        page.bottom.set_title("", loc="right")
        legend_above(page.bottom)
    for axes in page.tops[: None if len(subjects) == 1 else 1]:
        legend_above(axes)
    letter_panels(page.panels)
    figure.align_ylabels()
    room = LABEL_SHARE * characters(figure.get_figwidth())
    figure.suptitle(_heading(subjects, room), x=0.01, ha="left", fontsize=points(8))


def _machine(subjects: Sequence[Subject], view: View) -> tuple[float, float] | None:
    """Width and height of the machine's drawing [cm]; None for several runs, and on too narrow a sheet."""
    if len(subjects) > 1:
        return None
    width, height = machine_size(subjects[0].case.long_values())
    return (width, height) if width <= LARGEST * view.width_cm else None


def _page(view: View, subjects: Sequence[Subject], groups: int, whole: bool) -> Page:
    """The axes: on a page the portrait stands beside the machine where there is room, else beside detail and
    speed; in a column all are one below the other.
    """
    size, wide = _machine(subjects, view), view.width == "page"
    beside = beside_levels(view) if _shows_speed(subjects) else {}
    if size is None:
        figure = sheet(
            view,
            PANEL_CM * (2 + _top_rows(groups) if wide else _rows(groups, whole))
            + _legends_cm(view, subjects),
        )
        return _panels(figure, wide, groups, whole, beside)
    if wide and size[0] <= BESIDE_CM:
        return _beside(view, size, groups, whole)
    height = (
        size[1] + HEADING_CM + APART_CM + PANEL_CM * (2 + _top_rows(groups) if wide else _rows(groups, whole))
    )
    height += _legends_cm(view, subjects)
    figure = sheet(view, height)
    engine = figure.get_layout_engine()
    assert isinstance(engine, ConstrainedLayoutEngine)
    engine.set(rect=(0, 0, 1, 1 - (size[1] + APART_CM) / (figure.get_figheight() / CM)))
    return replace(_panels(figure, wide, groups, whole, beside), machine=_head(figure, size))


def _legends_cm(view: View, subjects: Sequence[Subject]) -> float:
    """Height of the lines of the legends of bodies beyond the first ones [cm]."""
    labels = [symbol(name) for name in subjects[0].columns_in("m")] if len(subjects) == 1 else [""]
    return 2 * LEGEND_LINE_CM * (legend_lines(labels, view.width_cm) - 1)


def _rows(groups: int, whole: bool) -> int:
    """Panels of a column."""
    return groups + (2 if whole else 3)


def _top_rows(groups: int) -> int:
    """Rows of a page that the displacements take: two panels to a row."""
    return -(-groups // 2)


def _head(figure: Figure, size: tuple[float, float]) -> Axes:
    """Axes of a width and height [cm] under the heading, outside the layout of the others."""
    sheet_cm = figure.get_figwidth() / CM, figure.get_figheight() / CM
    width, height = min(size[0] / sheet_cm[0], 1.0), size[1] / sheet_cm[1]
    place = (0, 1 - HEADING_CM / sheet_cm[1] - height, width, height)
    axes = figure.add_axes(place, label="<machine>")
    axes.set_in_layout(False)
    return axes


def _beside(view: View, size: tuple[float, float], groups: int, whole: bool) -> Page:
    """The portrait beside the machine; below them the others, as wide as the page."""
    heights = [max(size[1] + HEADING_CM, PANEL_CM), *[PANEL_CM] * (groups + (1 if whole else 2))]
    figure = sheet(view, sum(heights))
    ratios = (size[0] + LABEL_CM, view.width_cm - size[0] - LABEL_CM)
    grid = figure.add_gridspec(len(heights), 2, height_ratios=heights, width_ratios=ratios)
    *cells, last = [grid[row, :] for row in range(1, len(heights))]
    page = _listed([figure.add_subplot(cell) for cell in (*cells, grid[0, 1], last)], groups, whole)
    return replace(page, machine=_head(figure, size), portrait_first=True)


def _panels(figure: Figure, wide: bool, groups: int, whole: bool, beside: dict[str, Any]) -> Page:
    """Displacements above (one panel, or one per body); below them the others in two columns, or one.

    beside : of a column, see `beside_levels`; empty where none are named
    """
    if not wide:
        axes = figure.subplots(_rows(groups, whole), 1, gridspec_kw=beside)
        page = _listed(list(axes), groups, whole)
        return replace(page, narrow=True)
    top = _top_rows(groups)
    grid = figure.add_gridspec(top + 2, 2, width_ratios=(1.25, 1))
    tops = [grid[0, :]] if groups == 1 else [grid[i // 2, i % 2] for i in range(groups)]
    left = [] if whole else [grid[top, 0]]
    cells = [*tops, *left, grid[top:, 1], grid[top if whole else top + 1 :, 0]]
    return _listed([figure.add_subplot(cell) for cell in cells], groups, whole)


def _listed(axes: list[Axes], groups: int, whole: bool) -> Page:
    *rest, portrait, bottom = axes
    return Page(rest[:groups], None if whole else rest[groups], portrait, bottom)


def _heading(subjects: Sequence[Subject], room: float) -> str:
    """Name and title of the case, or as much of them as goes into a line of so many characters."""
    if len(subjects) > 1:
        return ", ".join(subject.name for subject in subjects)
    name, title = subjects[0].name, subjects[0].title
    wishes = [f"{name}: {title}", title] if title else []
    return next((text for text in wishes if len(text) <= room), name)


# Pictures of cases: what a law of force or a motor is, before anything moves.


# Characteristics of springs and stops: their force against the relative displacement of their ends.


REACH = 2.5  # the picture reaches this many gaps beyond the rest position on the side of the stop
PLACES = (0.5, 0.35, 0.65, 0.2, 0.8, 0.05)  # of a name along its part of the curve, the better first
BEHIND = 0.08  # of the range, shown behind a rigid stop
ROOM_BESIDE = 1.2  # beyond the farthest point of a run
SAMPLES = 20_000  # of a run, to tell how far it goes
NO_GAP = 1e-3  # a range to show where the scene gives none [m]
MOST = 6  # panels
POINTS_OF_FORMULA = 401
HEIGHT_CM = 6.0
STIFFNESS = {"m": "N/m", "rad": "N m/rad"}
SYMBOLS = {"coupling": "k_1", "stop": "k_2"}  # of the springs of the short form


def stiffness_picture(subjects: Sequence[Subject], view: View) -> Figure:
    """Spring force against x_P - x_Q, a panel for each pair of ends that links and stops join.

    Of two blocks F_s1 + F_s2, Eqs. (2.4), (2.5): slope k1, and k1 + k2 beyond the gap.
    """
    motions = motions_of(subjects)
    shown = motions[:MOST]
    figure = sheet(view, HEIGHT_CM * len(shown))
    panels = list(figure.subplots(len(shown), 1, squeeze=False)[:, 0])
    for axes, motion in zip(panels, shown, strict=True):
        stiffness_panel(axes, subjects, motion)
    if len(motions) > MOST:
        note(panels[-1], f"not shown: {counted(len(motions) - MOST, 'more pair')} of ends")
    letter_panels(panels)
    return figure


def motions_of(subjects: Sequence[Subject]) -> list[str]:
    """Labels of the relative displacements of the subjects, each once."""
    every = [(subject.scene, pair) for subject in subjects for pair in joined_pairs(subject.scene)]
    return list(dict.fromkeys(difference(scene, pair, "x") for scene, pair in every))


def stiffness_panel(axes: Axes, subjects: Sequence[Subject], motion: str | None = None) -> None:
    """The characteristic of one relative motion in given axes, by default the first one."""
    motion = motion or motions_of(subjects)[0]
    shown = [
        (subject, pair)
        for subject in subjects
        for pair in joined_pairs(subject.scene)
        if difference(subject.scene, pair, "x") == motion
    ]
    gaps = [abs(at) for subject, pair in shown for at, _ in all_stops(subject.scene, pair)]
    reach = _reach(shown, REACH * max(gaps, default=0.0))
    curves = [stiffness_characteristic(subject.scene, pair, reach) for subject, pair in shown]
    turning = shown[0][0].scene.unit_between(shown[0][1].P, shown[0][1].Q) == "rad"
    units = unit_for("m", turning), unit_for("N", turning)
    scales = scale_for(units[0], *(y for y, _ in curves)), scale_for(units[1], *(f for _, f in curves))
    looks = [nested(i, len(shown), 1.0) for i in range(len(shown))]
    looks = looks if len(shown) > 1 else [{"color": BLUE, "linewidth": 1.0}]
    for (subject, _), (y, force), look in zip(shown, curves, looks, strict=True):
        axes.plot(scales[0](y), scales[1](force), label=subject.name, gid="stiffness", **look)
    if not any(force.any() for _, force in curves):
        axes.set_ylim(-1, 1)
        axes.set_yticks([0])  # rigid stops alone have no scale of force
    _draw_walls(
        axes, [wall for each in zip(shown, curves, looks, strict=True) for wall in _walls(*each)], scales
    )
    axes.axhline(0, color="0.8", linewidth=0.4, zorder=0)
    axes.axvline(0, color="0.8", linewidth=0.4, zorder=0)
    words = f"{'relative ' if ' - ' in motion else ''}{measured('m', turning)}".capitalize()
    label_axes(axes, (words, scales[0].label(motion)), ("Spring", scales[1].label(measured("N", turning))))
    if len(subjects) == 1:
        _name_slopes(axes, subjects[0].scene, shown[0][1], reach, scales)
    else:
        legend_above(axes)


def _reach(shown: Sequence[tuple[Subject, Pair]], of_gaps: float) -> float:
    """Reach of a characteristic from the rest position [m]: some gaps; of a run so far as it goes at
    the least; without either, as far as the greatest force would bend the springs, or the start is from it.
    """
    if any(pair.Q == GROUND and pair.P in folded_angles(s.scene) for s, pair in shown):
        return 2 * math.pi
    moved = max(_moved(subject, pair) for subject, pair in shown)
    if of_gaps or moved:
        return max(of_gaps, ROOM_BESIDE * moved)
    bent = max(_bent(subject.scene, pair) for subject, pair in shown)
    return bent or REACH * max(_start(subject.scene, pair) for subject, pair in shown) or REACH * NO_GAP


def _moved(subject: Subject, pair: Pair) -> float:
    """The greatest relative displacement of a run in its window of samples [m]; 0 of other subjects."""
    if subject.reads != "trajectory":
        return 0.0
    motion, count = PairMotion(subject.scene, pair), len(subject.result.column("time"))
    stride = max(1, count // SAMPLES)
    block = {name: np.asarray(subject.result.column(name)[::stride]) for name in ("time", *motion.columns)}
    return float(np.abs(motion(block, "time")[1]).max(initial=0.0))


def _bent(scene: Scene, pair: Pair) -> float:
    """Static deflection of the linear springs between the ends under the forces on an end [m]."""
    k = sum(link.k for link in _links_between(scene, pair) if link.force is None)
    forces = [
        abs(float(force.constant)) + sum(abs(float(term.amplitude)) for term in force.terms)
        for force in scene.forces
        if force.on in (pair.P, pair.Q)
    ]
    return max(forces, default=0.0) / k if k else 0.0


@dataclass(frozen=True)
class Wall:
    """A rigid stop: relative displacement [m] and force of springs [N] where it is met, on which side (1:
    above) there is no motion, and the look of its curve."""

    at: float
    force: float
    side: int
    look: dict[str, Any]


def _walls(shown: tuple[Subject, Pair], curve: tuple[np.ndarray, np.ndarray], look: Any) -> list[Wall]:
    """The rigid stops at which a curve ends."""
    subject, pair = shown
    every = rigid_stops_between(subject.scene, pair)
    met = [
        (at, _side(stop, pair)) for at, stop in every if at == curve[0][-1 if _side(stop, pair) > 0 else 0]
    ]
    return [Wall(at, float(curve[1][-1 if side > 0 else 0]), side, look) for at, side in met]


def _draw_walls(axes: Axes, walls: Sequence[Wall], scales: tuple[Scale, Scale]) -> None:
    """Rigid stops as upright lines, along which the force is whatever holds against them; hatched beyond."""
    ends, forces = list(axes.get_xlim()), axes.get_ylim()
    room = BEHIND * (ends[1] - ends[0])
    for side in {wall.side for wall in walls}:
        ends[side > 0] += side * room
    for wall in walls:
        at, upright = float(scales[0](wall.at)), [float(scales[1](wall.force)), forces[wall.side > 0]]
        axes.plot([at, at], upright, gid="rigid", **wall.look)
        axes.axvspan(
            *sorted((at, ends[wall.side > 0])), facecolor="none", edgecolor=SHADE, hatch="////", linewidth=0,
            zorder=0, gid="beyond-rigid",
        )  # fmt: skip
    axes.set_xlim(*ends)
    axes.set_ylim(forces)


def corners(scene: Scene, pair: Pair) -> list[tuple[float, Stop]]:
    """Relative displacement [m] at which each elastic stop between the ends is met, ascending."""
    stops = [stop for stop in stops_between(scene, pair) if isinstance(stop, Stop)]
    positions = [(stop_position(stop, pair), stop) for stop in stops]
    return sorted(positions, key=lambda each: each[0])


def rigid_stops_between(scene: Scene, pair: Pair) -> list[tuple[float, RigidStop]]:
    """Relative displacement [m] at which each rigid stop between the ends is met: no curve goes beyond."""
    stops = [stop for stop in stops_between(scene, pair) if isinstance(stop, RigidStop)]
    return [(stop_position(stop, pair), stop) for stop in stops]


def all_stops(scene: Scene, pair: Pair) -> list[tuple[float, Stop | RigidStop]]:
    """The stops between the ends and where each is met [m], those of one kind after the other."""
    return [*corners(scene, pair), *rigid_stops_between(scene, pair)]


def within_rigid_stops(scene: Scene, pair: Pair, reach: float) -> tuple[float, float]:
    """The least and the largest relative displacement [m] that rigid stops allow, at most `reach` off 0."""
    stops = rigid_stops_between(scene, pair)
    low = max([-reach, *(at for at, stop in stops if _side(stop, pair) < 0)])
    high = min([reach, *(at for at, stop in stops if _side(stop, pair) > 0)])
    return low, high


def spring_force(scene: Scene, pair: Pair, y: np.ndarray) -> np.ndarray:
    """Force of springs and stops between the ends [N] at x_P - x_Q = y [m], dampers left out; of formulas at
    rest, what else they read as at the start.
    """
    force = np.zeros_like(y)
    for link in _links_between(scene, pair):
        if link.force is None:
            force = force + link.k * y
        else:
            force = force + (1 if link.P == pair.P else -1) * _of_formula(scene, pair, link.force, y)
    for at, stop in corners(scene, pair):
        side = _side(stop, pair)
        depth = np.maximum(side * (y - at), 0.0)
        if stop.force is None:
            force = force + side * stop.k * depth
        else:
            force = force + side * np.where(depth > 0, _of_formula(scene, pair, stop.force, y), 0.0)
    return force


def _links_between(scene: Scene, pair: Pair) -> list[Link]:
    return [link for link in scene.links if {link.P, link.Q} == {pair.P, pair.Q}]


def _of_formula(scene: Scene, pair: Pair, formula: Node, y: np.ndarray) -> np.ndarray:
    """Values of a formula where the ends of a pair are apart by y [m] and nothing moves."""
    from vibsim.physics.formula_values import start_inputs, values_of

    inputs: dict[Node, Any] = {
        node: 0.0 if node[0] == "v" and node[1] < len(scene.line) else value
        for node, value in start_inputs(scene).items()
        if node[0] != "t"
    }
    own, other = (pair.P, pair.Q) if pair.P >= 0 else (pair.Q, pair.P)
    inputs |= {("x", other): 0.0, ("x", own): y if own == pair.P else -y}
    return np.broadcast_to(values_of(formula, inputs), np.shape(y))


def _start(scene: Scene, pair: Pair) -> float:
    """Distance of the ends of a pair with a formula at the start [m]; 0 of others."""
    if not _has_formula(scene, pair):
        return 0.0
    P, Q = (float(scene.bodies[end].x) if end >= 0 else 0.0 for end in (pair.P, pair.Q))
    return abs(P - Q)


def _has_formula(scene: Scene, pair: Pair) -> bool:
    """Whether what is between the ends is more than straight lines."""
    formulas = [link.force for link in _links_between(scene, pair)]
    return any(one is not None for one in [*formulas, *(stop.force for _, stop in corners(scene, pair))])


def _side(stop: Stop | RigidStop, pair: Pair) -> int:
    """1 where the stop is met by growing x_P - x_Q of the pair, else -1."""
    return -stop.sense if stop.P == pair.P else stop.sense


def stiffness_characteristic(scene: Scene, pair: Pair, reach: float) -> tuple[np.ndarray, np.ndarray]:
    """The polyline (y [m], force [N]): its ends and its corners at the stops; many points of a formula."""
    low, high = within_rigid_stops(scene, pair, reach)
    between = np.linspace(low, high, POINTS_OF_FORMULA)[1:-1].tolist() if _has_formula(scene, pair) else []
    y = np.unique([low, *between, *(at for at, _ in corners(scene, pair) if low < at < high), high])
    return y, spring_force(scene, pair, y)


def _name_slopes(axes: Axes, scene: Scene, pair: Pair, reach: float, scales: tuple[Scale, Scale]) -> None:
    """The slopes in words, beside the curve and inside the frame; limits are settled before."""
    knots, _ = stiffness_characteristic(scene, pair, reach)
    named = []
    if _has_formula(scene, pair):  # a curve has no slope to name
        knots = knots[:1]
    for low, high in sorted(pairwise(knots.tolist()), key=lambda part: not part[0] < 0 < part[1]):
        near, far = sorted((low, high), key=abs)
        text = _slope(scene, pair, (low + high) / 2)
        named.append(_named(text, scene, pair, scales, 0.0 if low < 0 < high else near, far))
    for at, stop in all_stops(scene, pair):
        draw_stop_line(axes, at, scales[0], stop_label(stop))
    axes.set_xlim(axes.get_xlim())
    axes.set_ylim(axes.get_ylim())
    write_names(axes, named)


def _slope(scene: Scene, pair: Pair, y: float) -> str:
    """The stiffness at x_P - x_Q = y [m] in words, with its symbols where the paper has them."""
    acting = [link for link in scene.links if {link.P, link.Q} == {pair.P, pair.Q}]
    touched = [stop for at, stop in corners(scene, pair) if _side(stop, pair) * (y - at) > 0]
    springs = [*((link.name, link.k) for link in acting), *((stop.name, stop.k) for stop in touched)]
    value = amount(sum(k for _, k in springs), STIFFNESS[scene.unit_between(pair.P, pair.Q)])
    if not acting and not corners(scene, pair):
        return "no spring"
    if springs and all(name in SYMBOLS for name, _ in springs):
        return f"slope ${' + '.join(SYMBOLS[name] for name, _ in springs)}$ = {value}"
    return f"slope {value}"


def _named(
    text: str, scene: Scene, pair: Pair, scales: tuple[Scale, Scale], start: float, end: float
) -> NamedQuantity:
    """A name for the straight part of the curve between two displacements [m], at its middle if it fits."""
    y = start + (end - start) * np.array(PLACES)
    behind = {"facecolor": "white", "edgecolor": "none", "pad": 0.8}  # lines of the axes end there
    look = {"fontsize": points(7), "gid": "slope", "bbox": behind}
    return NamedQuantity(text, scales[0](y), scales[1](spring_force(scene, pair, y)), look)
