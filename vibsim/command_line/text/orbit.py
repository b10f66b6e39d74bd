"""A periodic orbit for people (lines) and for programs (JSON)."""

from collections.abc import Iterable
from math import inf
from typing import Any

from vibsim.cases.number import number
from vibsim.command_line.terminal.printing import style
from vibsim.command_line.text.multipliers import multiplier_text
from vibsim.command_line.text.quantities import counted, metres
from vibsim.orbits.multipliers import sides_of_circle
from vibsim.orbits.orbit import Orbit
from vibsim.orbits.returns.word import LETTERS
from vibsim.orbits.stability import neighbours
from vibsim.physics.modes import IMPACTS

Lines = list[tuple[str, str]]


def orbit_lines(orbit: Orbit, digits: Any = None) -> Lines:
    """Label and text of all that is known of an orbit."""
    lines = [
        ("period", period_text(orbit)),
        *_drift(orbit),
        ("events", events_text(orbit)),
        ("state", ", ".join(f"{name} {number(value, 10)}" for name, value in orbit.coordinates.items())),
        ("", f"in {', '.join(orbit.end.coordinates.units)}, on the section {section_text(orbit)}"),
        ("multipliers", multipliers_text(orbit)),
        ("stability", stability_text(orbit)),
        ("exponents", f"{', '.join(number(value, 5) for value in orbit.exponents)} 1/s"),
        ("margins", margins_text(orbit)),
        ("energy", energy_text(orbit.energy)),
        (
            "residual",
            f"{number(orbit.residual, 2)} m/s after {counted(orbit.solution.steps, 'Newton step')}",
        ),
        ("certificate", certificate_text(orbit)),
    ]
    return lines + (digits.lines() if digits is not None else [])


def _drift(orbit: Orbit) -> Lines:
    texts = [f"{metres(value)} of {name}" for name, value in orbit.drift.items()]
    return [("drift", f"{', '.join(texts)} per period")] if texts else []


def period_text(orbit: Orbit) -> str:
    """Period, frequency, and how many of the source's it takes."""
    section = orbit.return_map.section
    what, _, whose = section.of_return.partition(" ")
    count = f"{counted(orbit.n, what)} {whose}"
    order = "" if orbit.n == 1 or section.turning else f", order 1/{orbit.n}"
    return f"{orbit.period:.12g} s, {1 / orbit.period:.10g} Hz: {count}{order}"


def section_text(orbit: Orbit) -> str:
    """Where the state is taken."""
    return str(orbit.return_map.section.place)


def counts_of(orbit: Orbit) -> dict[str, int]:
    """Impacts, sticks and reversals of one period."""
    kinds = [kind for kind, _ in orbit.events]
    return {
        "impacts": sum(kind in IMPACTS for kind in kinds),
        "sticks": kinds.count("stick_begin"),
        "reversals": kinds.count("reversal"),
    }


def events_text(orbit: Orbit) -> str:
    """The word and its counts."""
    counts = ", ".join(counted(number, name.removesuffix("s")) for name, number in counts_of(orbit).items())
    return f"{orbit.spelled or 'none'}: {counts}"


def multipliers_text(orbit: Orbit) -> str:
    """All of them, conjugate pairs once."""
    return ", ".join(multiplier_text(mu) for mu in orbit.multipliers.tolist() if mu.imag >= 0)


def stability_text(orbit: Orbit) -> str:
    """Whether it is stable, and which bifurcations are near."""
    _, on_circle, outside = sides_of_circle(orbit.multipliers)
    stability = "stable"
    if outside:
        stability = style(f"unstable: {counted(outside, 'multiplier')} outside", fg="yellow")
    elif on_circle:
        stability = style(
            f"undecided by first order: {counted(on_circle, 'multiplier')} on the unit circle", fg="yellow"
        )
    near = [neighbour.text for neighbour in neighbours(orbit)]
    return "; ".join([stability, *near])


def margins_text(orbit: Orbit) -> str:
    """Smallest gap at a turn without contact; force between a reversal and sticking, or a stick and slip."""
    gap = "no turn of a gap" if orbit.margin == inf else f"{metres(orbit.margin)} at a turn of a gap"
    force = (
        "no sliding velocity at 0"
        if orbit.sliding == inf
        else f"{number(orbit.sliding, 4)} N between slip and stick"
    )
    return f"{gap}; {force}"


def energy_text(energy: dict[str, float]) -> str:
    """What goes in and what is lost in one period."""
    names = {"work_source": "source", "work_base": "base", "work_belt": "belts"}
    names |= {"loss_viscous": "dampers", "loss_stops": "stops", "loss_friction": "friction"}
    parts = {
        kind: [
            f"{name} {number(energy[key], 5)}"
            for key, name in names.items()
            if key.startswith(kind) and energy[key]
        ]
        for kind in ("work", "loss")
    }
    gained, lost = (", ".join(each) or "nothing" for each in parts.values())
    return f"in: {gained}; lost: {lost}; J per period"


def certificate_text(orbit: Orbit) -> str:
    """Whether every event of it is proved."""
    return "no event missed, none invented" if orbit.certified else style("an event is in doubt", fg="yellow")


def orbit_row(orbit: Orbit) -> str:
    """One orbit of a list."""
    of = orbit.return_map.section.of_return.partition(" ")[0]
    stability = "stable" if orbit.stable else "unstable"
    largest = number(abs(orbit.multipliers).max(initial=0.0), 6)
    return (
        f"{counted(orbit.n, of)}, {orbit.period:.10g} s, {stability} (largest multiplier {largest}), "
        f"{orbit.spelled or 'no events'}"
    )


def orbit_object(orbit: Orbit, digits: Any = None) -> dict[str, Any]:
    """An orbit for JSON: numbers in SI, multipliers as [re, im]."""
    drifts = orbit.drift
    facts = {
        "case": orbit.case.name if orbit.case else None,
        "n": orbit.n,
        "period": orbit.period,
        "frequency": 1 / orbit.period,
        "state": orbit.state,
        "coordinates": orbit.coordinates,
        "points": [orbit.end.coordinates.named(point) for point in orbit.points],
        "multipliers": pairs(orbit.multipliers.tolist()),
        "exponents": orbit.exponents,
        "stable": orbit.stable,
        "near": [{"kind": one.kind, "multiplier": [one.mu.real, one.mu.imag]} for one in neighbours(orbit)],
        "events": orbit.spelled,
        "letters": LETTERS,
        **counts_of(orbit),
        "drift": max(drifts.values(), key=abs, default=0.0),
        "drifts": drifts,
        "grazing_margin": orbit.margin,
        "sliding_margin": orbit.sliding,
        "energy": orbit.energy,
        "residual": orbit.residual,
        "newton_steps": orbit.solution.steps,
        "certified": orbit.certified,
    }
    return facts | (digits.object() if digits is not None else {})


def pairs(multipliers: Iterable[complex]) -> list[list[float]]:
    """[re, im] of each."""
    return [[mu.real, mu.imag] for mu in multipliers]
