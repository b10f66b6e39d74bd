"""Scenes of named parts, run and recorded: columns by name, files, trust, distances, counts."""

from fractions import Fraction

import h5py
import numpy as np
import pytest

import vibsim
from vibsim.cases import load_case
from vibsim.cases.case import load_case_text
from vibsim.engine.errors import EngineError, State
from vibsim.results import ResultFileError, simulate_to_file
from vibsim.results.columns import part_counts
from vibsim.results.parallel_runs import companion_scene

# A ram on a shaken table that strikes a tool: two stops, friction on the base, a belt, a watched distance.
HAMMER = """
name: hammer
bodies: {ram: 2 kg, tool: 0.3 kg}
links: {spring: {between: [ram, ground], k: 4.1 kN/m, c: 2 N s/m}}
stops:
  anvil: {between: [ram, tool], gap: 2 mm, acts: compression, k: 0.7 MN/m, c: 20 N s/m, release: force}
  wall: {between: [tool, base], gap: 5 mm, acts: compression, k: 1 MN/m}
friction:
  guide: {between: [tool, base], N: 3 N, mu: 0.2}
  felt: {between: [ram, ground], N: 1 N, mu: 0.3, belt: 0.1 m/s}
forces: {drive: {on: ram, A: 31.7 N, omega: 7 Hz, phase: 10 deg, F0: 2 N}}
base: {a: 0.3 mm, omega: 21 Hz}
clearances: {room: {between: [ram, tool], distance: 2.5 mm}}
run: {t_end: 2 s, every: 1 ms}
"""


def hammer(**changes):
    return load_case_text(HAMMER, {key.replace("__", "."): value for key, value in changes.items()})


@pytest.fixture(scope="module")
def run():
    return vibsim.simulate(hammer())


def test_columns_bear_the_names_of_bodies_and_parts(run):
    states = ["x_ram", "v_ram", "x_tool", "v_tool"]
    parts = ["anvil", "wall", "guide", "felt", "room"]
    assert run.keys() == ["time", *states, *parts, "error_estimate"]
    assert list(run.events) == ["t", "kind", "part", *states, *parts]
    assert (run.complete, run.attrs["certified"], len(run)) == (True, 1, 2001)


def test_a_file_holds_what_memory_holds(run, tmp_path):
    streamed = simulate_to_file(hammer(), tmp_path / "a.h5")
    saved = vibsim.open_result(run.save(tmp_path / "b.h5"))
    for other in (streamed, saved, vibsim.open_result(tmp_path / "a.h5")):
        assert (other.keys(), list(other.events)) == (run.keys(), list(run.events))
        assert all(np.array_equal(other[name], run[name]) for name in run)
        assert all(np.array_equal(other.events[name], run.events[name]) for name in run.events)
    assert saved.case.sha256 == run.case.sha256


def test_any_instant_can_be_evaluated_again(run, tmp_path):
    """Between samples by going on from the events; at the samples, what was sampled."""
    saved = vibsim.open_result(run.save(tmp_path / "a.h5"))
    for result in (run, saved):
        states = result.at(run.time[::7])
        assert set(states) == {"time", *run.keys()} - {"error_estimate"}
        for name, values in states.items():
            np.testing.assert_allclose(values, run[name][::7], rtol=1e-9, atol=1e-12, err_msg=name)
    finer = vibsim.simulate(hammer(run__every="0.25 ms"), trust=False)
    np.testing.assert_allclose(run.at(finer.time)["x_tool"], finer["x_tool"], rtol=0, atol=1e-12)


def test_the_energy_ledger_is_kept_and_closes(run):
    attrs = run.attrs
    assert abs(attrs["energy_residual_relative"]) < 1e-12
    spent = attrs["loss_viscous"] + attrs["loss_friction"] + attrs["loss_stops"]
    paid = attrs["work_source"] + attrs["work_base"] + attrs["work_belt"]
    assert attrs["energy_end"] - attrs["energy_start"] == pytest.approx(paid - spent, abs=1e-12)
    assert attrs["loss_stops"] == attrs["loss.stops.anvil"] > 0


def test_flags_in_a_file_say_what_they_mean(run, tmp_path):
    with h5py.File(run.save(tmp_path / "a.h5")) as file:
        part, anvil = file["events/part"].attrs, file["anvil"].attrs
        assert part["flag_meanings"] == "none anvil wall guide felt room"
        assert part["flag_values"].tolist() == [-1, 0, 1, 2, 3, 4]
        assert anvil["flag_meanings"] == "free contact lifted"
        assert anvil["long_name"] == "state of the stop anvil between ram and tool"
        assert file["x_ram"].dims[0].keys() == ["time"]


def test_a_part_that_there_is_not_is_damage(run, tmp_path):
    path = run.save(tmp_path / "a.h5")
    with h5py.File(path, "r+") as file:
        file["events/part"][3] = 5
    with pytest.raises(ResultFileError, match=r"events/part has the value 5; allowed: -1, 0, 1, 2, 3, 4"):
        vibsim.open_result(path).events["part"]


def test_events_are_counted_by_part(run):
    counts = part_counts(run, run.case.scene())
    impacts = [counts[name].get("impacts", 0) for name in counts]
    assert sum(impacts) == run.attrs["impacts"] > 0
    assert sum(counts[name].get("sticks", 0) for name in counts) == run.attrs["sticks"] > 0
    assert counts["room"] == {"violations": run.attrs["violations"]}
    contact = np.asarray(run.events["anvil"]) != 0
    begins = (run.events["kind"] == 1) & (run.events["part"] == 0)
    assert contact[begins].all()
    assert counts["anvil"]["impacts"] == np.count_nonzero(begins)


def test_one_scene_in_both_forms_moves_alike():
    """Bit for bit, and with the same columns."""
    short = vibsim.simulate(load_case("II-B", {"run.t_end": "40 s"}))
    long = vibsim.simulate(load_case_text(short.case.long_text()))
    assert long.case.is_long
    assert set(short) == set(long)
    assert all(short[name].tobytes() == long[name].tobytes() for name in short)
    assert 40.0 == short.trust_horizon == long.trust_horizon
    for count in ("impacts", "sticks", "events"):
        assert short.attrs[count] == long.attrs[count]


def test_the_estimate_is_as_large_as_the_error():
    """A free vibration with its closed form: x = cos(w t), w = sqrt(0.7/0.3). Where nothing grows, chance may
    make the distance of two runs half of what each is off by.
    """
    text = "bodies: {b: 0.3 kg}\nlinks: {s: {between: [b, ground], k: 0.7 N/m}}\n"
    case = load_case_text(text + "initial: {b: {x: 1 m}}\nrun: {t_end: 2000 s, every: 0.5 s}\n")
    result = vibsim.simulate(case)
    w, precise = np.sqrt(np.longdouble(7) / 3), np.cos
    exact = precise(w * result.time.astype(np.longdouble))
    assert (np.abs(result["x_b"] - exact) <= 2 * result.error_estimate).all()
    assert result.trust_horizon == 2000.0


def test_the_data_of_the_companion_lie_on_the_other_side_of_their_decimals():
    case = hammer()
    scene, exact = case.scene(), case.exact_scene(Fraction)
    other = companion_scene(case, scene)
    for ours, theirs, true in [
        (scene.bodies[1].m, other.bodies[1].m, exact.bodies[1].m),
        (scene.stops[0].gap, other.stops[0].gap, exact.stops[0].gap),
        (scene.forces[0].terms[0].amplitude, other.forces[0].terms[0].amplitude, Fraction(317, 10)),
        (scene.base[0].amplitude, other.base[0].amplitude, exact.base[0].amplitude),
    ]:
        assert abs(theirs - ours) == np.spacing(min(ours, theirs))
        assert min(ours, theirs) < true < max(ours, theirs)
    assert (other.bodies[0].m, other.links[0].k) == (2.0, 4100.0)  # these are doubles
    assert (other.method, other.order, other.clearances) == ("taylor", 25, ())


@pytest.mark.parametrize(
    ("ends", "needed"),
    [
        # x = 0.1 t, X = 0.02 sin(2 pi t): the largest of x - X in [0, 3] is where cos(2 pi t) = 0.1/(0.04 pi)
        ("[b, base]", None),
        ("[b, ground]", 0.3),
        ("[ground, b]", 0.0),
    ],
)
def test_what_a_clearance_needs(ends, needed):
    text = (
        f"bodies: {{b: 1 kg}}\nbase: {{a: 20 mm, omega: 1 Hz}}\ninitial: {{b: {{v: 0.1 m/s}}}}\n"
        "clearances:\n  other: {between: [base, b], distance: 1 m}\n"
        f"  room: {{between: {ends}, distance: 1 m}}\nrun: {{t_end: 3 s, every: 10 ms}}\n"
    )
    if needed is None:
        t = 3 - np.arccos(0.1 / (0.04 * np.pi)) / (2 * np.pi)
        needed = max(0.1 * t - 0.02 * np.sin(2 * np.pi * t), 0.3)
    attrs = vibsim.simulate(load_case_text(text)).attrs
    assert attrs["clearances_needed"][1] == pytest.approx(needed, abs=1e-9)


def test_a_run_ends_where_a_clearance_is_violated():
    result = vibsim.simulate(hammer(run__on_violation="stop"))
    assert result.complete
    assert result.t_reached == result.attrs["first_violation_time"] < 2.0
    assert result.time[-1] <= result.t_reached


def test_a_run_that_is_stopped_is_kept(tmp_path):
    result = simulate_to_file(hammer(), tmp_path / "a.h5", watch=lambda t: False)
    assert not result.complete
    assert not vibsim.open_result(tmp_path / "a.h5").complete


def test_without_trust_there_is_no_estimate():
    result = vibsim.simulate(hammer(run__t_end="0.1 s"), trust=False)
    assert (result.error_estimate, result.trust_horizon) == (None, None)


def test_events_name_any_of_many_parts():
    """A pointer to the right part where a byte has no room for its number: 140 stops, 100 frictions."""
    count = 140
    bodies = ", ".join(f"b{i}: 1 kg" for i in range(count))
    stops = "".join(
        f"  s{i}: {{between: [b{i}, ground], gap: 1 mm, acts: compression, k: 1 kN/m}}\n"
        for i in range(count)
    )
    frictions = "".join(f"  f{i}: {{between: [b{i}, ground], mu: 0.01}}\n" for i in range(100))
    text = f"bodies: {{{bodies}}}\nstops:\n{stops}friction:\n{frictions}"
    start = "initial: {b139: {v: 0.1 m/s}, b99: {v: 0.1 m/s}}\nrun: {t_end: 30 ms, every: 10 ms}\n"
    case = load_case_text(text + start)
    result = vibsim.simulate(case, trust=False)
    assert result.events["part"].dtype == "i2"
    counts = part_counts(result, case.scene())
    assert [name for name, of_part in counts.items() if of_part.get("impacts")] == ["s99", "s139"]


def test_a_run_that_fails_says_where_and_what_helps():
    error = EngineError("diverged", State(1.5, [np.inf], [2.0], 0.0, 0.0, 0.0))
    assert str(error) == (
        "t = 1.5 s: the state is no longer finite (x = inf m, v = 2.0 m/s); check the parameters for values "
        "far outside each other's scale"
    )
