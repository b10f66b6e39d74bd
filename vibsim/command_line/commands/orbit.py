"""vibsim orbit: the periodic motions of a case, stable or not."""

from collections.abc import Iterable
from contextlib import suppress
from dataclasses import dataclass
from math import inf
from pathlib import Path
from typing import Any

import click

from vibsim.cases import Case
from vibsim.cases.problems import counted
from vibsim.cases.quantities import number
from vibsim.command_line.commands.run import check_digits, hdf5_name, read_case
from vibsim.command_line.main import FILE_TROUBLE, told
from vibsim.command_line.options import (
    CASE,
    FILE,
    OrbitDigitCount,
    Settings,
    count_option,
    examples,
    set_option,
)
from vibsim.command_line.terminal import Progress, print_json, say, style
from vibsim.command_line.text import heading, metres, multiplier_text, print_lines, size
from vibsim.engine.columns import state_columns
from vibsim.orbits.orbit import Orbit, save_orbit
from vibsim.orbits.search import INITIAL, SearchTally, orbit, search_attempts
from vibsim.orbits.stability import neighbours, sides_of_circle
from vibsim.orbits.words import LETTERS
from vibsim.physics.parts import IMPACTS
from vibsim.results import Result, kind_of, names_a_result
from vibsim.results.hdf5_reading import ResultFileError
from vibsim.results.output_files import check_output
from vibsim.results.simulation import open_result
from vibsim.signals import Interruption, interrupted_with


@click.command(
    "orbit",
    short_help="Find periodic motions, stable or not, and their multipliers.",
    epilog=examples(
        "vibsim orbit I-A                              # where the run of the case goes to",
        "vibsim orbit II-B.h5 -o orbit.h5              # where a stored run goes to",
        "vibsim orbit II-B -s Omega0=5.1Hz --from orbit.h5   # the same orbit at another speed",
        "vibsim orbit I-A --at-start                   # near its initial state: another one",
        "vibsim orbit gallery/bilinear-oscillator --search 50 --seed 1",
        "vibsim orbit I-C --digits 40 --json",
        "vibsim run orbit.h5 --t-end 60s               # start on it",
        before="Events are spelled b e (contact begins, ends), r (reversal), s u (stick begins, ends), i t c "
        "(impact, impact passed on, chatter), h o (rest begins, ends), with the number of the part where "
        "there are several.",
    ),
)
@click.argument("source", metavar="CASE|FILE", type=CASE)
@set_option
@click.option("--from", "start", type=FILE, metavar="FILE", help="A stored orbit near which to look.")
@click.option(
    "--at-start",
    is_flag=True,
    help="Look near the initial state of the case, not where its run leads.",
)
@count_option(
    "--period", "Periods of the source, or turns of the motor. [default: as the run repeats itself]", least=1
)
@count_option("--search", "Look from K random starts, and list all orbits.", least=1, metavar="K")
@count_option("--seed", "Of the random starts. [default: 0]", metavar="S")
@click.option(
    "--digits", type=OrbitDigitCount(), metavar="D", help="Refine orbit and multipliers to so many digits."
)
@click.option("-o", "--output", type=FILE, metavar="FILE", help="Store the orbit; of several NAME-1.h5, ...")
@click.option("--force", is_flag=True, help="Replace existing output files.")
@click.pass_context
def command(
    ctx: click.Context,
    source: str,
    changes: tuple[tuple[str, str], ...],
    start: str | None,
    at_start: bool,
    period: int | None,
    search: int | None,
    seed: int | None,
    digits: int | None,
    output: str | None,
    force: bool,
) -> int:
    """Find the periodic orbit that CASE or the run in FILE goes to, by Newton's method on the return map.

    The section is phase 0 of forces and base, phi = 0 of a motor, or where a body turns round that nothing
    drives. The orbit need not be stable. It is
    periodic up to a drift of bodies that nothing ties to ground or base.
    """

    wish = OrbitWish(source, dict(changes), start, at_start, period, digits, output, force)
    wish.check()
    if at_start and (start is not None or search is not None):
        raise click.UsageError(
            f"--at-start is a start of its own; leave {'--from' if start else '--search'} out"
        )
    if search is None:
        if seed is not None:
            raise click.UsageError("--seed draws the starts of --search, which is not given")
        return find_one(wish, ctx.obj)
    if start is not None:
        raise click.UsageError("--search draws its own starts; leave --from out")
    return search_all(wish, search, seed or 0, ctx.obj)


# What `vibsim orbit` does: read, find, refine, store, print.


@dataclass(frozen=True)
class OrbitWish:
    """Options of a command line for an orbit."""

    source: str
    changes: dict[str, str]
    start: str | None
    at_start: bool
    period: int | None
    digits: int | None
    output: str | None
    force: bool

    def check(self) -> None:
        """Raises UsageError and ResultFileError before anything is computed."""
        check_digits(self.digits)
        if self.output is not None:
            check_output(hdf5_name(self.output), self.force)

    def subject(self) -> "Case | Result":
        """The run in a file, or a case. Raises CaseError and ResultFileError."""
        if names_a_result(self.source) and kind_of(self.source) == "trajectory":
            return _run(self.source)
        return read_case(self.source, {})

    def beginning(self) -> Result | None:
        """The stored orbit to start from."""
        if self.start is None:
            return None
        stored = _run(self.start)
        if stored.orbit is None:
            raise ResultFileError(f"{self.start}: holds a run and no orbit; give it in place of the case")
        return stored

    def check_likeness(self, case: Case, stored: Result | None) -> None:
        """Raise ResultFileError where the orbit to start from is one of other bodies than the case has."""
        if stored is None:
            return
        case = case.with_values(self.changes) if self.changes else case
        missing = [name for name in state_columns(case.scene()) if name not in stored]
        if missing:
            raise ResultFileError(
                f"{self.start}: holds an orbit of {stored.case.name}; to start from it, {case.name} also "
                f"needs {', '.join(missing)}"
            )


def _run(path: str) -> Result:
    if kind_of(path) != "trajectory":
        raise ResultFileError(f"{path}: holds no single run")
    result: Result = open_result(path)
    return result


@dataclass(frozen=True)
class OrbitRow:
    """An orbit, its many digits and its file, where they are asked for."""

    orbit: Orbit
    digits: Any
    file: str | None
    trouble: ResultFileError | None = None  # why there is no file

    @property
    def object(self) -> dict[str, Any]:
        """The orbit for programs."""
        return ({"file": self.file} if self.file else {}) | orbit_object(self.orbit, self.digits)

    @property
    def file_line(self) -> list[tuple[str, str]]:
        return [("file", f"{self.file} ({size(self.file)})")] if self.file else []


def find_one(wish: OrbitWish, settings: Settings) -> int:
    """Find one orbit and print it; returns the exit code."""
    subject, beginning = wish.subject(), wish.beginning()
    wish.check_likeness(subject.case if isinstance(subject, Result) else subject, beginning)
    with interrupted_with(lambda: f"{wish.output} is not written" if wish.output else ""):
        start = INITIAL if wish.at_start else beginning
        row = _kept(orbit(subject, wish.changes, start, wish.period), wish, wish.output)
    if settings.json:
        print_json(row.object | _error_object(row.trouble))
    elif not settings.quiet:
        case = row.orbit.case
        assert case is not None  # the wish names one
        say(heading(case.name, case.title))
        print_lines([*orbit_lines(row.orbit, row.digits), *row.file_line])
    return _code(row.trouble)


def _code(trouble: ResultFileError | None) -> int:
    """The exit code, and on stderr why an orbit that was printed is not stored."""
    return 0 if trouble is None else told(f"Error: {trouble}", FILE_TROUBLE, as_json=False)


def _error_object(trouble: ResultFileError | None) -> dict[str, Any]:
    """The same for programs."""
    return {} if trouble is None else {"error": {"message": str(trouble), "exit_code": FILE_TROUBLE}}


def _kept(orbit: Orbit, wish: OrbitWish, path: str | None) -> OrbitRow:
    """An orbit refined and stored; where its digits are not to be had, it is stored without them, and where
    it cannot be stored, it is there to be printed.
    """
    try:
        digits = _refined(orbit, wish)
    except BaseException as error:
        if path is not None:
            save_orbit(orbit, path, wish.force)
        if path is not None and isinstance(error, KeyboardInterrupt):
            raise type(error)(f"{path} holds the orbit without the digits") from error
        raise
    try:
        if path is not None:
            save_orbit(orbit, path, wish.force, digits)
    except ResultFileError as error:
        return OrbitRow(orbit, digits, None, error)
    return OrbitRow(orbit, digits, path)


def _refined(orbit: Orbit, wish: OrbitWish) -> Any:
    """The orbit in many digits, where they are asked for."""
    if wish.digits is None:
        return None
    from vibsim.orbits.orbit_digits import refine

    return refine(orbit, wish.digits)


def search_all(wish: OrbitWish, count: int, seed: int, settings: Settings) -> int:
    """Look from many starts and list what is there, each stored as it comes; returns the exit code."""
    _check_numbered(wish)
    subject = wish.subject()
    case = subject.case if isinstance(subject, Result) else subject
    case = case.with_values(wish.changes) if wish.changes else case
    rows, done, tally = list[OrbitRow](), 0, SearchTally()
    steps = Progress(not settings.quiet)
    with Interruption() as interruption, steps, suppress(KeyboardInterrupt):  # of a start given up
        for attempt in search_attempts(case, count, seed, wish.period):
            for each in attempt.orbits:
                rows.append(_kept(each, wish, _numbered(wish, len(rows) + 1)))
            tally.add(attempt)
            done = attempt.number + 1
            steps.show("starts", done, count)
            if interruption.signum is not None or any(row.trouble for row in rows):
                break
    trouble = next((row.trouble for row in rows if row.trouble), None)
    if settings.json:
        numbers = {"found_by": tally.counts, "unseen": tally.unseen, "next_is_new": tally.next_is_new}
        orbits = {"starts": done, "seed": seed, **numbers, "orbits": [row.object for row in rows]}
        print_json(orbits | _error_object(trouble))
    elif not settings.quiet:
        _print_list(case, rows, done, tally)
    if interruption.signum is not None:
        files = f"; what was found is in {rows[0].file} and on" if rows and rows[0].file else ""
        say(f"interrupted after {done} of {counted(count, 'start')}{files}", err=True)
        return interruption.exit_code
    return _code(trouble)


def _numbered(wish: OrbitWish, number: int) -> str | None:
    """The file of an orbit of a search: NAME-1.h5, ..."""
    if wish.output is None:
        return None
    path = Path(wish.output)
    return str(path.with_name(f"{path.stem}-{number}{path.suffix}"))


def _check_numbered(wish: OrbitWish) -> None:
    """Raise ResultFileError for orbits of another search where the files of this one are to be."""
    number = 1
    while (name := _numbered(wish, number)) is not None and (number == 1 or Path(name).exists()):
        check_output(name, wish.force)
        number += 1


def _print_list(case: Case, rows: list[OrbitRow], done: int, tally: SearchTally) -> None:
    say(heading(case.name, case.title))
    print_lines([("orbits", f"{len(rows)} from {counted(done, 'start')}")])
    for place, row in enumerate(rows, 1):
        print_lines([(f"{place}", orbit_row(row.orbit)), *row.file_line])
        if row.digits is not None:
            print_lines(row.digits.lines())
    if rows:
        print_lines([("completeness", _completeness(tally))])


def _completeness(tally: SearchTally) -> str:
    """Numbers of orbits found once and twice, and the estimates that follow."""
    return (
        f"{tally.found(1)} found from one start, {tally.found(2)} from two: about {tally.unseen:.1f} more "
        f"are there to be found; the next start finds a new one with probability {tally.next_is_new:.2g}"
    )


# A periodic orbit for people (lines) and for programs (JSON).


Lines = list[tuple[str, str]]


def orbit_lines(orbit: Orbit, digits: Any = None) -> Lines:
    """Label and text of all that is known of an orbit."""
    lines = [
        ("period", period_text(orbit)),
        *_drift(orbit),
        *_turns(orbit),
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
            f"{number(orbit.residual, 2)} {orbit.return_map.scene.length_unit}/s after "
            f"{counted(orbit.solution.steps, 'Newton step')}",
        ),
        ("certificate", certificate_text(orbit)),
    ]
    return lines + (digits.lines() if digits is not None else [])


def _drift(orbit: Orbit) -> Lines:
    units = {body.name: orbit.scene.unit_of(body) for body in orbit.scene.bodies}
    texts = [f"{metres(value, units[name])} of {name}" for name, value in orbit.drift.items()]
    return [("drift", f"{', '.join(texts)} per period")] if texts else []


def _turns(orbit: Orbit) -> Lines:
    names = {body.columns[0]: body.name for body in orbit.scene.bodies}
    texts = [
        f"{names[column]} {counted(abs(turns), 'turn')} {'forwards' if turns > 0 else 'backwards'}"
        for column, turns in orbit.turns.items()
    ]
    return [("turns", f"{', '.join(texts)} per period")] if texts else []


def period_text(orbit: Orbit) -> str:
    """Period, frequency, and how many of the source's it takes."""
    section = orbit.return_map.section
    what, _, whose = section.of_return.partition(" ")
    count = f"{counted(orbit.n, what)} {whose}"
    order = "" if orbit.n == 1 or section.turning else f", order 1/{orbit.n}"
    return f"{orbit.period:.12g} s, {1 / orbit.period:.10g} Hz: {count}{order}"


def section_text(orbit: Orbit) -> str:
    """The section on which the state is taken."""
    return str(orbit.return_map.section.place)


def counts_of(orbit: Orbit) -> dict[str, int]:
    """Impacts, stick phases and reversals of one period."""
    kinds = [kind for kind, _ in orbit.events]
    return {
        "impacts": sum(kind in IMPACTS for kind in kinds),
        "sticks": kinds.count("stick_begin"),
        "reversals": kinds.count("reversal"),
    }


def events_text(orbit: Orbit) -> str:
    """The word and its counts."""
    words = ("impact", "stick phase", "reversal")
    counts = ", ".join(map(counted, counts_of(orbit).values(), words))
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
    """Smallest gap at a turn without contact; force between a reversal and sticking, or stick and slip."""
    scene = orbit.scene
    margin = metres(orbit.margin, scene.unit_of_stops())
    gap = "no turn of a gap" if orbit.margin == inf else f"{margin} at a turn of a gap"
    force = (
        "no sliding velocity at 0"
        if orbit.sliding == inf
        else f"{number(orbit.sliding, 4)} {scene.force_unit} between slip and stick"
    )
    return f"{gap}; {force}"


def energy_text(energy: dict[str, float]) -> str:
    """Energy that goes in and that is lost in one period, in words."""
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
        "turns": orbit.turns,
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
