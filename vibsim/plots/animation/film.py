"""Frames of a moving picture, drawn upon a background that is drawn once."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from matplotlib.layout_engine import ConstrainedLayoutEngine

from vibsim.plots.animation.channels import Channels, decimals_of, speed_text
from vibsim.plots.animation.display_list import Moving
from vibsim.plots.animation.sketch import display_list, frame_of
from vibsim.plots.motion.dense import dense
from vibsim.plots.motion.pairs import label_relative, pair_of
from vibsim.plots.motion.relative_motion import draw_stop_line
from vibsim.plots.motion.trace import draw_trace, trace
from vibsim.plots.page.quantities import scale_for, symbol
from vibsim.plots.style import BLUE, VERMILLION, dashed
from vibsim.plots.subject import Subject

LIT = "#FFC400"  # of a stop in contact
WIDE = 4.0  # width over height of a machine from which it takes the whole width
CLOCK_PT, CLOCK_ROOM = 8, 1.8  # size of the clock, and lines that are left free for it
CM_PER_INCH = 2.54


class Film:
    """The picture at each frame.

    size : width and height [px]; dpi : dots per inch, which sets the size of the text
    """

    def __init__(self, subject: Subject, channels: Channels, speed: float, size: tuple[int, int], dpi: int):
        self.channels = channels
        self.figure = Figure(figsize=(size[0] / dpi, size[1] / dpi), dpi=dpi, layout="constrained")
        self.canvas = FigureCanvasAgg(self.figure)
        self._machine, self._portrait, self._history = self._axes(subject)
        self.still = _still(subject, channels, self._portrait, self._history)
        self.shapes = display_list(channels)
        self._artists = [_artist(self._machine, moving) for moving in self.shapes]
        self._stops = [element.key for element in channels.stage.stops]
        self._dot = self._portrait.plot([], [], "o", color=VERMILLION, markersize=5, animated=True)[0]
        self._line = self._history.axvline(channels.times[0], color=VERMILLION, linewidth=1.0, animated=True)
        self._clock = self.figure.text(0.01, 0.99, "", va="top", fontsize=CLOCK_PT, animated=True)
        self._said, self._decimals = speed_text(speed), decimals_of(channels.times)
        self.canvas.draw()
        self._fit_words(dpi)
        self._background = self.canvas.copy_from_bbox(self.figure.bbox)

    def _axes(self, subject: Subject) -> tuple[Any, Any, Any]:
        """Of the machine, the portrait and the history: a wide machine stands above both."""
        left, low, right, high = frame_of(self.channels.stage, self.channels.values[:, : self._ends()])
        wide = right - left > WIDE * (high - low)
        grid = self.figure.add_gridspec(
            2, 2, width_ratios=(1.7, 1), height_ratios=(1, 1.3) if wide else (1.3, 1)
        )
        cells = (grid[0, :], grid[1, 1], grid[1, 0]) if wide else (grid[0, 0], grid[0, 1], grid[1, :])
        machine, portrait, history = (self.figure.add_subplot(cell) for cell in cells)
        machine.set_axis_off()
        machine.set_aspect("equal")
        machine.set_xlim(left, right)
        machine.set_ylim(low, high)
        engine = self.figure.get_layout_engine()
        assert isinstance(engine, ConstrainedLayoutEngine)
        above = CLOCK_ROOM * CLOCK_PT / 72 / self.figure.get_figheight()
        engine.set(rect=(0, 0, 1, 1 - above))
        return machine, portrait, history

    def _fit_words(self, dpi: int) -> None:
        """Make the words of a machine that is drawn smaller than its still drawing smaller, too."""
        left, right = self._machine.get_xlim()
        scale = self._machine.get_window_extent().width / (right - left) / (dpi / CM_PER_INCH)
        for artist, moving in zip(self._artists, self.shapes, strict=True):
            if moving.shape.kind == "text":
                artist.set_fontsize(min(scale, 1.0) * moving.shape.look["size"])

    def _ends(self) -> int:
        return len(self.channels.stage.bodies)

    def frames(self) -> Iterator[np.ndarray]:
        """The frames one by one, each (height, width, 3) bytes."""
        for number in range(len(self.channels.times)):
            yield self.frame(number)

    def frame(self, number: int) -> np.ndarray:
        """One frame (height, width, 3), bytes."""
        channels = self.channels
        self.canvas.restore_region(self._background)
        lit = {key for key, on in zip(self._stops, channels.lit[number], strict=True) if on}
        for moving, artist in zip(self.shapes, self._artists, strict=True):
            _move(artist, moving, channels.values[number], moving.shape.key in lit)
            self._machine.draw_artist(artist)
        x, y = self.still
        self._dot.set_data([x[number]], [y[number]])
        self._portrait.draw_artist(self._dot)
        self._line.set_xdata([channels.times[number]] * 2)
        self._history.draw_artist(self._line)
        self._clock.set_text(f"t = {channels.times[number]:.{self._decimals}f} s, {self._said}")
        self.figure.draw_artist(self._clock)
        return np.array(np.asarray(self.canvas.buffer_rgba())[..., :3])


def _still(
    subject: Subject, channels: Channels, portrait: Any, history: Any
) -> tuple[np.ndarray, np.ndarray]:
    """Draw portrait and history; the points of the portrait at the frames, as drawn."""
    span = float(channels.times[0]), float(channels.times[-1])
    pair = pair_of(subject)
    x, y = pair.plane({**channels.states, "time": channels.times})
    scales = scale_for("m", x), scale_for("m/s", y)
    draw_trace(portrait, trace(subject.result, pair.names, pair.plane, span), scales, color=BLUE)
    for position, name in pair.stops:
        draw_stop_line(portrait, position, scales[0], name)
    portrait.margins(0.06)
    label_relative(portrait, pair, scales)
    columns = subject.columns_in("m")
    smooth = dense(subject.result, columns, span)
    scale = scale_for("m", *(smooth[name] for name in columns))
    for i, name in enumerate(columns):
        look = {"linewidth": 0.8, "label": symbol(name), "gid": name, **dashed(i)}
        history.plot(smooth["time"], scale(smooth[name]), **look)
    history.legend(loc="lower left", bbox_to_anchor=(0, 1.02), ncols=len(columns))
    history.set_xlim(channels.times[0], channels.times[-1])
    history.set_xlabel("Time (s)")
    history.set_ylabel(scale.label("Displacement"))
    return scales[0](x), scales[1](y)


def _artist(axes: Any, moving: Moving) -> Any:
    """The artist of a shape, not drawn with the background."""
    from matplotlib.patches import Polygon

    shape, look = moving.shape, moving.shape.look
    x, y = shape.vertices.T
    if shape.kind == "text":
        own = {"fontsize": look["size"], "color": look["colour"], "va": "center", "animated": True}
        own |= {name: look[name] for name in ("ha", "weight", "style") if look[name]}
        return axes.text(x[0], y[0], look["text"], clip_on=True, **own)
    if shape.kind == "area":
        fill = look["fill"] or "none"
        hatch = "////////" if look["hatch"] else None
        area = Polygon(shape.vertices, facecolor=fill, edgecolor=look["colour"], linewidth=look["width"])
        area.set(hatch=hatch, animated=True)
        return axes.add_patch(area)
    style = (0, (4, 2)) if look.get("dash") else "-"
    (line,) = axes.plot(x, y, color=look["colour"], linewidth=look["width"], linestyle=style, animated=True)
    return line


def _move(artist: Any, moving: Moving, channels: np.ndarray, lit: bool) -> None:
    """Put an artist where its shape is; a stop that is struck lights up."""
    vertices, shape = moving.at(channels), moving.shape
    if shape.kind == "area":
        artist.set_xy(vertices)
    elif shape.kind == "text":
        artist.set_position(vertices[0])
    else:
        artist.set_data(*vertices.T)
        if shape.key.startswith("stops."):
            artist.set_color(LIT if lit else shape.look["colour"])
            artist.set_linewidth(shape.look["width"] * (2.2 if lit else 1.0))
