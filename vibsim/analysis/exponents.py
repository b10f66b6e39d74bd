"""Lyapunov exponents of a case: how well they are known, and what speaks against them.

    spectrum = vibsim.lyapunov(vibsim.load_case("II-B"))
    spectrum.exponents, spectrum.half_widths, spectrum.warnings

A positive one means chaos. Two exponents that are 0 by construction are left out: that of a shift of both
blocks, and with an ideal source that of time. A motor has no explicit time: one of its exponents is 0 too,
that of the motion's own direction, as is every exponent of a motion that neither settles nor parts; such
ones approach 0 like log(t) / t.
"""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from math import hypot, isfinite, nan
from typing import TYPE_CHECKING

import numpy as np

from vibsim.analysis.cycles import transient
from vibsim.analysis.regime import exponent_of
from vibsim.cases.case import by_key, load_case, whole_number
from vibsim.cases.quantities import number
from vibsim.engine.tangent.lyapunov import LyapunovExponents, lyapunov_exponents
from vibsim.engine.tangent.tangent_space import dimension
from vibsim.results.labelled import Shown
from vibsim.results.result import Result

if TYPE_CHECKING:
    from vibsim.cases.case import CaseLike

UNIT_ROUNDOFF = 2.0**-53
CLEARLY = 2.0  # blocks of chaotic motion scatter more than ten of them tell
SETTLED = 10.0  # by which the logarithms of the growth in two halves of a span may differ without a trend
PIECE = 400  # what a piece adds to the volume residual at most, in units of the tolerance: 1 to 10 were met


@dataclass(frozen=True, repr=False)
class Lyapunov(Shown):
    """Lyapunov exponents over a span of a motion, the largest first.

    Attributes
    ----------
    exponents : growth rates of small disturbances [1/s] over the span; -inf where sticking or rest took the
        direction, NaN where the motion has no derivative
    half_widths : of their 95 % intervals [1/s], from the scatter of ten blocks of the span; NaN where the
        span is too short for that
    span : begin and end [s]
    times, running : times [s] and the exponents over the span up to each of them, shape (times, exponents)
    finite_time : exponents over the time between each two neighbouring `times`, one row less
    rank_losses : directions that sticking and rest took
    volume_residual : what is missing in the identity of Liouville [-]; NaN without all exponents
    warnings : what speaks against the exponents, in sentences

    >>> import vibsim
    >>> case = vibsim.load_case("gallery/friction-oscillator", {"run.t_end": "100 s"})
    >>> spectrum = vibsim.lyapunov(case)
    >>> spectrum.exponents.round(2), spectrum.span, spectrum.rank_losses
    (array([-0.08, -0.36]), (50.0, 100.0), 0)
    """

    exponents: np.ndarray
    half_widths: np.ndarray
    span: tuple[float, float]
    times: np.ndarray
    running: np.ndarray
    finite_time: np.ndarray
    rank_losses: int
    volume_residual: float
    warnings: tuple[str, ...]

    def heading(self) -> str:
        """The number of exponents, and the span."""
        noun = "exponent" if len(self.exponents) == 1 else "exponents"
        return f"{len(self.exponents)} {noun} over {self.span[0]:.5g} to {self.span[1]:.5g} s"

    def lines(self) -> list[tuple[str, str]]:
        """The exponents with their intervals, and what speaks against them."""
        pairs = zip(self.exponents, self.half_widths, strict=True)
        lines = [
            (
                "exponents",
                ", ".join(f"{number(one, 4)} +- {number(half, 2)}" for one, half in pairs) + " 1/s",
            )
        ]
        if not np.isnan(self.volume_residual):
            lines.append(("volume", f"residual {number(self.volume_residual, 2)}"))
        return [*lines, *(("warning", text) for text in self.warnings)]


def lyapunov(
    case: "CaseLike",
    overrides: Mapping[str, object] | None = None,
    *,
    count: int | str | None = None,
    discard: float | str | None = None,
    engine: str = "auto",
) -> Lyapunov:
    """The largest `count` Lyapunov exponents of a case, "all" or None: all of them.

    case, overrides : as of `load_case`
    discard : time [s] left out at the start, for the motion to settle, or a text such as "50 %"; None: half

    Raises ValueError for more exponents than the case has and for a transient that leaves nothing,
    EngineError (in `vibsim.engine.errors`) when the run fails.

    Of a damped oscillator x'' + c x' + x = cos(w t) that never meets its stop both are -c/2:

    >>> import vibsim
    >>> changes = {"links.spring.c": "0.2 N s/m", "stops.wall.gap": "50 m", "run.t_end": "200 s"}
    >>> vibsim.lyapunov("gallery/bilinear-oscillator", changes).exponents.round(3)
    array([-0.1, -0.1])
    """

    scene = load_case(case, by_key("overrides", overrides, '{"Omega0": "6.5 Hz"}')).scene()
    number = None if count is None or count == "all" else whole_number("count", count, 0)
    if number is not None and not 1 <= number <= dimension(scene):
        raise ValueError(f"count must be 1 to {dimension(scene)} for this case, got {count}")
    begin = transient(discard, scene.t_end)
    if not 0 <= begin < scene.t_end:
        raise ValueError(f"a transient of {begin:g} s leaves nothing of {scene.t_end:g} s")
    return judged(lyapunov_exponents(scene, number, begin, engine), scene.tol)


def stored_exponents(result: Result) -> Lyapunov | None:
    """The exponents that a run took along (`vibsim run --lyapunov`); None where it took none."""
    attrs = {name.removeprefix("lyapunov_"): value for name, value in result.attrs.items()}
    if "growth" not in attrs:
        return None
    exponents = LyapunovExponents(
        exponents=attrs["exponents"],
        growth=attrs["growth"],
        rank_losses=attrs["rank_losses"],
        volume_residual=attrs.get("volume_residual", nan),
        tangencies=attrs["tangencies"],
        closest_tangency=attrs["closest_tangency"],
        closest_tangency_time=attrs.get("closest_tangency_time", nan),
        tangent_pieces=attrs["pieces"],
        undefined_time=attrs.get("undefined_time", nan),
    )
    return judged(exponents, attrs.get("taylor_tolerance", UNIT_ROUNDOFF))


def judged(lyapunov: LyapunovExponents, tolerance: float) -> Lyapunov:
    """Intervals and warnings for exponents as they come; tolerance: of the Taylor flow."""
    growth = lyapunov.growth
    times, sums = growth[:, 0], growth[:, 1:]
    with np.errstate(invalid="ignore"):  # -inf less -inf, in a direction that sticking took
        finite_time = np.diff(sums, axis=0) / np.diff(times)[:, None]
        finite_time[np.isneginf(sums[1:])] = -np.inf
    return Lyapunov(
        exponents=lyapunov.exponents,
        half_widths=np.array([_half_width(times, column) for column in sums.T]),
        span=lyapunov.span,
        times=times[1:],
        running=sums[1:] / (times[1:] - times[:1])[:, None],
        finite_time=finite_time,
        rank_losses=lyapunov.rank_losses,
        volume_residual=lyapunov.volume_residual,
        warnings=tuple(_warnings(lyapunov, tolerance)),
    )


def _half_width(times: np.ndarray, growth: np.ndarray) -> float:
    known = exponent_of(times, growth)
    return known.half_width if known else float("nan")


def _warnings(lyapunov: LyapunovExponents, tolerance: float) -> Iterator[str]:
    if len(lyapunov.growth) < 2:
        yield "the run ended before the span of the exponents began"
    else:
        yield from _trend(lyapunov.growth[:, 0], lyapunov.growth[:, 1])
    if isfinite(lyapunov.undefined_time):
        yield (
            f"exponents are undefined: at {lyapunov.undefined_time:.6g} s the motion grazes a rigid stop or"
            " strikes several at one instant"
        )
    if lyapunov.tangencies:
        yield (
            f"{lyapunov.tangencies} events crossed almost tangentially, the closest at"
            f" {lyapunov.closest_tangency_time:.6g} s: first order holds there for tiny disturbances only"
        )
    bound = PIECE * max(tolerance, UNIT_ROUNDOFF) * lyapunov.tangent_pieces
    if abs(lyapunov.volume_residual) > bound:
        yield (
            f"volumes grow by exp({number(lyapunov.volume_residual, 2)}) more than the equations of motion"
            " let them: the exponents are not right"
        )


def _trend(times: np.ndarray, growth: np.ndarray) -> Iterator[str]:
    """A warning where the largest exponent differs clearly between the halves of the span."""
    middle = len(times) // 2
    halves = [exponent_of(times[part], growth[part]) for part in (slice(middle + 1), slice(middle, None))]
    if halves[0] is None or halves[1] is None:
        return
    apart = abs(halves[1].value - halves[0].value)
    by_chance = hypot(halves[0].half_width, halves[1].half_width)
    if apart > max(CLEARLY * by_chance, 2 * SETTLED / (times[-1] - times[0])):
        yield (
            f"the largest exponent is {number(halves[0].value, 3)} 1/s before {times[middle]:.4g} s and"
            f" {number(halves[1].value, 3)} 1/s after it: the motion has not settled"
        )
