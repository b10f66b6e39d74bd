"""Scenes of named parts, run and recorded: columns by name, files, trust, distances, counts."""

import csv
from dataclasses import replace
from decimal import Decimal
from fractions import Fraction

import h5py
import numpy as np
import pytest

import vibsim
from tests.formula_cases import DRIVE, MACHINE, STATES, case_of, fading, machine, turned
from vibsim.cases import load_case
from vibsim.cases.case import load_case_text
from vibsim.engine.blocks import part_offsets
from vibsim.engine.errors import EngineError, State
from vibsim.engine.resume import resume_point
from vibsim.engine.trajectory import open_trajectory
from vibsim.physics.connections import event_parts
from vibsim.physics.formula_values import motion_of_base, motion_of_belt
from vibsim.physics.formulas import Node
from vibsim.physics.parts import EVENT_KINDS, ROTOR, STATE, Body, Scene
from vibsim.results import ResultFileError, simulate_to_file
from vibsim.results.columns import closing_velocities, part_counts, starts_of, tables_of, written_unit
from vibsim.results.many_digits import agreement
from vibsim.results.parallel_runs import companion_scene, towards, with_numbers
from vibsim.results.result import write_csv

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


ROOM = """
bodies: {b: 1 kg}
base: {a: 20 mm, omega: 1 Hz}
clearances: {other: {between: [base, b], distance: 1 m}, room: {between: %s, distance: 1 m}}
initial: {b: {v: 0.1 m/s}}
run: {t_end: 3 s, every: 10 ms}
"""


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
    if needed is None:
        t = 3 - np.arccos(0.1 / (0.04 * np.pi)) / (2 * np.pi)
        needed = max(0.1 * t - 0.02 * np.sin(2 * np.pi * t), 0.3)
    attrs = vibsim.simulate(load_case_text(ROOM % ends)).attrs
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
    said = (
        "t = 1.5 s: the state is no longer finite (x = inf m, v = 2.0 m/s); check the parameters for values"
    )
    assert str(error) == f"{said} far outside each other's scale"


# Rotors and further states in results: columns with units, files, exports, errors, events of formulas.


__all__ = ["machine"]
HIDDEN = {"x_i", "x_left", "v_left", "v_i", None}


@pytest.fixture(scope="module")
def turning(machine):
    return vibsim.simulate(machine)


@pytest.fixture(scope="module")
def file(machine, tmp_path_factory):
    path = tmp_path_factory.mktemp("run") / "machine.h5"
    simulate_to_file(machine, path)
    return path


def test_columns_have_names_units_and_meanings(turning, file):
    names = ["time", *STATES, "wall", "error_estimate"]
    assert list(turning) == list(vibsim.open_result(file)) == names
    columns = turning.arrays().datasets
    units = {name: columns[name].column.units for name in STATES}
    assert units == {
        "x_cart": "m", "v_cart": "m s-1", "phi_left": "rad", "w_left": "rad s-1", "i": "A",
    }  # fmt: skip
    assert columns["phi_left"].column.long_name == "angle of the rotor left"
    assert columns["i"].column.long_name == "state i"
    assert not HIDDEN & set(turning.events)


def test_values_are_those_of_closed_forms(turning, file):
    for result in (turning, vibsim.open_result(file)):
        t = np.asarray(result["time"])
        angle, speed = np.array([turned(each) for each in t]).T
        assert np.asarray(result["phi_left"]) == pytest.approx(angle, rel=1e-14)
        assert np.asarray(result["w_left"]) == pytest.approx(speed, rel=1e-14)
        assert np.asarray(result["i"]) == pytest.approx([fading(each) for each in t], rel=1e-14)
        between = result.at(np.array([0.1234567, 0.7654321]))
        assert set(between) == {"time", *STATES, "wall"}
        assert between["i"] == pytest.approx([fading(0.1234567), fading(0.7654321)], rel=1e-14)
        assert between["phi_left"] == pytest.approx([turned(0.1234567)[0], turned(0.7654321)[0]], rel=1e-14)


def test_exports_have_them(turning, tmp_path):
    frame = turning.to_dataframe()
    assert list(frame.columns)[:5] == list(STATES) and frame.attrs["units"]["i"] == "A"
    data = turning.to_xarray()
    assert data["w_left"].attrs["units"] == "rad s-1" and data["i"].attrs["long_name"] == "state i"
    for events, table in ((False, turning), (True, turning.events)):
        path = tmp_path / f"{events}.csv"
        write_csv(turning, path, (0.0, 1.0), events=events)
        with open(path, newline="", encoding="ascii") as text:
            header, *rows = csv.reader(text)
        assert [name for name in header if name in STATES] == list(STATES)
        assert float(rows[-1][header.index("i")]) == float(table["i"][-1])
    assert "switch" in [row[1] for row in rows] and "push" in [row[2] for row in rows]


def test_a_switch_is_an_event_of_the_part_whose_formula_jumps(turning, file, machine):
    assert event_parts(machine.scene()) == ("wall", "push")
    for events in (turning.events, vibsim.open_result(file).events):
        rows = np.flatnonzero(events["kind"] == EVENT_KINDS["switch"])
        assert np.asarray(events["t"])[rows] == pytest.approx([0.3], rel=1e-15)
        assert [events.words(name)[rows[0]] for name in ("kind", "part")] == ["switch", "push"]
    with h5py.File(file) as stored:
        assert stored["events/part"].attrs["flag_meanings"] == "none wall push"


def test_scenes_without_switches_have_no_such_kind():
    kinds = tables_of(vibsim.load_case("II-B").scene()).events["kind"].flags
    assert "switch" not in kinds and kinds["end"] == 8
    smooth = MACHINE.replace("*where(t < t1, 1, 2)", "").replace(", t1: 0.3 s", "")
    assert "switch" not in tables_of(case_of(smooth).scene()).events["kind"].flags
    assert event_parts(case_of(smooth).scene()) == ("wall",)


def test_a_part_is_numbered_by_kind_of_event(machine):
    """Numbers of stops begin at 0, those of switches are of all parts."""
    first = part_offsets(machine.scene())
    assert first[EVENT_KINDS["contact_begin"]] == first[EVENT_KINDS["switch"]] == 0


def test_a_run_goes_on_from_the_rows_of_a_switch(turning, machine):
    """Bit for bit, with the hidden x of the state at 0."""
    row = {name: np.asarray(column)[3] for name, column in turning.events.items()}
    assert row["kind"] == EVENT_KINDS["switch"]
    state, _, _ = resume_point(machine.scene(), row)
    assert state.x[2] == 0.0 and state.v[2] == row["i"]
    later = [block.events for block in open_trajectory(machine.scene(), resume=row).blocks()]
    for name in STATES:
        behind = np.concatenate([block[name] for block in later])
        assert behind.tolist() == np.asarray(turning.events[name])[3:].tolist()


def test_displacements_decide_about_errors_not_states():
    """A state that nothing bounds grows to 1e9, and the horizon is that of the cart."""
    growing = MACHINE.replace("-i/T", "i/T").replace("T: 0.5 s", "T: 0.04 s")
    turning = vibsim.simulate(case_of(growing))
    assert float(turning["i"][-1]) > 1e9
    assert turning.trust_horizon == 1.0 and float(turning["error_estimate"].max()) < 1e-12
    tables = tables_of(turning.case.scene())
    assert tables.deciding == tables.displacements == ("x_cart",)


def test_where_no_body_is_on_the_line_angles_and_states_decide():
    bodies = (Body("left", 1.0, 0.0, 1.0, kind=ROTOR), Body("i", 1.0, 0.0, 0.5, kind=STATE))
    tables = tables_of(Scene(bodies=bodies, state_units=(("i", "A"),), t_end=1.0))
    assert tables.deciding == ("phi_left", "i") and tables.displacements == ()
    assert tables.judged().samples["error_estimate"].units == "rad"


def test_torsional_scenes_are_in_radians(tmp_path):
    turning = vibsim.simulate(case_of(DRIVE))
    columns = turning.arrays().datasets
    units = [columns[name].column.units for name in ("x_disc", "v_load", "error_estimate")]
    assert units == ["rad", "rad s-1", "rad"]
    assert dict(turning.lines())["right"] == "to 1e-6 rad over the whole run"


def test_many_digits_have_them(machine):
    turning = vibsim.simulate(machine.replace({"run.t_end": "0.1 s"}), digits=30)
    assert list(turning.digits) == list(STATES) and list(turning.digits.events) == ["t", *STATES]
    exact = (-2 * Decimal.from_float(0.1)).exp() / 2  # samples are at doubles
    assert abs(Decimal(str(turning.digits["i"][-1])) - exact) < Decimal("1e-28")


def test_a_state_does_not_lend_its_size_to_velocities():
    """A state called like a velocity counts by itself where digits are compared."""
    first = {"v_cart": Decimal("1e-20"), "voltage": Decimal(5)}
    second = {"v_cart": Decimal("2e-20"), "voltage": Decimal(5)}
    assert agreement(first, second, {"voltage"}) < 1 < agreement(first, second)


def test_velocities_in_front_of_blows_leave_states_out():
    rigid = MACHINE.replace("k: 1e4 N/m}", "law: rigid, e: 0.5}")
    turning = vibsim.simulate(case_of(rigid))
    before = [name for name in turning.events if name.startswith("before_")]
    assert before == ["before_v_cart", "before_w_left"]
    struck = np.asarray(turning.events["kind"]) == EVENT_KINDS["impact"]
    ratio = np.asarray(turning.events["v_cart"])[struck] / np.asarray(turning.events["before_v_cart"])[struck]
    assert ratio == pytest.approx(np.full(struck.sum(), -0.5), rel=1e-12)


@pytest.mark.parametrize(
    ("unit", "written"),
    (("A", "A"), ("", "1"), ("N s/m^2", "N s m-2"), ("1/s", "s-1"), ("m^2/s^2/K", "m2 s-2 K-1"),
     ("J/(kg K)", "J kg-1 K-1"), ("N/m^1.5", "N m-1.5")),
)  # fmt: skip
def test_units_as_files_write_them(unit, written):
    assert written_unit(unit) == written


def test_start_values_read_back(machine):
    """What the columns of a state are called in a case, whose start values it then is."""
    starts = starts_of(machine.scene(), is_long=True)
    values = dict(zip(STATES, (0.001, 0.2, 1.5, 7.0, 0.25), strict=True))
    texts = {key: f"{values[name]!r} {unit}" for name, (key, unit) in starts.items()}
    cart, left, i = machine.with_values(texts).scene().bodies
    assert (cart.x, cart.v, left.x, left.v, i.v) == (0.001, 0.2, 1.5, 7.0, 0.25)


def test_the_companion_has_other_roundings_in_formulas(machine):
    """Numbers that are no doubles lie on the other side of their exact values, pi among them."""
    node: Node = ("mul", ("num", 2), ("mul", ("pi",), ("x", 0)))
    assert with_numbers(node, node, towards)[1] == ("num", 2)
    assert with_numbers(node, node, towards)[2][1] == ("num", np.nextafter(np.pi, 4))
    scene = machine.scene()
    moved = with_numbers(scene.links, scene.links, towards)
    assert moved == scene.links  # 400, 1e5 and 2 are doubles
    third = replace(scene.links[0], force=("num", vibsim.load_case("II-B").quantity("c").value / 3))
    (number,) = with_numbers((third,), (third,), towards)
    assert abs(number.force[1] - third.force[1]) > 0 and float(number.force[1]) != float(third.force[1])


@pytest.mark.parametrize("kind", ["linear", "cubic"])
def test_what_moves_by_a_table_rests_outside_of_its_knots(kind):
    """Its slope at the first knot, and at the last, is that within."""
    text = f"""
bodies: {{a: 1 kg}}
stops: {{w: {{between: [a, base], gap: 5 mm, acts: extension, law: rigid, e: 0.8}}}}
friction: {{f: {{between: [a, ground], N: 0 N, mu: 0.1, V: 1 m/s, T: 50 ms,
  belt: "V*table(t/T, [[1, 0], [2, 0.5], [3, 1], [4, 3]], '{kind}')"}}}}
forces: {{g: {{on: a, F0: -9.81 N}}}}
base: {{x: "A*table(t/T, [[1, 0], [2, 0.5], [3, 1], [4, 3]], '{kind}')", A: 1 mm, T: 50 ms}}
initial: {{a: {{x: 50 mm}}}}
run: {{t_end: 1 s, every: 1 ms}}
"""
    run = vibsim.simulate(text, trust=False)
    scene = run.case.scene()
    for t in (0.0, 0.04, 0.2, 0.6):
        assert motion_of_base(scene, t)[1:] == (0, 0) == (motion_of_belt(scene.frictions[0], t)[1], 0)
    assert motion_of_base(scene, 0.12)[1] > 0
    speeds = closing_velocities(scene, run.events)
    late = speeds[(run.events["t"] > 0.2) & (speeds > 1e-6)]
    np.testing.assert_allclose(late[1:], 0.8 * late[:-1], rtol=1e-9)  # on a base at rest
    assert len(late) > 10
