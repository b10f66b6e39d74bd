"""The moving machine as a page: the display list, the channels over time, a clock to turn."""

from __future__ import annotations

from typing import Any

import numpy as np

from vibsim.files.output_file import output_file
from vibsim.plots.animation.channels import Channels, channels_of, decimals_of
from vibsim.plots.animation.display_list import Moving
from vibsim.plots.animation.sketch import display_list, frame_of
from vibsim.plots.live.html_file import packed, page
from vibsim.plots.motion.natural_frequencies import shortest_period
from vibsim.plots.motion.pairs import pair_of
from vibsim.plots.page.quantities import scale_for
from vibsim.plots.subject import Subject
from vibsim.plots.view import Span

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
    scales = scale_for("m", x), scale_for("m/s", v)
    names = subject.columns_in("m")
    scale = scale_for("m", *(channels.states[name] for name in names))
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
            "xLabel": scales[0].label("relative displacement"),
            "yLabel": scales[1].label("relative velocity"),
            "stops": [float(scales[0](position)) for position, _ in pair.stops],
        },
        "history": {
            "label": scale.label("displacement"),
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
