"""Load curves of the motors: up to which no-load speed orbits are held, as printed and in the readings.

The branch of orbits of one turn is followed from below the resonance, over all no-load speeds. Where the
motor's line meets it the motor can run; beyond its fold no line does, and no such orbit holds the motor.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from math import pi
from pathlib import Path
from typing import Any

from matplotlib.figure import Figure

from vibsim import __version__
from vibsim.branches.branch import Branch
from vibsim.branches.continuing import complete, orbit_from
from vibsim.branches.plan import plan_from
from vibsim.branches.span import read_span
from vibsim.branches.store.branch_file import read_branch
from vibsim.branches.store.branch_store import BranchFileStore
from vibsim.branches.tracing.tracing import MOST_POINTS
from vibsim.cases import Case, load_case
from vibsim.evidence.reports.claims.claim import Numbers
from vibsim.evidence.reports.measured.paper_runs import MOTORS, PRINTED_MOTOR, READINGS, Interrupted
from vibsim.evidence.reports.pages.document import Table
from vibsim.evidence.reports.wording import hz, words_of
from vibsim.files.errors import ResultFileError
from vibsim.plots.branches.leaps import dead_ends
from vibsim.plots.branches.load_curve import load_curve_panel
from vibsim.plots.branches.motor_lines import torque_of
from vibsim.plots.branches.values import amplitude_of
from vibsim.plots.page.sheet import sheet
from vibsim.plots.subject import Subject
from vibsim.plots.view import View

KEY, SPAN = "excitation.Omega0", "3:9 Hz"
BEGIN = {KEY: "3.8 Hz"}  # below the resonance, where a run from rest comes to an orbit of the branch
CHANGED = {  # name: what is changed of the motor as printed, to the value of the reading
    "as printed": (),
    "c alone": ("coupling.c",),
    "J alone": ("excitation.J",),
    "the reading": ("coupling.c", "excitation.J"),
}
DRAWN = ("as printed", "the reading")
HEIGHT_CM = 8.0
Tell = Callable[[str, int, int], bool]


def followed_cases() -> dict[str, Case]:
    """The motors whose branches are followed, by what is changed."""
    printed, reading = load_case(PRINTED_MOTOR), load_case(READINGS[0])
    return {
        name: printed.with_values({**{key: str(reading.quantity(key)) for key in keys}, **BEGIN})
        for name, keys in CHANGED.items()
    }


def obtain_branches(folder: Path, tell: Tell, fresh: bool = False) -> dict[str, Branch]:
    """The branches by name, from FOLDER or followed now. Raises Interrupted when `tell` returns False."""
    branches, cases = {}, followed_cases()
    for done, (name, case) in enumerate(cases.items()):

        def watch(*_: object, done: int = done) -> bool:
            return tell("following orbits", done, len(cases))

        branches[name] = _branch(case, folder / f"{name.replace(' ', '-')}.h5", watch, fresh)
        if not tell("following orbits", done + 1, len(cases)):
            raise Interrupted
    return branches


def _branch(case: Case, path: Path, watch: Callable[..., bool], fresh: bool) -> Branch:
    stored = None if fresh else _stored(case, path)
    if stored is not None:
        return stored
    plan = plan_from(orbit_from(case), *read_span(case, KEY, SPAN))
    branch, finished = complete(BranchFileStore(plan, path, force=True), MOST_POINTS, watch=watch)
    if not finished:
        raise Interrupted
    return branch


def _stored(case: Case, path: Path) -> Branch | None:
    """The branch on file, if it is whole and of this very case and version."""
    try:
        branch = read_branch(path) if path.is_file() else None
    except ResultFileError:
        return None
    if branch is None or not branch.attrs.get("complete"):
        return None
    same = (branch.case.sha256, branch.attrs.get("vibsim_version")) == (case.sha256, __version__)
    return branch if same else None


def measure_ends(branches: Mapping[str, Branch]) -> Numbers:
    """Of each branch: up to which no-load speed orbits are held, mean speed [Hz], torque [N m], power [W] and
    amplitude [m] there and, as `half`, at the last orbit before that takes at most half the power,
    None where the branch has none.
    """
    return {name: _end(branch) for name, branch in branches.items()}


def _end(branch: Branch) -> Numbers:
    last = max(dead_ends(branch), key=lambda orbit: orbit.parameter)
    (special,) = (one for one in branch.specials if one.orbit is last)
    end = _point(branch, last)
    before = [point.orbit for point in branch.points[: special.between[0] + 1]]
    powers = [_point(branch, orbit)["power"] for orbit in before]
    lower = [orbit for orbit, power in zip(before, powers, strict=True) if power <= end["power"] / 2]
    amplitude = amplitude_of(branch)
    return {
        **end,
        "kind": special.kind,
        "amplitude": amplitude(last),
        "half": {**_point(branch, lower[-1]), "amplitude": amplitude(lower[-1])} if lower else None,
    }


def _point(branch: Branch, orbit: Any) -> Numbers:
    """No-load speed, mean speed [Hz], mean torque [N m] and their power [W] of an orbit."""
    speed, torque = branch.plan.n / orbit.period, torque_of(branch)(orbit)
    return {
        "no_load_hz": orbit.parameter,
        "speed_hz": speed,
        "torque": torque,
        "power": 2 * pi * speed * torque,
    }


def draw_load_curves(branches: Mapping[str, Branch]) -> Figure:
    """Both load curves, with the lines of the paper's three motors."""
    figure = sheet(View(width="page"), HEIGHT_CM)
    subjects = [Subject(f"{name}.h5", name, "branch", branches[name].case, branches[name]) for name in DRAWN]
    load_curve_panel(figure, figure.subplots(), subjects, View(width="page"), no_load_speeds())
    return figure


def no_load_speeds() -> list[float]:
    """Of the paper's motors [Hz]."""
    motors = [load_case(name).scene().motor for name in MOTORS]
    return [motor.Omega0 / (2 * pi) for motor in motors if motor is not None]


def ends_table(ends: Mapping[str, Any]) -> Table:
    """How far orbits are held, for every combination of the two numbers."""
    kinds = {"fold": "fold", "neimark-sacker": "Neimark–Sacker point before the fold"}
    rows = tuple(
        (
            name,
            f"{end['no_load_hz']:.4f} Hz",
            f"{end['speed_hz']:.3f} Hz",
            f"{1e3 * end['torque']:.2f} mN m",
            kinds.get(end["kind"], end["kind"]),
        )
        for name, end in ends.items()
    )
    columns = ("II with", "Held up to a no-load speed of", "Mean speed there", "Torque taken", "Ends in")
    return Table("Where orbits held near half the bilinear frequency end", columns, rows)


def load_words(ends: Mapping[str, Any]) -> str:
    """What the load curves say of the motors of 5.5 and 6.5 Hz."""
    printed, reading = (ends[name] for name in DRAWN)
    return (
        "A motor can run where its line meets the curve of the torque that the vibration takes. Orbits held "
        "near half the bilinear frequency end where that curve turns back: beyond, no line meets it, and the "
        "motor leaves along its own. As printed there are such orbits up to a no-load speed of "
        f"{hz(printed['no_load_hz'])}, where the vibration takes {1e3 * printed['torque']:.2f} mN m: "
        f"{_held(printed)}. In the reading there are such orbits up to {reading['no_load_hz']:.3f} Hz: "
        f"{_held(reading)}. This bounds what any start can come to; whether a motor is caught where it can "
        "be held depends on the start."
    )


def _held(end: Mapping[str, Any]) -> str:
    """Which of the two faster motors can be held."""
    faster = no_load_speeds()[1:]
    held = [f"{speed:g} Hz" for speed in faster if speed <= end["no_load_hz"]]
    lost = [f"{speed:g} Hz" for speed in faster if speed > end["no_load_hz"]]
    if not held:
        return f"they hold neither the motor of {' nor that of '.join(lost)}"
    return f"they can hold the motor of {words_of(held)}" + (
        f", not that of {words_of(lost)}" if lost else ""
    )
