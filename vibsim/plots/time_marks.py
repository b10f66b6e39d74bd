"""Marks on a time axis: where the impacts are, and until when the run is right."""

from __future__ import annotations

import numpy as np
from matplotlib.axes import Axes

from vibsim.plots.dense import samples_are_sparse
from vibsim.plots.impacts import impact_times
from vibsim.plots.samples import window_of
from vibsim.plots.sheet import note, pixel_columns
from vibsim.plots.style import GREY, SHADE
from vibsim.plots.subject import Subject
from vibsim.plots.view import Span


def annotate_run(axes: Axes, subject: Subject, span: Span, impacts: bool = True) -> None:
    """Ticks for the impacts (where wanted), the trust horizon, and a note above that names them."""
    remarks = [impact_ticks(axes, subject, span) if impacts else "", trust_mark(axes, subject, span)]
    remarks.append(
        f"samples every {subject.scene.sample_time(1):g} s" if samples_are_sparse(subject.scene) else ""
    )
    remarks.append("" if subject.result.complete else "incomplete run")
    note(axes, "; ".join(remark for remark in remarks if remark))


def impact_ticks(axes: Axes, subject: Subject, span: Span) -> str:
    """A tick below for every impact, as far as pixels can tell them apart; their number in words."""
    if not subject.scene.has_stop:
        return ""
    t = impact_times(subject.result, window_of(subject, span))
    pixel = ((t - span[0]) / (span[1] - span[0]) * pixel_columns(axes)).astype(int)
    seen = t[np.unique(pixel, return_index=True)[1]]
    axes.plot(
        seen, np.zeros(len(seen)), linestyle="none", marker=2, markersize=2.2, markeredgewidth=0.3,
        color="0.6", transform=axes.get_xaxis_transform(), gid="impacts",
    )  # fmt: skip
    return f"{len(t)} impact{'' if len(t) == 1 else 's'}"


def trust_mark(axes: Axes, subject: Subject, span: Span) -> str:
    """What lies beyond the trust horizon hatched, behind a dotted line; in words, empty where all is right.

    A span that lies beyond it as a whole is only said to.
    """
    horizon = subject.result.trust_horizon
    if horizon is None or horizon >= min(span[1], subject.result.t_reached):
        return ""
    if horizon <= span[0]:
        return f"beyond the trust horizon, {horizon:.4g} s"
    axes.axvspan(
        horizon, span[1], facecolor="none", edgecolor=SHADE, hatch="////", linewidth=0, zorder=0,
        gid="beyond-trust",
    )  # fmt: skip
    axes.axvline(horizon, color=GREY, linewidth=0.8, linestyle=(0, (1, 1.5)), gid="trust-horizon")
    return f"trust horizon {horizon:.4g} s (hatched beyond)"
