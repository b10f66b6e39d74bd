"""Budget: 300 s with 60,001 samples in C; how near to the limit that the flop count sets."""

from statistics import median

from tests.budgets.engine_clock import EngineClock, run_through
from tests.budgets.row import Row, stopwatch
from vibsim.cases import load_case
from vibsim.engine.trajectory import open_trajectory

REPETITIONS = 15
CASE_I, CASE_II = ("I-A", "I-B", "I-C"), ("II-A", "II-B", "II-C")
FLOOR_I, FLOOR_II = (5.0, 5.0), (15.0, 20.0)  # ms by flop count, from and to


def rows():
    for name in CASE_I:
        yield from _case_rows(name, FLOOR_I, 15.0, 2.0)
    for name in CASE_II:
        yield from _case_rows(name, FLOOR_II, None, None)


def _case_rows(name, floor, most_ms, most_us):
    scene = load_case(name).scene()
    assert scene.sample_count == 60_001
    in_engine, whole = [], []
    for _ in range(REPETITIONS):
        in_engine.append(engine_ms(scene))
        whole.append(stopwatch(lambda: run_through(open_trajectory(scene))) * 1e3)
    totals = run_through(open_trajectory(scene))
    events = totals["events"]
    note = (
        f"{events} events, {totals['steps']} steps; by open_trajectory, blocks copied: {median(whole):.1f} ms"
    )
    yield Row(f"{name}, 300 s, 60,001 samples, in the engine", "ms", most_ms, in_engine, [note])
    if most_us is not None:
        bare = median(engine_ms(scene.without_samples()) for _ in range(REPETITIONS))
        note = f"without samples {bare:.1f} ms: {bare * 1e3 / events:.2f} us"
        yield Row(f"{name}, time per event", "us", most_us, [ms * 1e3 / events for ms in in_engine], [note])
    low, high = floor
    span = f"{low:g}" if low == high else f"{low:g}-{high:g}"
    yield Row(
        f"{name}, against the floor of {span} ms by flop count", "x", 2.0, [ms / high for ms in in_engine]
    )


def engine_ms(scene):
    """Time in C [ms] of a run to its end."""
    with EngineClock() as clock:
        run_through(open_trajectory(scene))
    return clock.seconds * 1e3
