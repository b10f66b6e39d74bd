"""Budget: Case II faster than heyoka.py on the same scene in the same run, errors and events compared."""

from decimal import Decimal
from importlib.util import find_spec

import numpy as np

from tests.budgets.row import Row, stopwatch
from tests.budgets.true_states import error_of
from vibsim.cases import load_case
from vibsim.engine.trajectory import open_trajectory
from vibsim.evidence.peers.solvers import TimeLimit
from vibsim.evidence.verification.checks import match_events
from vibsim.physics.parts import EVENT_NAMES

STATES = ("x1", "v1", "x2", "v2", "phi", "phidot")
CHECKED = {"II-A": (20, 40), "II-B": (20, 50), "II-C": (20, 40)}  # s
# s; chaos parts two runs in doubles by more than SAME later on
AGREED = {"II-A": 45.0, "II-B": 60.0, "II-C": 45.0}
SAME = 1e-4  # s between two records of one event; two events of one kind are at least 7.9 ms apart
REPETITIONS = 7
FULL = 2.0**-52  # tolerance of heyoka, its default


def rows():
    if find_spec("heyoka") is None:
        print("Case II against heyoka.py: left out, heyoka is not installed")
        return
    for name in CHECKED:
        yield from case_rows(name)


def case_rows(name):
    """Time of vibsim / time of heyoka, both with 60,001 samples, taken in turns; errors; events."""
    from vibsim.evidence.peers.heyoka_events import HeyokaEvents

    scene = load_case(name).scene()
    times = np.array([scene.sample_time(i) for i in range(scene.sample_count)])
    made = []
    jit = stopwatch(lambda: made.append(HeyokaEvents(scene, FULL)))
    peer = made[0]
    pairs = [
        (stopwatch(lambda: vibsim_run(scene)), stopwatch(lambda: peer.run(times, TimeLimit())))
        for _ in range(REPETITIONS)
    ]
    ours, theirs = np.median(pairs, axis=0) * 1e3
    note = f"vibsim {ours:.1f} ms, heyoka {theirs:.1f} ms, its JIT {jit:.2f} s not counted"
    yield Row(f"{name}, vibsim / heyoka.py, 60,001 samples", "x", 1.0, [a / b for a, b in pairs], [note])
    samples, events = vibsim_run(scene)
    attempt = peer.run(times, TimeLimit())
    yield error_row(name, scene, samples, attempt.states)
    yield event_row(name, events, np.array(attempt.events))


def vibsim_run(scene):
    """Samples and events of a run, as arrays."""
    blocks = list(open_trajectory(scene).blocks())
    samples = np.column_stack([np.concatenate([block.samples[name] for block in blocks]) for name in STATES])
    events = np.column_stack(
        [np.concatenate([block.events[name] for block in blocks]) for name in ("t", "kind")]
    )
    return samples, events[1:-1]


def error_row(name, scene, samples, peer_samples):
    """Error of vibsim / error of heyoka at the checked instants."""
    figures, notes = [], []
    for t in CHECKED[name]:
        i = scene.sample_index(t)
        error, peer_error = error_of(name, t, samples[i]), error_of(name, t, peer_samples[i])
        figures.append(error / peer_error)
        notes.append(f"at {t} s: vibsim {error:.1e}, heyoka {peer_error:.1e}")
    return Row(f"{name}, error of vibsim / error of heyoka.py", "x", 1.0, figures, notes)


def event_row(name, events, peer_events):
    """Events that heyoka has and vibsim has not, while chaos lets both have the same."""
    ours, theirs = (early(table, AGREED[name]) for table in (events, peer_events))
    matching = match_events(theirs, [SAME] * len(theirs), ours)
    missed, surplus = [theirs[i] for i in matching.missed], [ours[j] for j in matching.spurious]
    note = f"vibsim has {len(ours)}, of which heyoka misses {len(surplus)}"
    notes = [note, *told("heyoka", missed), *told("vibsim", surplus)]
    return Row(f"{name}, events up to {AGREED[name]:g} s missed", "", 0.0, [float(len(missed))], notes)


def early(table, until):
    """The rows (t, kind) up to `until` [s] as (name of the kind, time)."""
    return [(EVENT_NAMES[int(kind)], Decimal(t)) for t, kind in table.tolist() if t <= until]


def told(who, events):
    """The first few of the events that only `who` has."""
    return [f"only in {who}: {name} at {t:.9f} s" for name, t in events[:5]]
