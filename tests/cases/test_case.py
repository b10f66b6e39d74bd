"""The case object: canonical text, fingerprint, exact scenes, pickling."""

import json
import pickle
import subprocess
import sys
from fractions import Fraction
from html.parser import HTMLParser
from math import pi, sqrt

import mpmath
import pytest

import vibsim
from vibsim.cases import Case, CaseError, load_case, shipped_case_names
from vibsim.cases.case import load_case_text
from vibsim.cases.quantities import number
from vibsim.cases.validation import derived_facts
from vibsim.plots.subject import PlotError


def test_resolved_text_keeps_the_spelling_and_fills_in_units():
    case = load_case("II-B", {"Omega0": "330rpm", "G": 0.001})
    resolved = json.loads(case.resolved_json())
    assert resolved["excitation"]["Omega0"] == "330 rpm"
    assert resolved["stop"] == {"k2": "12400 N/m", "G": "0.001 m", "acts": "extension"}
    assert "extends" not in resolved and resolved["run"]["order"] == 20


@pytest.mark.parametrize(
    "same",
    [{"Omega0": "330 rpm"}, {"Omega0": "5.50 Hz"}, {"G": "0.001"}, {"name": "other", "title": "Another"}],
)
def test_fingerprint_is_of_the_physics(same):
    assert load_case("II-B", same).sha256 == load_case("II-B").sha256


@pytest.mark.parametrize(
    "other",
    [{"Omega0": "34.55751918948772 rad/s"}, {"G": "1.0000000000000000000001 mm"}, {"t_end": "301 s"},
     {"order": "21"}, {"stop": "none"}, {"acts": "compression"}],
)  # fmt: skip
def test_fingerprint_changes_with_what_is_simulated(other):
    assert load_case("II-B", other).sha256 != load_case("II-B").sha256


@pytest.mark.parametrize("text", ["", "{}", "[]", "3", "null", "{", "[" * 100_000, '{"vibsim_case": 2}'])
def test_other_json_is_refused(text):
    with pytest.raises(CaseError) as caught:
        Case.from_resolved_json(text)
    assert len(caught.value.problems) == 1


def test_a_damaged_resolved_text_gives_problems():
    text = load_case("II-B").resolved_json().replace("0.297 kg", "0.297 s").replace('"G": "1 mm"', '"G": NaN')
    with pytest.raises(CaseError) as caught:
        Case.from_resolved_json(text, source="run.h5")
    assert [(problem.file, problem.key) for problem in caught.value.problems] == [
        ("run.h5", "blocks.m1"),
        ("run.h5", "stop.G"),
    ]


def test_case_and_error_pickle():
    case = load_case("I-A-eq211")
    assert case.values and case.sha256
    again, omega = pickle.loads(pickle.dumps(case)), {"omega": "4 Hz"}
    assert again == case
    assert again.with_values(omega).two_blocks() == case.with_values(omega).two_blocks()
    with pytest.raises(CaseError) as caught:
        load_case("nothing")
    assert pickle.loads(pickle.dumps(caught.value)).problems == caught.value.problems


def test_a_case_does_not_change():
    case = load_case("II-B")
    for target, name in [(case, "text"), (case.model, "name"), (case.model.blocks, "m1")]:
        with pytest.raises((AttributeError, ValueError)):
            setattr(target, name, None)


def test_rates_in_radians_give_cycles_as_a_double_double():
    scene = load_case("I-A", {"omega": "22 rad/s"}).two_blocks()
    with mpmath.workdps(60):
        exact = 22 / (2 * mpmath.pi)
        assert scene.omega == 22.0
        assert scene.cycles == float(exact)
        assert abs(exact - scene.cycles - scene.cycles_lo) < exact * mpmath.mpf(2) ** -105


def test_rates_in_hertz_that_are_no_double_give_the_rest():
    scene = load_case("I-A", {"omega": "3.7 Hz"}).two_blocks()
    assert scene.cycles == 3.7
    assert scene.cycles_lo == float(Fraction("3.7") - Fraction(3.7))


def test_friction_force_is_rounded_once():
    case = load_case("II-B", {"mu": "0.1", "m2": "0.3 kg", "g": "9.81 m/s^2"})
    assert float(Fraction("0.1") * Fraction("0.3") * Fraction("9.81")) == case.two_blocks().N


@pytest.mark.parametrize("omega", ["3.7 Hz", "22.1 rad/s"])
def test_exact_scene_in_mpmath(omega):
    case = load_case("I-A-eq211", {"omega": omega})
    with mpmath.workdps(60):
        exact = case.exact_two_blocks(
            lambda value: mpmath.mpf(value.numerator) / value.denominator, mpmath.pi
        )
        per_second = mpmath.mpf(omega.split()[0]) * (2 * mpmath.pi if "Hz" in omega else 1)
        assert abs(exact.omega - per_second) < mpmath.mpf(10) ** -57
        assert abs(exact.A - mpmath.mpf("0.0033") * per_second**2) < mpmath.mpf(10) ** -57
        if "Hz" in omega:
            assert exact.cycles == Fraction("3.7")
        else:
            assert abs(exact.cycles * 2 * mpmath.pi - 22.1) < 1e-14
    double = case.two_blocks()
    assert (float(exact.omega), float(exact.A), float(exact.N)) == (double.omega, double.A, double.N)
    assert (exact.every_num, exact.every_den, exact.source, exact.k2) == (1, 200, "harmonic", 12400)


def test_exact_scene_without_pi_takes_enough_digits():
    scene = load_case("II-B").exact_two_blocks(Fraction)
    with mpmath.workdps(1050):
        exact = 11 * mpmath.pi
        given_value = mpmath.mpf(scene.Omega0.numerator) / scene.Omega0.denominator
        assert abs(given_value - exact) < mpmath.mpf(10) ** -1000
    assert scene.m1 == Fraction("0.297")


@pytest.mark.parametrize(
    ("code", "modules"),
    [
        ("import vibsim.cases", "numpy scipy matplotlib h5py"),
        ("from vibsim import load_case; load_case('II-B').scene()", "vibsim.cases.part_schema"),
    ],
)
def test_nothing_is_loaded_that_a_case_does_not_need(code, modules):
    code += f"; import sys; print(set(sys.modules) & set('{modules}'.split()))"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "set()"


FINGERPRINTS = {  # of version 0.1.0, as result files hold them
    "I-A-eq211": "ffbca380cd28dafd5fb91df9f7b4cec817287e529969c406b68a9a30c3478818",
    "II-B": "c2fde79c42d85fb8ffe7e0691cb6863a014bb904dfbc0862a9fd211683856022",
}


@pytest.mark.parametrize("name", FINGERPRINTS)
def test_fingerprints_of_stored_files_stay(name):
    assert load_case(name).sha256 == FINGERPRINTS[name]


@pytest.mark.parametrize(
    ("name", "numbers"),
    [
        ("II-B", {"initial.x1": "2 mm", "initial.phi": "30 deg"}),
        ("gallery/impact-oscillator", {"initial.mass.x": "-1 mm"}),
        ("gallery/driven-pendulum", {"initial.pendulum.x": "170 deg", "initial.pendulum.v": "0.5 rad/s"}),
        ("II-B", {"excitation.Omega0": "390 rpm", "coupling.c": 0.01}),
        ("II-B", {"friction.mu": "0", "blocks.m2": "2 kg"}),
        ("I-A-eq211", {"excitation.A.m3": "20 g", "initial.x1": "1 mm"}),
        ("gallery/impact-oscillator", {"stops.wall.gap": "2 mm", "run.t_end": "3 s"}),
        ("gallery/belt-oscillator", {"friction.belt.mu_d": "0.4"}),
    ],
)
def test_other_numbers_make_the_case_that_is_read_with_them(name, numbers):
    whole, quick, one_by_one = load_case(name, numbers), load_case(name).with_values(numbers), load_case(name)
    for key, value in numbers.items():
        one_by_one = one_by_one.with_values({key: value})
    for case in (quick, one_by_one):
        assert list(case.values.items()) == list(whole.values.items())
        assert (case.sha256, case.resolved_json()) == (whole.sha256, whole.resolved_json())
        assert case.scene() == whole.scene() and case.to_yaml() == whole.to_yaml()


@pytest.mark.parametrize(
    ("name", "numbers"),
    [
        ("gallery/impact-oscillator", {"initial.mass.x": "3 kg"}),
        ("gallery/impact-oscillator", {"initial.nobody.x": "1 m"}),
        ("gallery/impact-oscillator", {"stops.wall.gap": "1 kg"}),
        ("gallery/chattering-oscillator", {"initial.mass.x": "1 mm"}),  # inside the wall
        ("gallery/belt-oscillator", {"friction.belt.mu_d": "2"}),  # above mu_s
        ("II-B", {"run.t_end": "1e9 s"}),
        ("II-B", {"excitation.m3": "1e-200 kg", "excitation.e": "1e-200 m"}),
        ("II-B", {"excitation.Omega0": "0 Hz"}),
    ],
)
def test_other_numbers_are_refused_as_where_they_are_read(name, numbers):
    with pytest.raises(CaseError) as quick:
        load_case(name).with_values(numbers)
    with pytest.raises(CaseError) as whole:
        load_case(name, numbers)
    told = [[(problem.key, problem.message) for problem in each.value.problems] for each in (quick, whole)]
    assert told[0] == told[1]


def test_numbers_are_replaced_as_often_as_one_likes():
    case = without = load_case("II-B", {"mu": "0"})
    for mu in ("0.001", "0", "0.001") * 200:
        case = case.with_values({"friction.mu": mu})
    assert case.scene() == without.with_values({"friction.mu": "0.001"}).scene() == load_case("II-B").scene()


# Arguments of Python calls: what is wrong is named with what is allowed, before anything runs.


AXES = {"Omega0": "3:4:1 Hz"}
NO_NUMBER = "must be a whole number, got"


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (lambda: vibsim.sweep("II-B", "Omega0"), "axes must be a dict such as"),
        (lambda: vibsim.sweep("II-B", {3: "3:4:1 Hz"}), "axes must be a dict such as"),
        (lambda: vibsim.sweep("II-B", AXES, section="5"), f"section {NO_NUMBER} '5'"),
        (lambda: vibsim.sweep("II-B", AXES, jobs=1.5), f"jobs {NO_NUMBER} 1.5"),
        (lambda: vibsim.sweep("II-B", AXES, ensemble="2"), f"ensemble {NO_NUMBER} '2'"),
        (lambda: vibsim.sweep("II-B", AXES, ensemble=2, seed=None), f"seed {NO_NUMBER} None"),
        (lambda: vibsim.sweep("II-B", AXES, ensemble=2, spread="x1"), "spread must be a dict such as"),
        (lambda: vibsim.sweep("II-B", AXES, compute=5), "compute must be a text or a list of texts, got 5"),
        (lambda: vibsim.fit("II-B", "J"), "free must be a dict such as"),
        (lambda: vibsim.fit("II-B", {"J": 5}, ["captured"]), "free J: a range is a text such as"),
        (lambda: vibsim.fit("II-B", {}, [5]), "statements must be a text or a list of texts, got 5"),
        (lambda: vibsim.lyapunov("I-C", count=1.5), f"count {NO_NUMBER} 1.5"),
        (lambda: vibsim.analyse("I-C", what=5), "what must be a text or a list of texts, got 5"),
    ],
)
def test_wrong_types(call, message):
    with pytest.raises(TypeError) as caught:
        call()
    assert message in str(caught.value)


def test_numbers_too_small():
    with pytest.raises(ValueError, match="seed must be at least 0, got -1"):
        vibsim.sweep("II-B", AXES, ensemble=2, seed=-1)
    with pytest.raises(ValueError, match="jobs must be at least 1, got 0"):
        vibsim.sweep("II-B", AXES, jobs=0)


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"size": "12x8"}, "size must be (width, height) in cm"),
        ({"size": (12,)}, "size must be (width, height) in cm"),
        ({"width": 5}, "width must be one of column, page, got 5"),
        ({"font_size": "8"}, "font_size must be a number of points"),
    ],
)
def test_measures_of_a_picture(options, message):
    with pytest.raises(PlotError) as caught:
        vibsim.plot("II-B", "stiffness", **options)
    assert message in str(caught.value)


def test_instants_are_numbers():
    run = vibsim.simulate("I-A", overrides={"run.t_end": "0.1 s"})
    with pytest.raises(TypeError, match="times must be numbers"):
        run.at("0.05 s")


def test_all_exponents_by_name():
    changes = {"run.t_end": "4 s"}
    by_name, by_default = (vibsim.lyapunov("I-A", count=count, overrides=changes) for count in ("all", None))
    assert by_name.exponents.tolist() == by_default.exponents.tolist() and len(by_name.exponents) == 3


# Derived facts against numbers known from linear theory and from the published discussion of the cases.


def facts(name, overrides=None):
    return {fact.name: fact.value for fact in derived_facts(load_case(name, overrides).scene())}


def test_case_one():
    found = facts("I-A")
    assert found["block 1 on its spring"] == pytest.approx(4.130, abs=5e-4)
    assert found["free"] == pytest.approx(4.3337, abs=5e-5)
    assert found["in contact"] == pytest.approx(34.397, abs=5e-4)
    assert found["bilinear"] == pytest.approx(7.6975, abs=5e-5)
    assert found["friction band"] == pytest.approx(0.001 * 2.94 * 9.81 / 200, rel=1e-14)
    assert "run-up time constant" not in found


def test_case_two():
    found = facts("II-B")
    assert found["free"] == pytest.approx(4.149, abs=5e-4)
    assert found["bilinear"] == pytest.approx(7.37, abs=5e-3)
    inertia = 0.001 + 0.03 * 0.11**2
    assert found["run-up time constant"] == pytest.approx(11 * pi * inertia / 0.005, rel=1e-14)
    assert found["full force"] == pytest.approx(load_case("I-B-eq211").two_blocks().A, rel=1e-14)


def test_a_wall_without_stop_and_friction():
    off = {"m2": "fixed", "stop": "none", "friction": "none", "excitation": "none", "c": "0.5 N s/m"}
    assert facts("II-B", off) == {
        "block 1 on its spring": pytest.approx(sqrt(200 / 0.297) / (2 * pi), rel=1e-14),
        "damping ratio": pytest.approx(0.25 / sqrt(200 * 0.297), rel=1e-14),
    }


def test_no_coupling_spring():
    found = facts("II-B", {"k1": "0 N/m", "M0": "0 N m"})
    assert found["free"] == found["bilinear"] == 0.0
    assert not {"damping ratio", "friction band", "run-up time constant"} & set(found)


def test_scenes_of_parts():
    """Two masses on springs in a row: w^2 = (3 +- sqrt(5))/2; bilinear: 1 and sqrt(30) rad/s."""
    found = facts("gallery/two-masses-with-friction")
    golden = sqrt((3 + sqrt(5)) / 2)
    assert found["open 1"] == pytest.approx(1 / golden / (2 * pi), rel=1e-12)
    assert found["open 2"] == pytest.approx(golden / (2 * pi), rel=1e-12)
    assert found["floor"] == 0.5
    bilinear = facts("gallery/bilinear-oscillator")
    assert bilinear["closed 1"] == pytest.approx(sqrt(30) / (2 * pi), rel=1e-14)
    assert bilinear["bilinear 1"] == pytest.approx(2 * sqrt(30) / (1 + sqrt(30)) / (2 * pi), rel=1e-14)


def test_a_spring_called_coupling_makes_no_machine_of_the_paper():
    """Three bodies in a row: the first link's name is a name."""
    text = """
    bodies: {a: 1 kg, b: 2 kg, c: 3 kg}
    links: {coupling: {between: [a, b], k: 100 N/m}, other: {between: [b, c], k: 50 N/m}}
    """
    assert {fact.name for fact in derived_facts(load_case_text(text).scene())} == {"open 1", "open 2"}


@pytest.mark.parametrize("name", shipped_case_names())
def test_the_long_form_of_the_papers_machine_is_known_as_such(name):
    case = load_case(name)
    assert derived_facts(load_case_text(case.long_text()).scene()) == derived_facts(case.scene())
    assert "block 1 on its spring" in {fact.name for fact in derived_facts(case.scene())}


def test_friction_of_bodies_that_turn_is_a_torque():
    text = """
bodies: {bit: 374 kg m^2}
friction: {rock: {between: [bit, ground], N: 1 kN m, mu: 1, static: 2.2}}
run: {t_end: 1 s, every: 0.1 s}
"""
    facts = [(fact.value, fact.unit, fact.meaning) for fact in derived_facts(load_case_text(text).scene())]
    assert facts == [(2200, "N m", "limit friction torque"), (1000, "N m", "friction torque while slipping")]


# What a notebook shows of a case.


class Tags(HTMLParser):
    """Open tags of a page, and its text."""

    def __init__(self):
        super().__init__()
        self.open, self.text = [], ""

    def handle_starttag(self, tag, attrs):
        if tag != "br":
            self.open.append(tag)

    def handle_endtag(self, tag):
        assert self.open.pop() == tag

    def handle_data(self, data):
        self.text += data


@pytest.mark.parametrize("name", ("II-B", "gallery/stack-of-blocks"))
def test_a_case_says_what_it_is(name):
    case, page = load_case(name), Tags()
    page.feed(case._repr_html_())
    assert page.open == []
    assert page.text.startswith(repr(case)[1:-1]) and case.title in page.text and case.to_yaml() in page.text
    for fact in derived_facts(case.scene()):
        assert fact.meaning in page.text and f"{number(fact.value, 6)} {fact.unit}".strip() in page.text


def test_what_a_user_wrote_is_no_mark_up():
    html = load_case("II-B", {"title": "k < 3 & <script>"})._repr_html_()
    assert "<script>" not in html and "k &lt; 3 &amp; &lt;script&gt;" in html
