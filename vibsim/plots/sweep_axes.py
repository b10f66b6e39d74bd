"""The axes of a sweep as axes of a picture: their numbers and what is written beside them."""

from __future__ import annotations

import math
import re
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from matplotlib.axes import Axes

from vibsim.cases.quantities import UNITS
from vibsim.cases.schema_keys import LONG
from vibsim.physics.rates import turning_rotor
from vibsim.plots.sheet import draw_by_ratio, rounded
from vibsim.plots.subject import PlotError, Span, Subject, View, as_text
from vibsim.sweeps.axes import Axis
from vibsim.sweeps.quantities import FAILED, MISSING

DRIVES = ("motor", "rotors", "states", "parameters")  # sections with numbers that drive a rotor
MOTOR_SPEEDS = ("excitation.Omega0", "motor.Omega0")
NO_LOAD = r"No-load speed $\Omega_0/2\pi$ (Hz)"
FREQUENCY = r"Excitation frequency $\omega/2\pi$"
WORDS = {
    "blocks.m1": "Mass $m_1$",
    "blocks.m2": "Mass $m_2$",
    "coupling.k1": "Stiffness $k_1$",
    "coupling.c": "Damping $c$",
    "stop.k2": "Stiffness $k_2$ of the stop",
    "stop.G": "Gap $G$",
    "friction.mu": r"Coefficient of friction $\mu$",
    "excitation.M0": "Starting torque $M_0$",
    "initial.phi": r"Rotor angle at the start $\varphi(0)$",
    "initial.phidot": r"Motor speed at the start $\dot\varphi(0)$",
    "motor.M0": "Starting torque $M_0$",
    "initial.motor.phi": r"Rotor angle at the start $\varphi(0)$",
    "initial.motor.phidot": r"Motor speed at the start $\dot\varphi(0)$",
    "base.a": "Amplitude $a$ of the base",
}
OF_PART = {  # by the last part of a key of the long form, before the name of what it belongs to
    "k": "Stiffness $k$",
    "c": "Damping $c$",
    "gap": "Gap",
    "mu": r"Coefficient of friction $\mu$",
    "N": "Load $N$",
    "belt": "Belt speed",
    "A": "Amplitude $A$",
    "F0": "Constant force $F_0$",
    "phase": "Phase",
    "distance": "Distance",
    "x": "Displacement at the start $x(0)$",
    "v": "Velocity at the start $v(0)$",
}


def is_motor_speed(key: str) -> bool:
    """Whether a key is the motor constant."""
    return key in MOTOR_SPEEDS


def is_speed(key: str) -> bool:
    """Whether a key is a speed of the source: the motor constant, or a frequency of forces or the base."""
    return is_motor_speed(key) or key.rpartition(".")[2] == "omega"


def sets_no_load_speed(subject: Subject) -> bool:
    """Whether what a sweep is drawn along is Omega0, or changes it, as a voltage that its formula reads."""
    axis = _drawn_along(subject.result)
    if is_motor_speed(axis.key):
        return True
    if axis is not subject.result.axes[along(subject.result)] or len(axis) < 2:
        return False
    ends = [subject.case.with_values(axis.changes(i)).scene().motor for i in (0, len(axis) - 1)]
    return None not in ends and len({motor.Omega0 for motor in ends}) > 1


def sets_speed(subject: Subject) -> bool:
    """Whether what a sweep is drawn along sets the speed of its source: a no-load speed, or a number of a
    rotor that a formula drives, such as the voltage in the rate of its current.
    """
    if subject.scene.has_motor:
        return sets_no_load_speed(subject)
    return bool(speed_column(subject)) and _drawn_along(subject.result).key.partition(".")[0] in DRIVES


def speed_column(subject: Subject) -> str:
    """The column with the mean speeds of the motor, or of the rotor that drives a scene; empty for none."""
    if subject.scene.has_motor:
        return "mean_speed"
    name = speed_rotor(subject)
    return name and f"mean_speed_{name}"


def speed_rotor(subject: Subject) -> str:
    """Name of the rotor whose speed is drawn: the one whose number was swept, or the one that drives the
    scene; empty for a motor, and where nothing turns.
    """
    rotor = turning_rotor(subject.scene)
    if subject.scene.has_motor or rotor is None:
        return ""
    section, *names = _drawn_along(subject.result).key.split(".")
    return names[0] if section == "rotors" else subject.scene.bodies[rotor].name


def along(result: Any) -> int:
    """Position of the axis that a sweep is drawn along.

    That of the source's speed, or the first; one with several values before one with a single value, an
    ensemble only where there is no other.
    """

    def rank(i: int) -> tuple[bool, bool, bool]:
        axis = result.axes[i]
        return axis is result.members, len(axis) == 1, not is_speed(axis.key)

    return min(range(len(result.axes)), key=rank)


def label_of(axis: Any) -> str:
    """Label of one axis, or of the spread of an ensemble, with its unit."""
    if is_motor_speed(axis.key):
        return NO_LOAD
    if is_speed(axis.key):
        return f"{FREQUENCY}{_of_part(axis.key)} (Hz)"
    words = words_of(axis.key) or axis.name
    return f"{words} ({axis.unit})" if axis.unit else words


def words_of(key: str) -> str:
    """Name of a key in words; empty for a key without one."""
    section, *names = key.split(".")
    if key in WORDS or section not in LONG.named or not names:
        return WORDS.get(key, "")
    if section == "bodies":
        return f"Mass $m${_owner(key)}"
    quantity = OF_PART.get(names[-1], as_text(names[-1]) if len(names) > 1 else "")
    named = as_text(names[0]).lower() in quantity.lower().split()  # the belt speed of a part called belt
    return quantity and (quantity if named else f"{quantity}{_of_part(key)}")


def _owner(key: str) -> str:
    """The body or part that a key of the long form belongs to, behind other words."""
    section, *names = key.split(".")
    return f" of {as_text(names[0])}" if section == "bodies" else _of_part(key)


def _of_part(key: str) -> str:
    """Part that a key of the long form belongs to, behind other words; empty for one without a name."""
    section, *names = key.split(".")
    if section == "base":
        return " of the base"
    term = f", term {names[2]}" if names[1:2] == ["terms"] else ""
    return f" of {as_text(names[0])}{term}" if section in LONG.named and len(names) > 1 else ""


def axis_label(subjects: Sequence[Subject]) -> str:
    """Label of the axis drawn along; PlotError where the sweeps are along different ones."""
    axes = [_drawn_along(subject.result) for subject in subjects]
    if len({axis.key for axis in axes}) > 1:
        listed = ", ".join(f"{s.path} over {axis.key}" for s, axis in zip(subjects, axes, strict=True))
        raise PlotError(f"sweeps over different things do not go into one picture: {listed}")
    return label_of(axes[0])


def _drawn_along(result: Any) -> Any:
    """The axis drawn along; of an ensemble alone, what is spread first."""
    axis = result.axes[along(result)]
    return axis.spreads[0] if axis is result.members else axis


def positions(result: Any) -> np.ndarray:
    """Values of the axis drawn along (n), see `numbers`; of an ensemble alone, its first start values."""
    axis = result.axes[along(result)]
    return axis.drawn[axis.spreads[0].key] if axis is result.members else numbers(axis)


def value_texts(axis: Any) -> list[str]:
    """Every value of an axis with its symbol and unit, such as `$c$ = 0.0151 N s/m`, in rounded decimals."""
    unit = "Hz" if is_speed(axis.key) else axis.unit
    symbol = re.search(r"\$.*?\$", label_of(axis))
    name = symbol.group() + _owner(axis.key) if symbol else axis.name
    return [f"{name} = {text} {unit}".strip() for text in rounded(numbers(axis).tolist())]


def numbers(axis: Any) -> np.ndarray:
    """Values of one axis (n), a speed of the source in Hz, everything else in its unit."""
    values = axis.numbers()
    if not is_speed(axis.key):
        return np.asarray(values)
    unit = UNITS[axis.unit]
    return np.asarray(values * float(unit.factor) / (1.0 if unit.per_turn else 2 * math.pi))


def draws_by_ratio(axis: Any) -> bool:
    """Whether an axis is drawn on a logarithmic scale: its values are spaced by ratio."""
    return isinstance(axis, Axis) and axis.by_ratio


def ascending(axis: Any) -> np.ndarray:
    """Positions of the values of an axis from the least to the greatest, however they are written."""
    return np.argsort(axis.numbers(), kind="stable")


def show_span(axes: Axes, span: Span, room: float, by_ratio: bool, view: View) -> None:
    """Show a span of the axis along, and this share of it on either side, or what the view's window shows."""
    low, high = span
    if by_ratio:
        draw_by_ratio(axes, "x")
        beyond = (high / low) ** room
        axes.set_xlim(*shown(low / beyond, high * beyond, view))
        return
    margin = room * (high - low) if high > low else 0.05 * abs(high) or 1.0
    axes.set_xlim(*shown(low - margin, high + margin, view))


def shown(low: float, high: float, view: View) -> Span:
    """The part of a range that the view's window shows, in the unit of its axis; everything without one.

    Raises PlotError for a window that lies outside.
    """
    if view.window is None:
        return low, high
    first, last = max(low, view.window[0]), min(high, view.window[1])
    if not first < last:
        window_text = ":".join(f"{end:g}" for end in view.window)
        raise PlotError(f"the window {window_text} lies outside the sweep, {low:.6g} to {high:.6g}")
    return first, last


# The plane of a sweep over two ranges: what was computed at each of its points, as coloured cells.


EVEN = 1e-6  # of the greatest distance between values: rounding of evenly spaced ones
NARROW, LEAST = (
    0.1,
    0.01,
)  # widths of a cell of uneven values, relative to all that is drawn: most, half of the least


@dataclass(frozen=True)
class AxesPlane:
    """Two axes of a sweep, that of the source's speed, or the first, across.

    Attributes
    ----------
    subject : the sweep
    across, up : positions of its two axes
    """

    subject: Subject
    across: int
    up: int

    def grid(self, values: np.ndarray, direction: int = 0) -> np.ndarray:
        """Values of the shape of the sweep, without members, as rows of the picture (n_up, n_across)."""
        plane = np.moveaxis(values[..., direction], (self.up, self.across), (0, 1))
        axes = self.subject.result.axes
        return np.asarray(
            plane.reshape(plane.shape[:2])[np.ix_(ascending(axes[self.up]), ascending(axes[self.across]))]
        )

    @property
    def directions(self) -> tuple[int, ...]:
        """Codes of the directions that make a difference."""
        result = self.subject.result
        directions: tuple[int, ...] = result.directions
        return directions if result.plan.carry else directions[:1]

    def lay(self, axes: Axes, cells: np.ndarray, **look: Any) -> Any:
        """Draw cells (n_up, n_across), each about its point; what has no value, and what lies between values
        that are far apart, stays blank.
        """
        (x, i), (y, k) = (_with_blanks(spans) for spans in self.spans())
        laid = np.full((len(y) - 1, len(x) - 1), np.nan)
        laid[np.ix_(k, i)] = cells
        return axes.pcolormesh(x, y, np.ma.masked_invalid(laid), zorder=0.5, rasterized=True, **look)

    def spans(self) -> tuple[np.ndarray, np.ndarray]:
        """From where to where the cells reach, across (n_across, 2) and up (n_up, 2)."""
        across, up = (cell_spans(self.subject.result.axes[i]) for i in (self.across, self.up))
        return across, up

    @property
    def by_ratio(self) -> str:
        """Logarithmic ones of its axes x and y, their values spaced by ratio: x, y, xy or none."""
        axes = self.subject.result.axes
        return "".join(which for which, i in (("x", self.across), ("y", self.up)) if draws_by_ratio(axes[i]))

    def labels(self) -> tuple[str, str]:
        """Labels of the axes across and up."""
        across, up = (label_of(self.subject.result.axes[i]) for i in (self.across, self.up))
        return across, up


def plane_of(subject: Subject) -> AxesPlane:
    """The plane of a sweep over two ranges; members of an ensemble do not count as one."""
    result = subject.result
    ranges = [i for i, axis in enumerate(result.axes) if axis is not result.members and len(axis) > 1]
    across = along(result) if along(result) in ranges else ranges[0]
    (up,) = (i for i in ranges if i != across)
    return AxesPlane(subject, across, up)


def missing_note(subject: Subject) -> str:
    """Number of points that are left blank, and the reasons; empty for none."""
    status = subject.result["status"]
    counts = {"not computed yet": (status == MISSING).sum(), "failed": (status == FAILED).sum()}
    return ", ".join(f"{count} {words}" for words, count in counts.items() if count)


def cell_spans(axis: Any) -> np.ndarray:
    """From where to where cells about the ascending values of an axis reach (n, 2).

    Evenly spaced values, three or more, have cells that touch half way between them; by ratio where the axis
    is. Of others nothing is known in between: a cell reaches no further than half way, nor than half of the
    median distance or than NARROW of the whole. Cells of what is nowhere negative begin at 0 at the least.
    """
    centres = np.sort(numbers(axis))
    if draws_by_ratio(axis):
        return np.asarray(np.exp(_about(np.log(centres), np.inf)))
    gaps = np.diff(centres)
    even = len(gaps) > 1 and np.ptp(gaps) <= EVEN * gaps.max()
    whole = float(np.ptp(centres))
    spans = _about(
        centres, np.inf if even else max(min(float(np.median(gaps)), NARROW * whole) / 2, LEAST * whole)
    )
    return spans if centres[0] < 0 else np.asarray(np.maximum(spans, 0.0))


def _about(centres: np.ndarray, most: float) -> np.ndarray:
    """Spans (n, 2) about ascending points (n): half way to their neighbours, and `most` at the most."""
    gaps = np.diff(centres)
    below, above = np.concatenate([gaps[:1], gaps]) / 2, np.concatenate([gaps, gaps[-1:]]) / 2
    middles = (centres[:-1] + centres[1:]) / 2
    low = np.concatenate([[centres[0] - below[0]], middles])
    high = np.concatenate([middles, [centres[-1] + above[-1]]])
    return np.column_stack([np.maximum(low, centres - most), np.minimum(high, centres + most)])


def _with_blanks(spans: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Edges (m + 1) of the cells of `spans` (n, 2) and of blanks between them; positions (n) of the cells."""
    edges, places = [float(spans[0, 0])], []
    for low, high in spans.tolist():
        if low > edges[-1]:
            edges.append(low)
        places.append(len(edges) - 1)
        edges.append(high)
    return np.array(edges), np.array(places)
