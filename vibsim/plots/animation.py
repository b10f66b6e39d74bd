"""Moving pictures: the machine itself beside its phase portrait and time history, as a film or a page."""

from __future__ import annotations

import os
import subprocess
from collections.abc import Callable, Iterator
from contextlib import ExitStack, suppress
from dataclasses import dataclass
from math import floor, log10
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from matplotlib.layout_engine import ConstrainedLayoutEngine

from vibsim.plots import style
from vibsim.plots.animated_machine import (
    Channels,
    Moving,
    channels_of,
    decimals_of,
    display_list,
    frame_of,
    speed_text,
)
from vibsim.plots.html_pages import packed, page
from vibsim.plots.samples import draw_stop_line, shortest_period, window_of
from vibsim.plots.sheet import scale_for, symbol
from vibsim.plots.style import BLUE, VERMILLION, dashed
from vibsim.plots.subject import PlotError, Span, Subject, open_subject
from vibsim.plots.traces import (
    columns_beside,
    dense,
    draw_trace,
    folded,
    label_relative,
    pair_of,
    trace,
    within_a_turn,
)
from vibsim.results.hdf5_reading import DISK_FULL, ResultFileError
from vibsim.results.labelled import MissingExtra, extra
from vibsim.results.output_files import output_file
from vibsim.signals import held_back

# Frames of a moving picture, drawn upon a background that is drawn once.


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
    scales = scale_for(pair.units[0], x), scale_for(pair.units[1], y)
    curve = trace(subject.result, pair.names, pair.plane, span)
    if pair.whole_turns:
        curve, x = folded(curve), within_a_turn(x)
    draw_trace(portrait, curve, scales, color=BLUE)
    for position, name in pair.stops:
        draw_stop_line(portrait, position, scales[0], name)
    portrait.margins(0.06)
    label_relative(portrait, pair, scales)
    columns = columns_beside(subject, pair)
    smooth = dense(subject.result, columns, span)
    scale = scale_for(pair.units[0], *(smooth[name] for name in columns))
    for i, name in enumerate(columns):
        look = {"linewidth": 0.8, "label": symbol(name), "gid": name, **dashed(i)}
        history.plot(smooth["time"], scale(smooth[name]), **look)
    history.legend(loc="lower left", bbox_to_anchor=(0, 1.02), ncols=len(columns))
    history.set_xlim(channels.times[0], channels.times[-1])
    history.set_xlabel("Time (s)")
    history.set_ylabel(scale.label(subject.word("m", columns[0]).capitalize()))
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


# Write a moving picture: MP4 through ffmpeg, GIF, or a page.


SUFFIXES = (".mp4", ".gif", ".html")
FRAMES_PER_SECOND = {".mp4": 30, ".gif": 20, ".html": 60}
COMFORTABLE = 5.0  # seconds of a film
SHOWN = 10.0  # seconds of motion where no window is asked for: the last ones
SIZES = {".mp4": ((1280, 720), 120), ".gif": ((800, 480), 92)}  # px, and dots per inch
Watch = Callable[[int, int], None]


@dataclass(frozen=True)
class FilmWish:
    """A film that is asked for: span [s], and seconds of it per second of film (None: `comfortable`)."""

    window: Span | None = None
    speed: float | None = None


@dataclass(frozen=True)
class Written:
    """A film that was written: number of frames, and seconds of motion per second of film."""

    frames: int
    speed: float


def animate(path: str, out: str, wish: FilmWish, force: bool = False, watch: Watch | None = None) -> Written:
    """Write the moving picture of the run in a file; what it came to.

    watch : called with the number of frames written and of all

    Raises PlotError for what is no run, another format, a window outside it or a missing encoder, and
    ResultFileError where the file cannot be written.
    """
    suffix = Path(out).suffix.lower()
    if suffix not in SUFFIXES:
        raise PlotError(f"{out}: a moving picture is .mp4, .gif or .html")
    subject = open_subject(path)
    if subject.reads != "trajectory":
        raise PlotError(f"{path} is a {subject.reads}, and a moving picture shows a run")
    encoder = _encoder(out) if suffix == ".mp4" else ""
    window = window_of(subject, wish.window)
    speed = comfortable(window[1] - window[0]) if wish.speed is None else wish.speed
    if wish.window is None:
        window = max(window[0], window[1] - SHOWN * max(speed, 1.0)), window[1]

    step = speed / FRAMES_PER_SECOND[suffix]
    if suffix == ".html":
        return Written(write_moving_page(subject, window, speed, out, force), speed)
    if window[1] - window[0] < step:
        raise PlotError(
            f"{out}: {window[1] - window[0]:.3g} s are one frame at this speed; {slower_advice(window)}"
        )
    with style.applied():
        film = Film(subject, channels_of(subject, window, step, speed), speed, *SIZES[suffix])
        frames = _watched(film, watch)
        if suffix == ".mp4":
            _write_mp4(frames, film, out, force, encoder)
        else:
            _write_gif(frames, out, force)
    return Written(len(film.channels.times), speed)


def comfortable(length: float) -> float:
    """Real time for what lasts at least COMFORTABLE [s]; for less, so much slower (2, 5, 10, 20 ... times)
    that the film does.
    """
    if not 0 < length < COMFORTABLE:
        return 1.0
    power = 10.0 ** floor(log10(COMFORTABLE / length))
    return 1 / next(factor * power for factor in (1, 2, 5, 10) if factor * power * length >= COMFORTABLE)


def slower_advice(window: Span) -> str:
    """Advice on how to get a film of a span [s] that is long enough to be looked at."""
    return f"--speed {(window[1] - window[0]) / COMFORTABLE:.1g} makes it some {COMFORTABLE:g} s long"


def too_short(out: str, written: Written) -> str:
    """Advice that makes a film of less than a second longer; empty for a longer film, and for a page."""
    suffix = Path(out).suffix.lower()
    if suffix == ".html" or written.frames >= FRAMES_PER_SECOND[suffix]:
        return ""
    return f"; {slower_advice((0.0, (written.frames - 1) * written.speed / FRAMES_PER_SECOND[suffix]))}"


def _watched(film: Film, watch: Watch | None) -> Iterator[np.ndarray]:
    total = len(film.channels.times)
    for number, frame in enumerate(film.frames(), 1):
        yield frame
        if watch is not None:
            watch(number, total)


def _encoder(out: str) -> str:
    """The program ffmpeg: the one on the path, else that of the package imageio-ffmpeg."""
    import shutil

    own = shutil.which("ffmpeg")
    if own:
        return own
    try:
        return str(extra("imageio_ffmpeg", "video").get_ffmpeg_exe())
    except (MissingExtra, RuntimeError) as error:
        raise PlotError(f"{out}: {error}; or write a .gif or .html") from None


def _write_mp4(frames: Iterator[np.ndarray], film: Film, out: str, force: bool, encoder: str) -> None:
    """H.264 in a container that plays while it loads; frames go to ffmpeg one by one."""
    width, height = film.canvas.get_width_height()
    source = f"-f rawvideo -pix_fmt rgb24 -s {width}x{height} -r {FRAMES_PER_SECOND['.mp4']} -i -"
    target = "-an -c:v libx264 -crf 20 -pix_fmt yuv420p -movflags +faststart -map_metadata -1 -f mp4"
    with output_file(out, force) as file, ExitStack() as at_the_end:
        command = [encoder, "-y", "-loglevel", "error", *source.split(), *target.split(), str(file.name)]
        with held_back():
            process = subprocess.Popen(command, stdin=subprocess.PIPE, stderr=subprocess.PIPE)
            at_the_end.callback(_end, process)
        assert process.stdin is not None
        with suppress(BrokenPipeError):  # it says on stderr why it ended
            for frame in frames:
                process.stdin.write(frame.tobytes())
        _, messages = process.communicate()
        if process.returncode:
            raise ResultFileError(f"{out}: {_why_ffmpeg_failed(messages.decode('utf-8', 'replace'))}")


def _end(process: subprocess.Popen[bytes]) -> None:
    """End a process, and close its pipes."""
    with held_back():
        process.kill()
        for pipe in (process.stdin, process.stderr):
            with suppress(OSError):  # what waits in a pipe that nobody reads
                if pipe is not None:
                    pipe.close()
        process.wait()


def _why_ffmpeg_failed(messages: str) -> str:
    """Reason why ffmpeg failed, in one line, from its messages."""
    if any(os.strerror(number) in messages for number in DISK_FULL):
        return "cannot write: disk full"
    return f"ffmpeg failed: {''.join(messages.strip().splitlines()[:1])[:200]}"


def _write_gif(frames: Iterator[np.ndarray], out: str, force: bool) -> None:
    """A GIF that repeats, in the colours of its first frame and few more."""
    from PIL import Image

    pictures = (Image.fromarray(frame).quantize(64, Image.Quantize.FASTOCTREE) for frame in frames)
    first = next(pictures)
    with output_file(out, force) as file:
        first.save(
            file, format="GIF", save_all=True, append_images=pictures, loop=0,
            duration=1000 // FRAMES_PER_SECOND[".gif"],
        )  # fmt: skip


# The moving machine as a page: the display list, the channels over time, a clock to turn.


KEYS = (
    "Space: go or stop. Arrows: a step back or forth. + and -: faster or slower. 0: from the beginning. "
    "d: light or dark."
)
FRAMES = 60  # that a browser shows in a second
PER_PERIOD = 16  # instants to the shortest period; between them the page goes along straight lines
MOST = 40_000  # instants
NOTHING = 1e-12


def write_moving_page(subject: Subject, window: Span, speed: float, out: str, force: bool) -> int:
    """Write the page; the number of instants in it. Raises ResultFileError."""
    step = min((shortest_period(subject.scene) or 1.0) / PER_PERIOD, min(speed, 1.0) / FRAMES)
    step = max(step, (window[1] - window[0]) / MOST)
    channels = channels_of(subject, window, step, speed)
    text = page(subject, ("animate.js",), KEYS, moving_data(subject, channels, step, speed))
    with output_file(out, force, "utf-8") as file:
        file.write(text)
    return len(channels.times)


def moving_data(subject: Subject, channels: Channels, step: float, speed: float) -> dict[str, Any]:
    """The data of `animate.js`."""
    pair = pair_of(subject)
    x, v = pair.plane({**channels.states, "time": channels.times})
    scales = scale_for(pair.units[0], x), scale_for(pair.units[1], v)
    names = columns_beside(subject, pair)
    scale = scale_for(pair.units[0], *(channels.states[name] for name in names))
    return {
        "begin": float(channels.times[0]),
        "step": step,
        "decimals": decimals_of(channels.times),
        "count": len(channels.times),
        "speed": speed,
        "channels": len(channels.names),
        "values": packed(channels.values, "f4"),
        "lit": packed(channels.lit, "i1"),
        "stops": [element.key for element in channels.stage.stops],
        "frame": frame_of(channels.stage, channels.values[:, : len(channels.stage.bodies)]),
        "shapes": [_shape(moving) for moving in display_list(channels)],
        "portrait": {
            "x": packed(scales[0](x), "f4"),
            "y": packed(scales[1](v), "f4"),
            "xLabel": scales[0].label(pair.words[0].lower()),
            "yLabel": scales[1].label(pair.words[1].lower()),
            "stops": [float(scales[0](position)) for position, _ in pair.stops],
        },
        "history": {
            "label": scale.label(subject.word("m", names[0])),
            "unit": scale.unit,
            "curves": [{"name": name, "data": packed(scale(channels.states[name]), "f4")} for name in names],
        },
    }


def _shape(moving: Moving) -> dict[str, Any]:
    """A shape, and by channel the coefficients that are not 0."""
    shape = moving.shape
    moved = [
        [number, np.round(each, 6).ravel().tolist()]
        for number, each in enumerate(moving.coefficients)
        if np.abs(each).max(initial=0.0) > NOTHING
    ]
    return {
        "kind": shape.kind,
        "key": shape.key,
        "at": np.round(shape.vertices, 5).ravel().tolist(),
        "moved": moved,
        **shape.look,
    }
