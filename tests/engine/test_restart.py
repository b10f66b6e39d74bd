"""A run can be taken up at any stored event: the rest of it comes out bit for bit."""

from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tests.engine.random_formulas import formula_scene
from tests.engine.random_parts import part_scenes
from tests.engine.runs import Run, outcome, run, same_bits, scene_of
from tests.engine.tied_scenes import tied_scene
from tests.random_scenes import scenes
from tests.scenes import CASE_NAMES, paper
from vibsim.cases import load_case
from vibsim.engine.resume import rows_to_resume
from vibsim.engine.trajectory import open_trajectory
from vibsim.physics.parts import GROUND, Clearance
from vibsim.physics.rates import common_period
from vibsim.physics.two_blocks import TwoBlocks
from vibsim.plots.slow_passages import _energies
from vibsim.results.columns import states_at
from vibsim.results.simulation import simulate
from vibsim.sweeps.sweeping import sweep

METHODS = ("auto", "taylor")


def rows_at_each_instant(events):
    """All rows of each instant, in their order."""
    rows = [dict(zip(events, values, strict=True)) for values in zip(*events.values(), strict=True)]
    for t in sorted(set(events["t"].tolist())):
        yield [row for row in rows if row["t"] == t]


def assert_restarts(scene):
    """The run goes on from the rows of each instant."""
    whole = outcome(scene)
    if not isinstance(whole, Run):
        return
    for t in sorted(set(whole.events["t"].tolist()))[1:-1]:
        rows = rows_to_resume(scene, whole.events, int(np.flatnonzero(whole.events["t"] == t)[-1]))
        assert rows is not None and rows[-1]["t"] == t
        rest = run(scene, resume=rows)
        after, later = whole.samples["time"] >= t, whole.events["t"] > t
        for name, values in rest.samples.items():
            assert same_bits(values, whole.samples[name][after]), (name, t)
        for name, values in rest.events.items():
            assert same_bits(values[1:], whole.events[name][later]), (name, t)


@settings(max_examples=150)
@given(st.one_of(part_scenes(), part_scenes(), scenes().map(TwoBlocks.as_parts)), st.sampled_from(METHODS))
def test_random_scenes_go_on_from_every_event(scene, method):
    """Rest distances of two blocks among their parts, at which a run may stop."""
    assert_restarts(replace(scene, method=method))


def test_a_clearance_that_is_just_touched_goes_on_from_every_event():
    """Its zeros are near to double: a restart that looked at them again had other last bits than the run."""
    assert_restarts(
        scene_of("""
bodies: {b: 1 kg}
links: {l: {between: [b, ground], k: 39.47841760435743 N/m}}
clearances: {mark: {between: [b, ground], distance: 0.010000000000000002 m}}
initial: {b: {v: 0.06283185307179587 m/s}}
run: {t_end: 6.366 s, every: 2.122 s}
""")
    )


@pytest.mark.parametrize("seed", range(14))
def test_random_formulas_go_on_from_every_event(seed):
    assert_restarts(replace(formula_scene(seed), t_end=0.3))


def assert_states(scene):
    """`states_at` gives the run's own states at its samples."""
    whole = outcome(scene)
    if isinstance(whole, Run):
        states = states_at(scene, whole.events, whole.samples["time"], whole.events["t"][-1])
        for name, values in whole.samples.items():
            assert same_bits(states[name], values), name


@pytest.mark.parametrize("seed", [67, 146, 165, 194, 255, 273, 378, 403, 559, 655])
def test_states_of_random_formulas_are_those_of_the_run(seed):
    """Of each of these scenes a restart had another side of a switch, or turned it once more."""
    assert_states(formula_scene(seed))
    assert_restarts(formula_scene(seed))


@pytest.mark.slow
@pytest.mark.parametrize("seed", [*range(700, 800), *range(801, 900)])  # 800 creeps for minutes
def test_states_of_more_random_formulas_are_those_of_the_run(seed):
    assert_states(formula_scene(seed))


SWITCHED = """
bodies: {a: 1 kg}
links: {s: {between: [a, ground], k: 100 N/m}}
forces: {f: {on: a, force: "1 N*FORCE"}}
initial: {a: {v: 0.1 m/s}}
run: {t_end: 3 s, every: 50 ms}
"""


@pytest.mark.parametrize(
    "force", ["min(1, step(x_a))", "max(-0.5, -step(-x_a))", "abs(7 1/s*t - 6.3)"], ids=str
)
def test_states_are_those_of_the_run_behind_switches(force):
    """A choice behind one that turns takes its side by it; one that bends at a sample has turned there."""
    assert_states(scene_of(SWITCHED.replace("FORCE", force)))


def test_energies_of_a_picture_are_those_of_the_run_behind_switches():
    """Those of two spans sum up to those of both, wherever the middle."""
    scene = scene_of(SWITCHED.replace("FORCE", "min(1, step(x_a))"))
    events = run(scene).events
    whole = _energies(scene, events, 0.0, scene.t_end)
    for begin, end in pairwise(events["t"].tolist()):
        middle = (begin + end) / 2
        spans = [_energies(scene, events, *span) for span in ((0.0, middle), (middle, scene.t_end))]
        for name, energy in whole.items():
            assert abs(spans[0][name] + spans[1][name] - energy) < 1e-15, (name, middle)


@pytest.mark.parametrize("discard", [3.0, 6.0])
def test_powers_of_a_sweep_are_those_of_the_run_behind_switches(discard):
    """They begin at the last event of the transient, which the switch of the force is."""
    text = "name: switched" + SWITCHED.replace("FORCE", "min(1, step(x_a))").replace(
        "t_end: 3 s", "t_end: 10 s"
    )
    text = text.replace("forces: {", "forces: {g: {on: a, A: 0.3 N, omega: 1 Hz}, ")
    text = text.replace("k: 100 N/m", "k: 100 N/m, c: 0.05 N s/m")
    scene = load_case(text).scene()
    work = [_energies(scene, run(scene).events, 0.0, end)["work.forces.f"] for end in (discard, 10.0)]
    table = sweep(text, {"g.A": "0.3:0.31:0.01 N"}, compute="power", discard=f"{discard:g} s", jobs=1)
    power = float(table.to_xarray()["power_force_f"].values.ravel()[0])
    assert abs(power * (10.0 - discard) - (work[1] - work[0])) < 1e-15


@pytest.mark.parametrize("seed", [145, 497, 499, 539, 686])
def test_many_events_at_one_instant_go_on_from_it(seed):
    """What the first of them left at zero is looked at once more behind the last."""
    assert_restarts(tied_scene(seed))


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(150, 330))
def test_random_ties_go_on_from_every_event(seed):
    assert_restarts(tied_scene(seed))


@pytest.mark.parametrize("name", CASE_NAMES)
def test_papers_cases_go_on_from_every_event_and_have_the_states_between(name):
    scene = paper(name, t_end=3.0).as_parts()
    whole = run(scene)
    times = whole.samples["time"]
    rows = list(rows_at_each_instant(whole.events))
    for one, following in pairwise(rows):
        t, end = one[-1]["t"], following[0]["t"]
        between = (times >= t) & (times < end)
        found = open_trajectory(scene, resume=one[-1]).state_at(times[between].tolist())
        for name_of_column, values in found.items():
            assert same_bits(values, whole.samples[name_of_column][between])
    assert_restarts(scene)


@pytest.mark.parametrize(
    "name", ("gallery/percussive-drill", "gallery/impact-pair", "gallery/block-on-belt", "II-B")
)
def test_states_behind_events_on_the_way_are_those_of_runs_taken_up_there(name):
    """From the start over forty events, at two instants between every two of them."""
    scene = load_case(name, {"run.t_end": "4 s"}).scene()
    instants = list(rows_at_each_instant(run(scene).events))[:40]
    t = np.array([rows[-1]["t"] for rows in instants])
    times = t[:-1, None] + np.diff(t)[:, None] * [1 / 3, 2 / 3]
    found = open_trajectory(scene, resume=instants[0]).state_at(times.ravel().tolist())
    for i, (rows, between) in enumerate(zip(instants, times.tolist(), strict=False)):
        for column, values in open_trajectory(scene, resume=rows).state_at(between).items():
            assert same_bits(found[column][2 * i : 2 * i + 2], values), (column, i)


@pytest.mark.parametrize(
    ("column", "value", "sentence"),
    [
        ("t", -1.0, "t must be 0 to"),
        ("t", np.nan, "t must be finite"),
        ("x1", np.inf, "x1 must be finite"),
        ("kind", 77, "kind must be one of"),
        ("contact", 5, "contact must be one of"),
        ("friction", 3, "friction must be one of"),
    ],
)
def test_no_run_goes_on_from_a_row_that_there_is_not(column, value, sentence):
    scene = paper("I-A", t_end=1.0).as_parts()
    row = {name: values[0] for name, values in run(scene).events.items()}
    with pytest.raises(ValueError, match=sentence):
        open_trajectory(scene, resume=row | {column: value})


TORN_OFF = """
bodies: {b0: 1.267441390504369 kg, b1: 0.7430163730037074 kg}
links: {l0: {between: [b0, ground], k: 0.3005097399950038 N/m},
        l1: {between: [b1, ground], k: 1.3937859294545636 N/m, c: 0.33869277291162014 N s/m}}
stops: {r1: {between: [ground, b1], gap: 0.3727656047461465 m, acts: compression, law: rigid, e: 0}}
friction:
  f0: {between: [b0, b1], N: 2.348170527621526 N, mu: 0.4247634468655391, static: 1.0682880800418662}
  f1: {between: [b0, b1], N: 0.24320805436048148 N, mu: 0.4537428874345042}
forces: {F0: {on: b0, A: 1.6683523585048854 N, omega: 1.6648217237148706 rad/s, phase: 2.532646530028698 rad}}
motor: {on: b0, m3: 0.0958551020353236 kg, e: 0.21029457319496636 m, J: 0.038281562061243016 kg m^2,
        M0: 0.5605531486055956 N m, Omega0: 4.2371210770332794 rad/s}
initial: {b0: {x: 0.16791217251944235 m, v: -0.5045061017389765 m/s}, motor: {phi: 3.7668742146478147 rad},
          b1: {x: -0.3500771905826653 m, v: -0.5264360198134965 m/s}}
run: {t_end: 30 s, every: 0.15 s}
"""
TWINS = """
bodies: {b0: 0.7 kg, b1: 1.3 kg}
links: {l0: {between: [b0, ground], k: 40 N/m}, l1: {between: [b1, b0], k: 3 N/m}}
stops: {r0: {between: [b0, b1], gap: 0.0123 m, acts: compression, law: rigid, e: 0.6},
        r1: {between: [b1, b0], gap: 0.0123 m, acts: extension, law: rigid, e: 0.7}}
motor: {on: b0, m3: 0.1 kg, e: 0.2 m, J: 0.04 kg m^2, M0: 0.5 N m, Omega0: 9 rad/s}
run: {t_end: 10 s, every: 0.05 s}
"""


@pytest.mark.parametrize("text", (TORN_OFF, TWINS), ids=("torn_off", "twins"))
def test_states_between_events_follow_no_event_of_the_instant_before_once_more(text):
    """A body torn off its stop leaves with a rounding of velocity; of two stops one is struck, both left."""
    result = simulate(load_case(text), trust=False)
    states = result.at(result.time)
    assert result.attrs["impacts"] > 0
    for name in ("x_b0", "v_b0", "phi", "phidot"):
        assert same_bits(states[name], result[name]), name


# The stroboscopic section: the state at the end of every period of what drives a scene.


def driven(*rates, base="a: 0 m, omega: 1 Hz", method="auto"):
    """A body under forces of so many rates, on a base."""
    forces = [f"F{i}: {{on: m, A: 0.01 N, omega: {rate}}}" for i, rate in enumerate(rates)]
    return scene_of(f"""
bodies: {{m: 1 kg}}
links: {{l: {{between: [m, base], k: 30 N/m, c: 10 N s/m}}}}
forces: {{{", ".join(forces)}}}
base: {{{base}}}
initial: {{m: {{x: 1 cm}}}}
run: {{t_end: 10 s, every: 0.25 s, method: {method}}}
""")


@pytest.mark.parametrize("method", ("auto", "taylor"))
def test_harmonics_of_one_force_and_the_base_share_a_period(method):
    """2 and 3 Hz repeat every second, 4 and 6 Hz every half."""
    for forced, shaken, period in ((2, 3, 1.0), (4, 6, 0.5), (5, 5, 0.2)):
        drive = driven(f"{forced} Hz", base=f"a: 1 cm, omega: {shaken} Hz", method=method)
        section = run(drive, section=True).section
        assert section["time"] == pytest.approx(period * np.arange(1, round(10 / period) + 1), rel=1e-15)
        # what is read there is the motion; its transient exp(-5 t) is gone, the steady one repeats
        late = section["x_m"][-3:]
        assert late == pytest.approx([late[-1]] * 3, rel=1e-9)
        samples = run(drive).samples
        at = np.isin(section["time"], samples["time"])
        assert same_bits(section["x_m"][at], samples["x_m"][np.isin(samples["time"], section["time"])])


@pytest.mark.parametrize("rates", [("1 Hz", f"{2**0.5} Hz"), ("1 Hz", "1.000000001 Hz"), ("1 Hz", "1 rad/s")])
def test_no_section_without_a_common_period(rates):
    drive = driven(*rates)
    assert common_period(drive) is None
    assert len(run(drive, section=True).section["time"]) == 0


def test_frequencies_of_no_exact_double_have_their_period():
    """10 s."""
    period = common_period(driven("0.1 Hz", "0.3 Hz"))
    assert period.end(1) == 10.0 and period.end(7) == 70.0


def test_section_of_a_run_taken_up_again():
    two_blocks = paper("I-C", t_end=5.0)
    drive = two_blocks.as_parts()
    whole = run(drive, section=True)
    row = {name: values[20] for name, values in whole.events.items()}
    rest = run(drive, resume=row, section=True)
    later = whole.section["time"] > row["t"]
    assert 0 < later.sum() < len(later)
    for name, values in rest.section.items():
        assert same_bits(values, whole.section[name][later])


def test_runs_of_stiff_states_go_on_from_events_and_are_right_with_lower_orders():
    """Orders fall within a stretch, and are those of the case behind each event."""
    case = load_case("gallery/lugre-friction")
    scene = replace(case.scene(), t_end=12.0, clearances=(Clearance("mark", 0, GROUND, 0.4),))
    whole, other = run(scene, ledger=True), run(replace(scene, order=32))
    assert len(whole.events["t"]) > 2
    assert whole.totals["steps"] < 3000  # 3560 where all are of order 20
    for name, values in whole.samples.items():
        assert np.abs(values - other.samples[name]).max() < 1e-13, name
    assert_restarts(scene)
    plain = run(scene)
    assert all(same_bits(values, plain.samples[name]) for name, values in whole.samples.items())
