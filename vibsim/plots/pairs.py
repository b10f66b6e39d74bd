"""The two bodies whose motion against each other is drawn, and the stops between them."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.colors import to_rgba

from vibsim.physics.connections import pairs_of
from vibsim.plots.samples import difference, impact_times, stop_label, stop_position, stops_between, window_of
from vibsim.plots.sheet import Scale, as_text, label_axes, note, pixel_columns
from vibsim.plots.style import GREY, SHADE, points
from vibsim.plots.subject import Subject
from vibsim.plots.traces import Plane, Trace, samples_are_sparse, trace
from vibsim.plots.view import PlotError, Span
from vibsim.results.columns import IMPACT_CODES, PairMotion


@dataclass(frozen=True)
class PlottedPair:
    """Two bodies, or a body and ground or base.

    Attributes
    ----------
    names : columns of a run that their relative motion needs
    plane : from these to relative displacement [m] and velocity [m/s]
    displacement, velocity : what these are called
    stops : relative displacement [m] at which each stop between them is met, and its name
    belts : relative velocity [m/s] at which the body rides on each belt between them, and its name
    """

    names: tuple[str, ...]
    plane: Plane
    displacement: str
    velocity: str
    stops: tuple[tuple[float, str], ...]
    belts: tuple[tuple[float, str], ...] = ()

    @property
    def words(self) -> tuple[str, str]:
        """What displacement and velocity are: relative ones of two ends that may move."""
        if " - " in self.displacement:
            return "Relative displacement", "Relative velocity"
        return "Displacement", "Velocity"


def pair_of(subject: Subject) -> PlottedPair:
    """The ends of the stop that is struck most often, else of the first link, else of the first friction,
    else the first body and ground.
    """
    scene, part = subject.scene, shown_part(subject)
    motion = PairMotion(scene, part)

    def plane(block: Any) -> tuple[np.ndarray, np.ndarray]:
        _, x, v = motion(block, "time")
        return x, v

    x, v = (difference(scene, part, letter) for letter in "xv")
    stops = [(stop_position(stop, part), stop_label(stop)) for stop in stops_between(scene, part)]
    return PlottedPair(("time", *motion.columns), plane, x, v, tuple(stops), tuple(_belts(scene, part)))


def _belts(scene: Any, part: Any) -> Iterator[tuple[float, str]]:
    """Velocities v_P - v_Q of a part at which the ends stick on the belts between them, which move evenly."""
    for friction in scene.frictions:
        if (
            {friction.P, friction.Q} == {part.P, part.Q}
            and isinstance(friction.belt, float)
            and friction.belt
        ):
            yield (friction.belt if friction.P == part.P else -friction.belt), as_text(friction.name)


def common_pairs(subjects: Sequence[Subject]) -> list[PlottedPair]:
    """The pair of each subject; PlotError where they are not the motion of the same ends."""
    pairs = [pair_of(subject) for subject in subjects]
    if len({pair.displacement for pair in pairs}) > 1:
        several = ", ".join(pair.displacement for pair in pairs)
        raise PlotError(f"no relative motion is common to the runs: {several}; draw them one by one")
    return pairs


def relative_traces(
    subjects: Sequence[Subject], pairs: Sequence[PlottedPair], spans: Sequence[Span]
) -> list[Trace]:
    """The relative motion of each subject's pair within its span [s]."""
    return [
        trace(subject.result, pair.names, pair.plane, span)
        for subject, pair, span in zip(subjects, pairs, spans, strict=True)
    ]


def label_relative(axes: Axes, pair: PlottedPair, scales: tuple[Scale, Scale]) -> None:
    """Name the relative displacement of a pair across, its velocity upwards."""
    across, up = pair.words
    label_axes(axes, (across, scales[0].label(pair.displacement)), (up, scales[1].label(pair.velocity)))


def draw_belts(axes: Axes, pair: PlottedPair, scale: Scale) -> None:
    """The velocities of belts as dashed lines across the axes, named at the right."""
    for velocity, name in pair.belts:
        at = float(scale(velocity))
        axes.axhline(at, color=GREY, linewidth=0.6, linestyle=(0, (4, 2)), zorder=0, gid="belt")
        beside = ("top", -2) if velocity > 0 else ("bottom", 2)  # towards the middle of the picture
        axes.annotate(
            f"velocity of {name}", (1, at), (-3, beside[1]), xycoords=("axes fraction", "data"),
            textcoords="offset points", ha="right", va=beside[0], fontsize=points(6.5), color=GREY, zorder=4,
        )  # fmt: skip


def shown_part(subject: Subject) -> Any:
    """The part whose ends a relative motion is of, see `pair_of`."""
    scene = subject.scene
    if not scene.stops:
        return pairs_of(scene)[0]
    if len(scene.stops) == 1:
        return scene.stops[0]
    events = subject.result.events
    part = np.asarray(events["part"])[np.isin(np.asarray(events["kind"]), IMPACT_CODES)]
    return scene.stops[int(np.argmax(np.bincount(part, minlength=len(scene.stops))))]


# Marks on a time axis: where the impacts are, and until when each run is right.


HATCHES = ("////", "\\\\\\\\")  # of runs in turn: crossed where two of them are wrong
SPELT_OUT = 3  # trust horizons given in numbers


def annotate_runs(
    axes: Axes,
    subjects: Sequence[Subject],
    span: Span,
    colours: Sequence[Any] = (GREY,),
    impacts: bool = True,
) -> None:
    """The trust horizon of each run; for a single one also ticks for the impacts (where wanted); a note."""
    alone = subjects[0] if len(subjects) == 1 else None
    remarks = [
        impact_ticks(axes, alone, span) if impacts and alone else "",
        trust_marks(axes, subjects, span, colours),
    ]
    if alone and samples_are_sparse(alone.scene):
        remarks.append(f"samples every {alone.scene.sample_time(1):g} s")
    incomplete = [subject.name for subject in subjects if not subject.result.complete]
    if incomplete:
        remarks.append("incomplete run" if alone else f"incomplete: {', '.join(incomplete)}")
    note(axes, "; ".join(remark for remark in remarks if remark))


def impact_ticks(axes: Axes, subject: Subject, span: Span) -> str:
    """A tick below for every impact, as far as pixels can tell them apart; their number in words."""
    if not subject.scene.has_stop:
        return ""
    t = impact_times(subject.result, window_of(subject, span))
    pixel = ((t - span[0]) / (span[1] - span[0]) * pixel_columns(axes)).astype(int)
    distinct = t[np.unique(pixel, return_index=True)[1]]
    axes.plot(
        distinct, np.zeros(len(distinct)), linestyle="none", marker=2, markersize=2.2, markeredgewidth=0.3,
        color="0.6", transform=axes.get_xaxis_transform(), gid="impacts",
    )  # fmt: skip
    return f"{len(t)} impact{'' if len(t) == 1 else 's'}"


def horizon_within(subject: Subject, span: Span) -> float | None:
    """The trust horizon [s] of a run where it lies before the end of what is shown, else None."""
    horizon = subject.result.trust_horizon
    return None if horizon is None or horizon >= min(span[1], subject.result.t_reached) else float(horizon)


def trust_remark(subjects: Sequence[Subject], spans: Sequence[Span], marked: bool = False) -> str:
    """The trust horizons of runs that end before what is shown of them, in words; empty where all is right.

    marked : whether the picture hatches what lies beyond
    """
    ends = [horizon_within(subject, span) for subject, span in zip(subjects, spans, strict=True)]
    horizons = [(end, span) for end, span in zip(ends, spans, strict=True) if end is not None]
    if not horizons:
        return ""
    plural = "s" if len(horizons) > 1 else ""
    digits = 4 if len(subjects) == 1 else 3
    listed = (
        f"{', '.join(f'{end:.{digits}g}' for end, _ in horizons)} s" if len(horizons) <= SPELT_OUT else ""
    )
    if all(end <= span[0] for end, span in horizons):
        return f"beyond the trust horizon{plural}" + (f", {listed}" if listed else "")
    return " ".join(
        filter(
            None,
            [f"trust horizon{plural}", listed, "(hatched beyond)" if marked and len(subjects) == 1 else ""],
        )
    )


def trust_marks(axes: Axes, subjects: Sequence[Subject], span: Span, colours: Sequence[Any] = (GREY,)) -> str:
    """Hatch what lies beyond a run's trust horizon, behind a dotted line; in words, empty where all is right.

    Of several runs each has lines of its own of the `colours`. A span that lies beyond as a whole is only
    said to.
    """
    alone = len(subjects) == 1
    for i, (subject, colour) in enumerate(zip(subjects, colours, strict=True)):
        horizon = horizon_within(subject, span)
        if horizon is None or horizon <= span[0]:
            continue
        axes.axvspan(
            horizon, span[1], facecolor="none", edgecolor=SHADE if alone else to_rgba(colour, 0.25),
            hatch=HATCHES[i % 2], linewidth=0, zorder=0, gid="beyond-trust",
        )  # fmt: skip
        axes.axvline(horizon, color=colour, linewidth=0.8, linestyle=(0, (1, 1.5)), gid="trust-horizon")
    return trust_remark(subjects, [span] * len(subjects), marked=True)


def mark_detail(axes: Axes, span: Span) -> None:
    """A frame about the span that another panel enlarges."""
    axes.axvspan(*span, facecolor="none", edgecolor="0.2", linewidth=0.7, zorder=3, gid="detail")
