"""A random scene with formulas by vibsim and by the second solver: in what they disagree.

How far the second solver is off itself is seen from a run of it at a looser tolerance. Events and states are
compared as long as the two runs of it agree to REACH.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from tests.formulas.drawn_models import Drawn
from tests.formulas.second_solver import SecondSolver, TooHard
from vibsim import simulate
from vibsim.cases.case import load_case_text
from vibsim.physics.connections import event_parts
from vibsim.physics.parts import EVENT_NAMES

TIGHT, LOOSE = 1e-12, 1e-10
REACH = 1e-7  # m, m/s, rad and rad/s: errors of the second solver up to which it is believed
SAFETY = 100  # times the difference of its two runs
LEAST = 2e-10  # m, m/s, ...: what its event location and its steps leave
EVENT_LEAST = 2e-9  # s
COMPARED = ("contact_begin", "contact_end", "impact", "stick_begin", "stick_end", "reversal", "switch")


@dataclass
class Comparison:
    """Of a scene: what disagrees, what the second solver could not do, and how far it went."""

    seed: int
    case: str
    disagreements: list[str] = field(default_factory=list)
    skipped: str = ""
    until: float = 0.0
    worst: float = 0.0
    events: int = 0


def compared(seed: int) -> Comparison:
    """Run scene number `seed` both ways."""
    drawn = Drawn(seed)
    result = Comparison(seed, drawn.case)
    times = np.linspace(0, drawn.model.t_end, 9)[1:]
    try:
        tight, states = _second(drawn, TIGHT, times)
        loose, others = _second(drawn, LOOSE, times)
    except TooHard as error:
        result.skipped = str(error)
        return result
    run = simulate(load_case_text(drawn.case, name=f"drawn-{seed}"), trust=False)
    own = np.array([np.abs(a - b).max() for a, b in zip(states, others, strict=True)])
    believed = _believed(times, own, tight, loose)
    result.until = believed
    _compare_events(result, run, tight, loose, believed)
    _compare_states(result, run, tight, states, others, times, believed)
    return result


def _second(drawn: Drawn, tolerance: float, times) -> tuple[SecondSolver, np.ndarray]:
    solver = SecondSolver(drawn.model, tolerance)
    return solver, solver.run(times)


def _believed(times, own, tight, loose) -> float:
    """Until when the two runs of the second solver agree."""
    late = next((times[k - 1] if k else 0.0 for k, error in enumerate(own) if error > REACH), times[-1])
    for one, other in zip(tight.events, loose.events, strict=False):
        if one[1:] != other[1:] or abs(one[0] - other[0]) > REACH:
            return min(late, one[0] - 1e-6, other[0] - 1e-6)
    if len(tight.events) != len(loose.events):
        first = (tight.events + loose.events)[min(len(tight.events), len(loose.events))]
        late = min(late, first[0] - 1e-6)
    return late


def _compare_events(result, run, tight, loose, believed) -> None:
    """Each part has the same events in the same order at the same times."""
    ours = _events_of(run)
    expected = [event for event in tight.events if event[1] in COMPARED]
    apart = _event_errors(tight, loose)
    for name in sorted({part for _, _, part in ours + expected}):
        mine = [(t, kind) for t, kind, part in ours if part == name and t < believed]
        theirs = [(t, kind) for t, kind, part in expected if part == name and t < believed]
        result.events += len(theirs)
        if [kind for _, kind in mine] != [kind for _, kind in theirs]:
            told = f"{_shown(mine)}; by the second solver {_shown(theirs)}"
            result.disagreements.append(f"events of {name}: {told}")
            continue
        for (t, kind), (other, _) in zip(mine, theirs, strict=True):
            bound = EVENT_LEAST + SAFETY * apart(other)
            if abs(t - other) > bound:
                told = f"{kind} of {name} at {t!r}, by the second solver {other!r}, bound {bound:.1e}"
                result.disagreements.append(told)


def _event_errors(tight, loose):
    """t -> by how much events up to t [s] differ at most between the runs of the second solver."""
    pairs = zip(tight.events, loose.events, strict=False)
    changes = [(one[0], abs(one[0] - other[0])) for one, other in pairs if one[1:] == other[1:]]
    return lambda t: max((change for when, change in changes if when <= t), default=0.0)


def _shown(events) -> str:
    return ", ".join(f"{kind} {t:.9f}" for t, kind in events[:12]) or "none"


def _events_of(run) -> list[tuple[float, str, str]]:
    table, parts = run.events, dict(enumerate(event_parts(run.case.scene())))
    return [
        (float(t), EVENT_NAMES[int(kind)], parts.get(int(part), ""))
        for t, kind, part in zip(table["t"], table["kind"], table["part"], strict=True)
        if EVENT_NAMES[int(kind)] in COMPARED
    ]


def _compare_states(result, run, tight, states, others, times, believed) -> None:
    """Every column at every time; the second solver's error is the greatest difference up to there."""
    indices = {name: int(place[2:-1]) for name, place in tight.columns.items()}
    own = np.maximum.accumulate(np.abs(states - others), axis=0)
    for k, t in enumerate(times):
        if t > believed:
            return
        i = int(np.argmin(np.abs(run.time - t)))
        for name, index in indices.items():
            expected, obtained = float(states[k][index]), float(run[name][i])
            bound = LEAST * (1 + abs(expected)) + SAFETY * float(own[k][index])
            result.worst = max(result.worst, abs(obtained - expected) / bound)
            if abs(obtained - expected) > bound:
                told = f"{obtained!r}, by the second solver {expected!r}, bound {bound:.1e}"
                result.disagreements.append(f"{name} at {t:.6g} s: {told}")
