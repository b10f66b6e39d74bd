"""Rotors and further states in results: columns with units, files, exports, errors, events of formulas."""

import csv
from dataclasses import replace
from decimal import Decimal

import h5py
import numpy as np
import pytest

import vibsim
from tests.formula_cases import DRIVE, MACHINE, STATES, case_of, fading, machine, turned
from vibsim.engine.blocks import part_offsets
from vibsim.engine.resume import resume_point
from vibsim.engine.trajectory import open_trajectory
from vibsim.physics.connections import event_parts
from vibsim.physics.formulas import Node
from vibsim.physics.parts import EVENT_KINDS, ROTOR, STATE, Body, Scene
from vibsim.results import simulate_to_file
from vibsim.results.columns import starts_of, tables_of, written_unit
from vibsim.results.many_digits import agreement
from vibsim.results.parallel_runs import towards, with_numbers
from vibsim.results.result import write_csv

__all__ = ["machine"]
HIDDEN = {"x_i", "x_left", "v_left", "v_i", None}


@pytest.fixture(scope="module")
def run(machine):
    return vibsim.simulate(machine)


@pytest.fixture(scope="module")
def file(machine, tmp_path_factory):
    path = tmp_path_factory.mktemp("run") / "machine.h5"
    simulate_to_file(machine, path)
    return path


def test_columns_have_names_units_and_meanings(run, file):
    names = ["time", *STATES, "wall", "error_estimate"]
    assert list(run) == list(vibsim.open_result(file)) == names
    columns = run.arrays().datasets
    units = {name: columns[name].column.units for name in STATES}
    assert units == {
        "x_cart": "m", "v_cart": "m s-1", "phi_left": "rad", "w_left": "rad s-1", "i": "A",
    }  # fmt: skip
    assert columns["phi_left"].column.long_name == "angle of the rotor left"
    assert columns["i"].column.long_name == "state i"
    assert not HIDDEN & set(run.events)


def test_values_are_those_of_closed_forms(run, file):
    for result in (run, vibsim.open_result(file)):
        t = np.asarray(result["time"])
        angle, speed = np.array([turned(each) for each in t]).T
        assert np.asarray(result["phi_left"]) == pytest.approx(angle, rel=1e-14)
        assert np.asarray(result["w_left"]) == pytest.approx(speed, rel=1e-14)
        assert np.asarray(result["i"]) == pytest.approx([fading(each) for each in t], rel=1e-14)
        between = result.at(np.array([0.1234567, 0.7654321]))
        assert set(between) == {"time", *STATES, "wall"}
        assert between["i"] == pytest.approx([fading(0.1234567), fading(0.7654321)], rel=1e-14)
        assert between["phi_left"] == pytest.approx([turned(0.1234567)[0], turned(0.7654321)[0]], rel=1e-14)


def test_exports_have_them(run, tmp_path):
    frame = run.to_dataframe()
    assert list(frame.columns)[:5] == list(STATES) and frame.attrs["units"]["i"] == "A"
    data = run.to_xarray()
    assert data["w_left"].attrs["units"] == "rad s-1" and data["i"].attrs["long_name"] == "state i"
    for events, table in ((False, run), (True, run.events)):
        path = tmp_path / f"{events}.csv"
        write_csv(run, path, (0.0, 1.0), events=events)
        with open(path, newline="", encoding="ascii") as text:
            header, *rows = csv.reader(text)
        assert [name for name in header if name in STATES] == list(STATES)
        assert float(rows[-1][header.index("i")]) == float(table["i"][-1])
    assert "switch" in [row[1] for row in rows] and "push" in [row[2] for row in rows]


def test_a_switch_is_an_event_of_the_part_whose_formula_jumps(run, file, machine):
    assert event_parts(machine.scene()) == ("wall", "push")
    for events in (run.events, vibsim.open_result(file).events):
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


def test_a_run_goes_on_from_the_rows_of_a_switch(run, machine):
    """Bit for bit, with the hidden x of the state at 0."""
    row = {name: np.asarray(column)[3] for name, column in run.events.items()}
    assert row["kind"] == EVENT_KINDS["switch"]
    state, _, _ = resume_point(machine.scene(), row)
    assert state.x[2] == 0.0 and state.v[2] == row["i"]
    later = [block.events for block in open_trajectory(machine.scene(), resume=row).blocks()]
    for name in STATES:
        behind = np.concatenate([block[name] for block in later])
        assert behind.tolist() == np.asarray(run.events[name])[3:].tolist()


def test_displacements_decide_about_errors_not_states():
    """A state that nothing bounds grows to 1e9, and the horizon is that of the cart."""
    growing = MACHINE.replace("-i/T", "i/T").replace("T: 0.5 s", "T: 0.04 s")
    run = vibsim.simulate(case_of(growing))
    assert float(run["i"][-1]) > 1e9
    assert run.trust_horizon == 1.0 and float(run["error_estimate"].max()) < 1e-12
    tables = tables_of(run.case.scene())
    assert tables.deciding == tables.displacements == ("x_cart",)


def test_where_no_body_is_on_the_line_angles_and_states_decide():
    bodies = (Body("left", 1.0, 0.0, 1.0, kind=ROTOR), Body("i", 1.0, 0.0, 0.5, kind=STATE))
    tables = tables_of(Scene(bodies=bodies, state_units=(("i", "A"),), t_end=1.0))
    assert tables.deciding == ("phi_left", "i") and tables.displacements == ()
    assert tables.judged().samples["error_estimate"].units == "rad"


def test_torsional_scenes_are_in_radians(tmp_path):
    run = vibsim.simulate(case_of(DRIVE))
    columns = run.arrays().datasets
    assert [columns[name].column.units for name in ("x_disc", "v_load", "error_estimate")] == [
        "rad", "rad s-1", "rad",
    ]  # fmt: skip
    assert dict(run.lines())["right"] == "to 1e-6 rad over the whole run"


def test_many_digits_have_them(machine):
    run = vibsim.simulate(machine.replace({"run.t_end": "0.1 s"}), digits=30)
    assert list(run.digits) == list(STATES) and list(run.digits.events) == ["t", *STATES]
    exact = (-2 * Decimal.from_float(0.1)).exp() / 2  # samples are at doubles
    assert abs(Decimal(str(run.digits["i"][-1])) - exact) < Decimal("1e-28")


def test_a_state_does_not_lend_its_size_to_velocities():
    """A state called like a velocity counts by itself where digits are compared."""
    first = {"v_cart": Decimal("1e-20"), "voltage": Decimal(5)}
    second = {"v_cart": Decimal("2e-20"), "voltage": Decimal(5)}
    assert agreement(first, second, {"voltage"}) < 1 < agreement(first, second)


def test_velocities_in_front_of_blows_leave_states_out():
    rigid = MACHINE.replace("k: 1e4 N/m}", "law: rigid, e: 0.5}")
    run = vibsim.simulate(case_of(rigid))
    before = [name for name in run.events if name.startswith("before_")]
    assert before == ["before_v_cart", "before_w_left"]
    struck = np.asarray(run.events["kind"]) == EVENT_KINDS["impact"]
    ratio = np.asarray(run.events["v_cart"])[struck] / np.asarray(run.events["before_v_cart"])[struck]
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
