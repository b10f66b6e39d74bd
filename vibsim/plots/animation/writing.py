"""Write a moving picture: MP4 through ffmpeg, GIF, or a page."""

from __future__ import annotations

import os
import subprocess
from collections.abc import Callable, Iterator
from contextlib import ExitStack, suppress
from dataclasses import dataclass
from math import floor, log10
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from vibsim.files.disk_space import DISK_FULL
from vibsim.files.errors import ResultFileError
from vibsim.files.output_file import output_file
from vibsim.files.signals import held_back
from vibsim.labelled.extras import MissingExtra, extra
from vibsim.plots import style
from vibsim.plots.errors import PlotError
from vibsim.plots.motion.samples import window_of
from vibsim.plots.subject import open_subject
from vibsim.plots.view import Span

if TYPE_CHECKING:
    from vibsim.plots.animation.film import Film

SUFFIXES = (".mp4", ".gif", ".html")
FRAMES_PER_SECOND = {".mp4": 30, ".gif": 20, ".html": 60}
COMFORTABLE = 5.0  # seconds of a film
SHOWN = 10.0  # seconds of motion where no window is asked for: the last ones
SIZES = {".mp4": ((1280, 720), 120), ".gif": ((800, 480), 92)}  # px, and dots per inch
Watch = Callable[[int, int], None]


@dataclass(frozen=True)
class Wish:
    """What to show: the span [s], and how many seconds of it per second of the film (None: `comfortable`)."""

    window: Span | None = None
    speed: float | None = None


@dataclass(frozen=True)
class Written:
    """What a film came to: the number of its frames, and the seconds of motion per second of it."""

    frames: int
    speed: float


def animate(path: str, out: str, wish: Wish, force: bool = False, watch: Watch | None = None) -> Written:
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
    from vibsim.plots.animation.channels import channels_of

    step = speed / FRAMES_PER_SECOND[suffix]
    if suffix == ".html":
        from vibsim.plots.animation.page import write_moving_page

        return Written(write_moving_page(subject, window, speed, out, force), speed)
    if window[1] - window[0] < step:
        raise PlotError(
            f"{out}: {window[1] - window[0]:.3g} s are one frame at this speed; {slower_advice(window)}"
        )
    with style.applied():
        from vibsim.plots.animation.film import Film

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
    """How to have a film of a span [s] that is long enough to be looked at."""
    return f"--speed {(window[1] - window[0]) / COMFORTABLE:.1g} makes it some {COMFORTABLE:g} s long"


def too_short(out: str, written: Written) -> str:
    """What makes a film of less than a second longer, in words; empty for a longer one, and for a page."""
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
    """What its messages come to, in one line."""
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
