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
from vibsim.physics.parts import EVENT_NAMES, event_parts

TIGHT, LOOSE = 1e-12, 1e-10
REACH = 1e-7  # m, m/s, rad and rad/s: errors of the second solver up to which it is believed
SAFETY = 50  # times the difference of its two runs
LEAST = 2e-10  # what its event location and its steps leave
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


def compared(seed: int, engine: str = "auto") -> Comparison:
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
    run = simulate(load_case_text(drawn.case, name=f"drawn-{seed}"), engine=engine, trust=False)
    own = np.array([np.abs(a - b).max() for a, b in zip(states, others, strict=True)])
    believed = _believed(times, own, tight, loose)
    result.until = believed
    _compare_events(result, drawn, run, tight, loose, believed)
    _compare_states(result, drawn, run, tight, states, others, times, believed)
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


def _compare_events(result, drawn, run, tight, loose, believed) -> None:
    """Each part has the same events in the same order at the same times."""
    parts = [o.name for o in (*drawn.model.stops, *drawn.model.frictions)]
    ours = _events_of(run)
    expected = [event for event in tight.events if event[1] in COMPARED]
    spread = {event[:1]: abs(event[0] - other[0]) for event, other in zip(tight.events, loose.events, strict=False)}
    names = sorted({part for _, _, part in ours + expected} | set(parts))
    for name in names:
        mine = [(t, kind) for t, kind, part in ours if part == name and t < believed]
        theirs = [(t, kind) for t, kind, part in expected if part == name and t < believed]
        result.events += len(theirs)
        if [kind for _, kind in mine] != [kind for _, kind in theirs]:
            result.disagreements.append(f"events of {name}: {_shown(mine)} and by the second solver {_shown(theirs)}")
            continue
        for (t, kind), (other, _) in zip(mine, theirs, strict=True):
            bound = LEAST * 10 + SAFETY * spread.get((other,), 0.0)
            if abs(t - other) > bound:
                result.disagreements.append(f"{kind} of {name} at {t!r}, by the second solver {other!r}; {bound:.1e}")


def _shown(events) -> str:
    return ", ".join(f"{kind} {t:.9f}" for t, kind in events[:12]) or "none"


def _events_of(run):
    table, parts = run.events, dict(enumerate(event_parts(run.case.scene())))
    return [
        (float(t), EVENT_NAMES[int(kind)], parts.get(int(part), ""))
        for t, kind, part in zip(table["t"], table["kind"], table["part"], strict=True)
        if EVENT_NAMES[int(kind)] in COMPARED
    ]


def _compare_states(result, drawn, run, tight, states, others, times, believed) -> None:
    columns = list(tight.columns)
    for k, t in enumerate(times):
        if t > believed:
            return
        i = int(np.argmin(np.abs(run.time - t)))
        for name in columns:
            index = int(tight.columns[name][2:-1])
            expected, own = states[k][index], abs(states[k][index] - others[k][index])
            bound = LEAST * (1 + abs(expected)) + SAFETY * own
            error = abs(float(run[name][i]) - expected)
            result.worst = max(result.worst, error / bound)
            if error > bound:
                result.disagreements.append(
                    f"{name} at {t:.6g} s: {float(run[name][i])!r}, by the second solver {expected!r}; {bound:.1e}"
                )
