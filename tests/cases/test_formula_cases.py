"""Cases with formulas: every place where one may stand, names and units there, what is wrong with them."""

import json
from fractions import Fraction

import numpy as np
import pytest

from vibsim.cases import CaseError
from vibsim.cases.case import Case, load_case, load_case_text
from vibsim.physics.formulas import PI, ZERO, add, call, choose, div, mul, num, power, reads, sub
from vibsim.physics.parts import BASE, BODY, ROTOR, STATE, Rotor

ONE = "bodies: {a: 1 kg}\n"
LINK = ONE + 'links: {s: {between: [a, ground], force: "%s", %s}}\n'
FRICTION = ONE + "friction: {f: {between: [a, ground], %s}}\n"
STATE_I = ONE + 'states: {i: {rate: "%s", %s}}\n'
ROTOR_R = ONE + "rotors: {r: {on: a, %s}}\n"
MOTOR = ONE + "motor: {on: a, m3: 0.1 kg, e: 0.1 m, J: 0.01 kg m^2, %s}\n"
TURNING = "bodies: {d1: 0.3 kg m^2, d2: 0.1 kg m^2}\n"
X, V, T = ("x", 0), ("v", 0), ("t",)


def scene_of(text, overrides=None):
    """The scene of a case, which its stored forms read back to as well."""
    return reads_back(load_case_text(text, overrides))


def reads_back(case):
    """The scene of a case that its stored forms give too."""
    scene = case.scene()
    stored = Case.from_resolved_json(case.resolved_json())
    again = load_case_text(case.to_yaml())
    assert stored.values == case.values and stored.sha256 == case.sha256
    assert again.sha256 == case.sha256
    assert stored.scene() == again.scene() == scene
    return scene


def problems_of(text, overrides=None):
    with pytest.raises(CaseError) as raised:
        load_case_text(text, overrides)
    return [str(problem) for problem in raised.value.problems]


# Places.


def test_a_link_drives_its_ends_together():
    scene = scene_of(LINK % ("k*d + k3*d**3 + c*v*abs(v)", "k: -200 N/m, k3: 2 kN/m^3, c: 3 N s^2/m^2"))
    (link,) = scene.links
    cubic = mul(num(2000), power(X, num(3)))
    drag = mul(mul(num(3), V), choose(V, V, mul(num(-1), V), "abs(v)"))
    assert (link.k, link.c, link.force) == (0, 0, add(add(mul(num(-200), X), cubic), drag))


def test_a_link_between_bodies_and_the_base_sees_their_distance():
    text = "bodies: {a: 1 kg, b: 2 kg}\nlinks:\n  s: {between: [b, a], force: q*d*v, q: 1 N s/m^2}\n"
    text += "  u: {between: [a, base], force: q*d*d, q: 1 N/m^2}\nbase: {x: a*sin(w*t)*t, a: 1 mm/s, w: 2 Hz}"
    scene = scene_of(text)
    assert scene.links[0].force == mul(sub(("x", 1), ("x", 0)), sub(("v", 1), ("v", 0)))
    assert scene.links[1].force == mul(sub(("x", 0), ("x", BASE)), sub(("x", 0), ("x", BASE)))
    assert scene.base == () and scene.base_formula == mul(
        mul(num(Fraction(1, 1000)), call("sin", mul(mul(num(4), PI), T))), T
    )


@pytest.mark.parametrize(("acts", "sense", "depth"), [("compression", -1, X), ("extension", 1, sub(ZERO, X))])
def test_a_stop_sees_its_depth_and_its_rate(acts, sense, depth):
    text = f"{ONE}stops: {{w: {{between: [a, ground], gap: 1 mm, acts: {acts}, release: force, "
    (stop,) = scene_of(text + "force: K*p**1.5*(1 + lam*pv), K: 1e6 N/m^1.5, lam: 0.3 s/m}}").stops
    p, pv = sub(depth, num(Fraction(1, 1000))), V if sense < 0 else sub(ZERO, V)
    force = mul(mul(num(10**6), ("pow", p, Fraction(3, 2))), add(num(1), mul(num(Fraction(3, 10)), pv)))
    assert (stop.force, stop.sense, stop.release, stop.k, stop.c) == (force, sense, "force", 0, 0)


def test_friction_falls_and_holds_as_its_formula_says():
    keys = "mu: mu_d + (mu_s - mu_d)*exp(-s/v0), mu_s: 0.3, mu_d: 0.2, v0: 0.1 m/s, "
    keys += "N: 10 N, belt: 0.5 m/s, static: 1.2"
    (friction,) = scene_of(FRICTION % keys).frictions
    forward = sub(V, num(Fraction(1, 2)))

    def force(speed):
        falls = call("exp", mul(num(-10), speed))
        return mul(num(10), add(num(Fraction(1, 5)), mul(num(Fraction(1, 10)), falls)))

    assert friction.slips == (force(forward), force(mul(num(-1), forward)))
    assert friction.holds is None and (friction.forward, friction.backward) == (3.0, 3.0)
    assert friction.limits == (3.6, 3.6) and friction.drops(1) and friction.belt == 0.5


def untold(node):
    """A formula without the texts of its switches."""
    parts = node[:4] if node and node[0] == "choose" else node
    return tuple(untold(part) if isinstance(part, tuple) else part for part in parts)


@pytest.mark.parametrize(
    ("written", "meant"),
    [
        ("mu_d + m*exp(-(abs(s)/v0)**2)", "mu_d + m*exp(-(s/v0)**2)"),
        ("mu_d + m*abs(-3*s/v0)", "mu_d + m*3*s/v0"),
        ("mu_d + m*max(s, 0 m/s)/v0", "mu_d + m*s/v0"),
        ("where(abs(s) < v0, m, mu_d)", "where(s < v0, m, mu_d)"),
        ("mu_d + m*min(-2*s, 0 m/s)/v0", "mu_d + m*(-2*s)/v0"),
    ],
)
def test_a_slip_speed_is_its_own_size(written, meant):
    keys = "mu: '%s', mu_d: 0.2, m: 0.1, v0: 0.1 m/s, N: 10 N, belt: 0.5 m/s"
    (one,), (other,) = (scene_of(FRICTION % (keys % text)).frictions for text in (written, meant))
    assert untold(one.slips) == untold(other.slips) and one.holds == other.holds
    kept = scene_of(FRICTION % (keys % "mu_d + m*abs(s - v0)/v0")).frictions[0].slips
    assert kept != scene_of(FRICTION % (keys % "mu_d + m*(s - v0)/v0")).frictions[0].slips


@pytest.mark.parametrize(
    ("text", "order"),
    [
        (LINK % ("k*d + k3*d**3", "k: 200 N/m, k3: 2 kN/m^3"), 32),
        (ROTOR_R % "m: 0.1 kg, e: 0.1 m, J: 0 kg m^2", 32),
        (ONE + "forces: {f: {on: a, force: A*sin(w*t**2), A: 1 N, w: 1 rad/s^2}}", 32),
        (LINK % ("k*d + c*v", "k: 200 N/m, c: 2 N s/m"), 20),  # which is no formula
        (LINK % ("k*d + c*v*abs(v)", "k: 200 N/m, c: 2 N s^2/m^2"), 20),
        (LINK % ("k*d + k3*d**3", "k: 200 N/m, k3: 2 kN/m^3") + "run: {order: 24}", 24),
        (STATE_I % ("-k*i + x_a*q", "start: 0 A, k: 1/s, q: 1 A/m/s"), 20),
        (FRICTION % "mu: 0.3*(1 + s/v0), v0: 1 m/s, N: 1 N", 20),
        (ONE + "links: {s: {between: [a, ground], k: 1 N/m}}", 20),
    ],
)
def test_the_order_of_the_series_is_higher_where_all_is_smooth(text, order):
    case = load_case_text(text)
    assert scene_of(text).order == order == json.loads(case.resolved_json())["run"]["order"]
    keys = list(case.values)
    assert keys.index("run.order") == keys.index("run.method") + 1


def test_friction_has_its_weight_where_no_load_is_given():
    (friction,) = scene_of(FRICTION % "mu: m0*(1 + s/v1), m0: 0.2, v1: 1 m/s, g: 10 m/s^2").frictions
    assert friction.limits == (2, 2) and friction.holds is None and not friction.drops(1)


def test_a_load_may_be_a_formula_of_every_law():
    keys = "N: m*g + kn*x_a, m: 1 kg, g: 10 m/s^2, kn: 5 N/m, "
    load = add(num(10), mul(num(5), X))
    load = choose(load, load, ZERO, "N of f")
    (coulomb,) = scene_of(FRICTION % (keys + "mu: 0.3, static: 2")).frictions
    assert coulomb.slips == (mul(num(Fraction(3, 10)), load),) * 2
    assert coulomb.holds == (mul(num(Fraction(6, 10)), load),) * 2
    (falling,) = scene_of(
        FRICTION % (keys + "law: stribeck hyperbolic, mu_s: 0.4, mu_d: 0.1, d: 3 s/m")
    ).frictions
    share = div(num(1), add(num(1), mul(num(3), V)))
    assert falling.slips[0] == mul(add(num(Fraction(1, 10)), mul(num(Fraction(3, 10)), share)), load)
    assert falling.holds[1] == mul(num(Fraction(4, 10)), load)


def test_one_direction_of_friction_may_have_a_formula():
    keys = "N: 2 N, plus: {mu: m0 + s/v1, m0: 0.2, v1: 1 m/s}, minus: {mu: 0.5, static: 2}"
    (friction,) = scene_of(FRICTION % keys).frictions
    assert friction.slips == (mul(num(2), add(num(Fraction(1, 5)), V)), num(1))
    assert (friction.holds, friction.limits) == (None, (0.4, 2.0))
    assert friction.drops(-1) and not friction.drops(1)
    case = load_case_text(FRICTION % keys)
    assert case.number("friction.f.plus.m0") == 0.2
    assert case.with_values({"friction.f.plus.m0": 0.4}).scene().frictions[0].limits[0] == 0.8


def test_forces_rates_and_torques_are_forces_on_what_they_drive():
    text = ONE + "forces: {p: {on: a, force: B*x_a*z, B: 2 N/m}}\n"
    text += "states: {z: {rate: (1 - z)/tau, start: 0.5, tau: 2 s}}\n"
    text += "rotors: {r: {on: a, m: 0.1 kg, e: 0.2 m, J: 0.01 kg m^2, "
    text += "torque: -b*w - m*g*e*cos(phi), b: 1 N m s, g: 10 m/s^2}}\n"
    text += "initial: {r: {phi: -90 deg, w: 2 Hz}}\n"
    scene = scene_of(text)
    assert [(body.name, body.kind) for body in scene.bodies] == [("a", BODY), ("r", ROTOR), ("z", STATE)]
    a, r, z = scene.bodies
    assert (a.m, r.m, z.m, z.v) == (1.1, 0.014, 1, 0.5)
    assert (r.x, r.v) == pytest.approx((-1.5707963267948966, 12.566370614359172), rel=1e-16)
    assert scene.rotors == (Rotor(1, 0, 0.02),)
    assert [(force.name, force.on) for force in scene.forces] == [("p", 0), ("r", 1), ("z", 2)]
    load, torque, rate = (force.formula for force in scene.forces)
    assert load == mul(mul(num(2), X), ("v", 2))
    assert torque == sub(mul(num(-1), ("v", 1)), mul(num(Fraction(1, 5)), call("cos", ("x", 1))))
    assert rate == mul(num(Fraction(1, 2)), sub(num(1), ("v", 2)))


def test_rotors_may_have_the_torque_of_a_motor_or_none():
    scene = scene_of(ROTOR_R % "m: 0.1 kg, e: 0.1 m, J: 1 kg m^2, M0: 3 N m, Omega0: 2 Hz")
    (torque,) = scene.forces
    assert torque.formula == mul(num(3), sub(num(1), div(("v", 1), mul(num(4), PI))))
    assert scene_of(ROTOR_R % "J: 1 kg m^2").forces == ()


@pytest.mark.parametrize(
    "keys",
    [
        "M0: 1 N m, Omega0: 3 Hz + r*t, r: 0.1 Hz/s",
        "M0: M1*t/T1, M1: 1 N m, T1: 10 s, Omega0: 3 Hz",
        "torque: M0*(1 - w**2/Omega0**2), M0: 1 N m, Omega0: 3 Hz",
    ],
)
def test_a_motor_with_a_formula_is_a_rotor(keys):
    scene = scene_of(MOTOR % keys + "initial: {motor: {phi: 1 rad, phidot: 2 rad/s}}")
    a, motor = scene.bodies
    assert (scene.motor, a.name, a.kind, a.m) == (None, "a", BODY, 1.1)
    assert (motor.name, motor.kind, motor.m, motor.x, motor.v) == ("motor", ROTOR, 0.011, 1, 2)
    assert [force.name for force in scene.forces] == ["motor"]


def test_formulas_read_the_rotor_of_a_plain_motor():
    scene = scene_of(
        MOTOR % "M0: 1 N m, Omega0: 3 Hz" + "forces: {p: {on: a, force: b*w*sin(2*phi), b: 1 N s}}"
    )
    assert scene.motor is not None
    assert scene.forces[0].formula == mul(("w",), ("sin", mul(num(2), ("phi",))))


@pytest.mark.parametrize("force", ["b*w*phi, b: 1 N s", "F*sin(phi/2), F: 1 N", '"F*mod(phi, 2*pi)", F: 1 N'])
def test_a_motor_whose_turns_are_counted_is_a_rotor(force):
    """The engines keep the angle of the paper's motor within a turn, that of a rotor in full."""
    scene = scene_of(MOTOR % "M0: 1 N m, Omega0: 3 Hz" + f"forces: {{p: {{on: a, force: {force}}}}}")
    assert scene.motor is None
    assert [body.kind for body in scene.bodies] == [BODY, ROTOR]


def test_a_motor_beside_rotors_on_its_body_is_one_of_them():
    rotor = "rotors: {r: {on: a, m: 0.1 kg, e: 0.1 m, J: 0 kg m^2}}"
    scene = scene_of(MOTOR % "M0: 1 N m, Omega0: 3 Hz" + rotor)
    assert scene.motor is None
    assert [(body.name, body.kind) for body in scene.bodies[-2:]] == [("r", ROTOR), ("motor", ROTOR)]


def test_the_short_form_takes_formulas_of_its_motor():
    case = load_case("II-B", {"Omega0": "3 Hz + r*t", "r": "0.01 Hz/s"})
    scene = reads_back(case)
    speed = add(mul(num(6), PI), mul(mul(num(Fraction(1, 50)), PI), T))
    torque = mul(num(Fraction(5, 1000)), sub(num(1), div(("v", 2), speed)))
    assert [force.formula for force in scene.forces] == [torque]
    assert load_case_text(case.long_text()).scene() == scene
    assert case.frequency() is None and "source motor," in repr(case)
    with pytest.raises(CaseError, match="a formula has no symbol of the paper"):
        case.two_blocks()
    parameters = {"parameters.U": "12 V", "parameters.U1": "24 V"}
    driven = load_case("II-B", {"Omega0": "w1*U/U1*(1 + t/T)", "T": "10 s", "w1": "5 Hz", **parameters})
    (torque,) = driven.scene().forces
    assert torque.name == "motor" and reads([torque.formula], ["v", "t"])


def test_numbers_of_parameters_are_hidden_by_those_beside():
    text = "parameters: {k: 5 N/m, q: 2 N/m}\n" + LINK % ("k*d + q*d", "k: 3 N/m")
    assert scene_of(text).links[0].k == 5


def test_torsional_scenes_turn():
    text = TURNING + "links: {s: {between: [d1, d2], k: 30 N m/rad, c: 0.1 N m s/rad}}\n"
    text += "stops: {w: {between: [d1, d2], gap: 10 deg, acts: compression, k: 100 N m/deg}}\n"
    text += "friction: {f: {between: [d1, ground], mu: 0.5, N: 4 N m, belt: 3 rpm}}\n"
    text += "forces: {p: {on: d1, force: k*x_d2 + B*cos(w*t), k: 1 N m/rad, B: 2 N m, w: 1 Hz}}\n"
    text += "initial: {d1: {x: 10 deg, v: 1 Hz}, d2: {x: 0 rad}}\n"
    scene = scene_of(text)
    assert scene.torsional and [body.m for body in scene.bodies] == [0.3, 0.1]
    (stop,) = scene.stops
    assert stop.at_start, "10 deg is 10 deg, whatever pi is"
    assert stop.k == pytest.approx(100 * 57.29577951308232, rel=1e-15)
    assert scene.frictions[0].forward == 2 and scene.frictions[0].belt == pytest.approx(0.3141592653589793)
    assert scene.bodies[0].v == pytest.approx(6.283185307179586)
    exact = load_case_text(text).exact_scene(Fraction)
    assert exact.links[0].k == 30 and abs(exact.bodies[0].v / 2 - Fraction("3.14159265358979323846")) < 1e-19


def test_a_table_in_a_file_becomes_part_of_the_case(tmp_path, monkeypatch):
    (tmp_path / "load.csv").write_text("t [s], F [N]\n0, 1\n0.5, 2\n1, 0\n2, -3\n")
    child = tmp_path / "other" / "child.yaml"
    child.parent.mkdir()
    child.write_text("extends: ../parent.yaml\nrun: {t_end: 1 s}\n")
    formula = 'force: \'B*table(t, "load.csv", "cubic")\', B: 2'
    (tmp_path / "parent.yaml").write_text(f"{ONE}forces: {{p: {{on: a, {formula}}}}}\n")
    case = load_case(child)
    (tmp_path / "load.csv").unlink()
    assert reads_back(case).forces[0].formula[2][2] == (0, Fraction(1, 2), 1, 2)
    with pytest.raises(CaseError, match=r"parent.yaml:2:40: forces.p.force: table load.csv: cannot be read"):
        load_case(child)


# Numbers beside formulas by their paths.


def test_each_number_has_its_path_and_its_unit():
    case = load_case_text("parameters: {q: 1 m}\n" + LINK % ("k*d + k3*d**3*(q/q)", "k: 2 N/mm, k3: 1 N/m^3"))
    assert case.numeric_keys()[:4] == ["parameters.q", "bodies.a", "links.s.k", "links.s.k3"]
    assert (case.number("links.s.k"), case.quantity("k3").text) == (2000, "1 N/m^3")
    dimensions = [case.measured(key).dimension for key in ("links.s.k", "k3", "q", "bodies.a")]
    assert dimensions == ["stiffness", "N/m^3", "length", "mass"]
    changed = case.with_values({"links.s.k3": 7, "q": "3 mm"})
    assert (changed.quantity("k3").text, changed.number("q")) == ("7 N/m^3", 0.003)
    assert changed.sha256 != case.sha256


def test_bounds_of_built_in_laws_do_not_hold_beside_formulas():
    assert load_case_text(LINK % ("k*d + c*v", "k: -1 N/m, c: -1 N s/m")).measured("links.s.k").least is None


@pytest.mark.parametrize(
    ("overrides", "keys"),
    [
        ({"links.s.force": "k*d"}, {"force", "k"}),
        ({"links.s.force": "k*d + q*d**2", "links.s.q": "3 N/m^2"}, {"force", "k", "q"}),
        ({"q": "1 N/m^2", "links.s.force": "q*d**2"}, {"force", "q"}),
        ({"links.s.k": "5 N/m"}, {"force", "k", "c"}),
        ({"links.s.between": "[a, ground]"}, {"force", "k", "c"}),
    ],
)
def test_numbers_come_and_go_with_their_formula(overrides, keys):
    case = load_case_text(LINK % ("k*d + c*v", "k: 1 N/m, c: 1 N s/m"), overrides)
    assert {key.rpartition(".")[2] for key in case.values if key.startswith("links.s.")} - {"between"} == keys


def test_a_formula_takes_the_place_of_a_law_and_a_law_that_of_a_formula():
    law = "law: stribeck exponential, mu_s: 0.3, mu_d: 0.2, v0: 1 m/s"
    case = load_case_text(FRICTION % law, {"f.mu": "mu_d + s/v1", "f.v1": "1 m/s"})
    assert {"friction.f.mu_d", "friction.f.v1"} < set(case.values)
    assert {"friction.f.law", "friction.f.mu_s", "friction.f.v0"}.isdisjoint(case.values)
    back = case.with_values({"f.mu": 0.4})
    assert back.values["friction.f.law"] == "coulomb" and "friction.f.v1" not in back.values
    kept = load_case_text(FRICTION % "mu: mu_d + mu_s*s/v1, mu_d: 0.1, mu_s: 0.2, v1: 1 m/s", {"mu_s": 0.5})
    assert str(kept.values["friction.f.mu"]) == "mu_d + mu_s*s/v1"


def test_a_child_changes_numbers_and_formulas_of_its_parent(tmp_path):
    (tmp_path / "parent.yaml").write_text(LINK % ("k*d + k3*d**3", "k: 1 N/m, k3: 2 N/m^3"))
    child = tmp_path / "child.yaml"
    child.write_text("extends: parent.yaml\nlinks: {s: {k3: 5 N/m^3}}\n")
    assert load_case(child).number("k3") == 5
    child.write_text('extends: parent.yaml\nlinks: {s: {force: "k*d + c*v", c: 1 N s/m}}\n')
    assert "links.s.k3" not in load_case(child).values


# What is wrong, beyond the files in parts/invalid.


BLOCK = """bodies: {a: 1 kg}
links:
  s:
    between: [a, ground]
    force: %s
      k*d
      + k3*d**3
      + c*d
    k: 1 N/m
    k3: 1 N/m^3
    c: 2 N s/m
"""


@pytest.mark.parametrize("style", [">", "|", ""])
def test_a_formula_on_several_lines_keeps_its_places(style):
    (problem,) = problems_of(BLOCK % style)
    assert problem.startswith("case:8:9: links.s.force: "), problem


def test_a_place_behind_a_table_of_a_file_is_that_of_the_text(tmp_path):
    (tmp_path / "load.csv").write_text("t [s], F [N]\n" + "".join(f"{i}, {i}\n" for i in range(50)))
    path = tmp_path / "case.yaml"
    path.write_text(ONE + "forces: {p: {on: a, force: 'table(t, \"load.csv\") + q'}}\n")
    with pytest.raises(CaseError) as raised:
        load_case(path)
    (problem,) = raised.value.problems
    assert (problem.line, problem.column) == (2, 52)
    assert path.read_text().splitlines()[1][problem.column - 1 :].startswith("q'")


def test_problems_of_overrides_say_what_they_stand_in():
    (problem,) = problems_of(LINK % ("k*d", "k: 1 N/m"), {"links.s.force": "k*d + k"})
    assert problem == 'overrides links.s.force: "k*d + k": N + N/m: k is N/m, must be N'
    (problem,) = problems_of(LINK % ("k*d", "k: 1 N/m"), {"links.s.k9": "3"})
    assert problem.startswith("overrides links.s.k9: unknown key (did you mean links.s.k?)")


def test_stored_formulas_are_plain_texts():
    case = load_case_text(LINK % ("k*d", "k: 1 N/m"))
    stored = json.loads(case.resolved_json())
    assert stored["links"]["s"] == {"between": "[a, ground]", "force": "k*d", "k": "1 N/m"}


@pytest.mark.parametrize(
    ("mass", "stiffness", "every", "values"),
    [("2 ug", "3 uN/um", "50 ns", (2e-9, 3, 50e-9)), ("5 ng", "4 kg/s^2", "1e-3 ms", (5e-12, 4, 1e-6))],
)
def test_every_key_takes_composed_units(mass, stiffness, every, values):
    scene = scene_of(
        f"bodies: {{a: {mass}}}\nlinks: {{s: {{between: [a, ground], k: {stiffness}}}}}\n"
        f"run: {{t_end: 1 ms, every: {every}}}\n"
    )
    sample = scene.every_num / scene.every_den
    assert (scene.bodies[0].m, scene.links[0].k, sample) == pytest.approx(values, rel=1e-15)


def test_some_bodies_may_turn_and_others_move_along_a_line():
    scene = scene_of("""
bodies: {c: 1 kg, d: 0.1 kg m^2}
links: {s: {between: [d, ground], k: 4 N m/rad}, l: {between: [c, ground], k: 9 N/m}}
forces:
  p: {on: c, force: -kr*(x_c - r*x_d), kr: 2 N/m, r: 50 mm}
  q: {on: d, force: r*kr*(x_c - r*x_d), kr: 2 N/m, r: 50 mm}
initial: {d: {x: 90 deg}, c: {x: 3 mm}}
""")
    line, turning = scene.bodies
    assert (line.kind, line.turns, scene.unit_of(line), line.x) == (BODY, False, "m", 0.003)
    assert (turning.kind, turning.turns, scene.unit_of(turning), turning.x) == (BODY, True, "rad", np.pi / 2)


def test_a_belt_between_bodies_carries_rotors_but_no_plain_motor():
    text = """
bodies: {a: 1 kg, b: 1 kg}
friction: {f: {between: [a, b], N: 1 N, mu: 0.3, belt: "u*t", u: 0.1 m/s^2}}
motor: {on: a, m3: 0.03 kg, e: 0.11 m, J: 0.001 kg m^2, %s}
"""
    with pytest.raises(CaseError, match="body with a motor by M0 and Omega0 alone: it carries a"):
        load_case_text(text % "M0: 0.005 N m, Omega0: 3 Hz", name="case")
    torque = 'torque: "M0*(1 - w/Omega0)", M0: 0.005 N m, Omega0: 3 Hz'
    assert len(load_case_text(text % torque, name="case").scene().rotors) == 1
