"""The calls of `import vibsim`: what each accepts, and what it says of anything else."""

import importlib
import inspect
import json
import pickle
import pkgutil
from dataclasses import replace
from itertools import combinations

import numpy as np
import pytest

import vibsim
from vibsim.analysis import CaptureVerdict, DriftVerdict, RegimeVerdict
from vibsim.cases import RangeError
from vibsim.cases.case import load_case_text
from vibsim.cases.formula_text import FormulaError
from vibsim.cases.formula_values import UnitError
from vibsim.cases.problems import Problem
from vibsim.engine.errors import State
from vibsim.engine.truth import open_truth
from vibsim.orbits.coordinates import NotConverged
from vibsim.physics.precision import number_kit
from vibsim.plots.subject import PlotError

SHORT = {"run.t_end": "2 s"}


@pytest.fixture(scope="module")
def saved(tmp_path_factory):
    path = tmp_path_factory.mktemp("calls") / "short.h5"
    vibsim.simulate(vibsim.load_case("II-B", SHORT)).save(path)
    return path


def test_a_case_may_be_given_by_its_name_or_file(tmp_path):
    path = tmp_path / "short.yaml"
    path.write_text("extends: II-B\nrun: {t_end: 2 s}\n", encoding="utf-8")
    by_case, by_path, by_text = (vibsim.simulate(case) for case in (vibsim.load_case(path), path, str(path)))
    assert by_case["x1"].tobytes() == by_path["x1"].tobytes() == by_text["x1"].tobytes()
    assert vibsim.lyapunov(path, count=1).exponents.shape == (1,)
    assert vibsim.analyse(path, what=["impacts"]).impacts is not None


def test_a_run_may_be_given_by_its_file(saved):
    by_result = vibsim.analyse(vibsim.open_result(saved), what=["frequencies"])
    assert vibsim.analyse(saved, what=["frequencies"]) == by_result
    assert vibsim.analyse(str(saved), what=["frequencies"]) == by_result
    with pytest.raises(vibsim.ResultFileError, match="No such file"):
        vibsim.analyse("none.h5")


@pytest.mark.parametrize("number", (0.002, np.float64(0.002), np.array(0.002), np.float32(0.002), "0.002"))
def test_values_may_be_numbers_of_numpy(number):
    assert vibsim.load_case("II-B", {"mu": number}) == vibsim.load_case("II-B", {"mu": "0.002"})


@pytest.mark.parametrize("wrong", (["mu=0.002"], "mu=0.002", {5: "0.002"}))
def test_overrides_are_a_mapping(wrong):
    with pytest.raises(TypeError, match="overrides must be a mapping such as"):
        vibsim.load_case("II-B", wrong)
    with pytest.raises(TypeError, match=r"overrides must be a (dict|mapping) such as"):
        vibsim.simulate("II-B", wrong)


@pytest.mark.parametrize("wrong", ("many", 30.5))
def test_digits_are_a_whole_number(wrong):
    with pytest.raises(ValueError, match="digits must be a whole number or 'auto', got"):
        vibsim.simulate("I-A", digits=wrong)


def test_one_verdict_may_be_named_alone(saved):
    assert vibsim.analyse(saved, what="frequencies") == vibsim.analyse(saved, what=["frequencies"])


@pytest.mark.parametrize("wrong", [3, None, ["II-B"], b"II-B"])
def test_anything_else_is_named(wrong):
    with pytest.raises(TypeError, match="a case must be a Case, the path of a case file, the name of a"):
        vibsim.load_case(wrong)
    for call in (vibsim.simulate, vibsim.analyse, vibsim.lyapunov, vibsim.sweep):
        with pytest.raises(TypeError, match="a case must be a Case, the path of a case file, the name of a"):
            call(wrong)
    with pytest.raises(vibsim.CaseError, match="is no shipped case"):
        vibsim.simulate("nosuch")


HAMMER = {
    "bodies": {"hammer": 2},
    "links": {"spring": {"between": ("hammer", "ground"), "k": "8 kN/m", "c": np.float64(4.0)}},
    "stops": {
        "anvil": {
            "between": ["hammer", "ground"],
            "law": "rigid",
            "gap": "1 mm",
            "acts": "compression",
            "e": 0.6,
        }
    },
    "forces": {"drive": {"on": "hammer", "A": "40 N", "omega": "12 Hz"}},
    "run": {"t_end": "2 s", "every": "1 ms"},
}


def test_a_case_may_be_a_dict_or_yaml_text(tmp_path):
    """All four of what a file, its text and a dict say are one case, to every call."""
    case = vibsim.load_case(HAMMER)
    text = case.to_yaml()
    path = tmp_path / "case.yaml"
    path.write_text(text, encoding="utf-8")
    assert case.sha256 == vibsim.load_case(text).sha256 == vibsim.load_case(path).sha256
    runs = [vibsim.simulate(source)["x_hammer"].tobytes() for source in (HAMMER, text, path)]
    assert len(set(runs)) == 1
    orbits = [vibsim.orbit(source, {"run.t_end": "10 s"}).state for source in (HAMMER, text)]
    assert orbits[0] == orbits[1]
    verdicts = [vibsim.analyse(source, what="impacts").impacts for source in (HAMMER, path)]
    assert verdicts[0] == verdicts[1]
    axes = (HAMMER, [0.5, 0.6]), (text, "0.5,0.6")
    swept = [vibsim.sweep(of, {"stops.anvil.e": axis}, jobs=1, section=0) for of, axis in axes]
    assert swept[0]["impacts"].tolist() == swept[1]["impacts"].tolist()
    exponents = [vibsim.lyapunov(of, SHORT, count=1).exponents for of in ("{extends: I-A}", "I-A")]
    assert exponents[0] == exponents[1]


def test_problems_of_a_dict_have_keys_and_no_lines():
    with pytest.raises(vibsim.CaseError) as caught:
        vibsim.load_case({**HAMMER, "bodies": {"hammer": "2 m"}, "stopps": {}})
    assert [(each.key, each.line) for each in caught.value.problems] == [
        ("bodies.hammer", None),
        ("stopps", None),
    ]


def test_the_second_argument_is_by_key_of_the_case(saved):
    """Values where a case is run, ranges where one is followed or swept; everything else goes by name."""
    changed = {"run.t_end": "1 s"}
    assert (
        vibsim.analyse("II-B", changed, what="frequencies").frequencies
        == vibsim.analyse(vibsim.load_case("II-B", changed), what="frequencies").frequencies
    )
    for call, wrong in (
        (vibsim.lyapunov, 2),
        (vibsim.analyse, (1, 2)),
        (vibsim.search_orbits, 3),
        (vibsim.simulate, 2),
    ):
        named = {"count": 1} if call is vibsim.search_orbits else {}
        with pytest.raises(TypeError, match="overrides must be a dict such as"):
            call("I-A", wrong, **named)
    with pytest.raises(TypeError, match="overrides change a case before it is run"):
        vibsim.analyse(saved, changed)
    branch = vibsim.continue_branch("gallery/friction-oscillator", {"drive.A": "1.4:1.6 N"}, max_points=4)
    old = vibsim.continue_branch("gallery/friction-oscillator", "drive.A", "1.4:1.6 N", max_points=4)
    assert branch["period"].tobytes() == old["period"].tobytes()
    with pytest.raises(vibsim.BranchError, match="one key varies along a curve"):
        vibsim.continue_branch("I-C", {"omega": "4:7 Hz", "c": "0:1"})


def test_a_bare_frequency_is_refused_everywhere():
    """Hz or rad/s: nobody can guess which."""
    with pytest.raises(vibsim.CaseError, match="omega: needs a unit"):
        vibsim.load_case("I-C", {"omega": 6})
    with pytest.raises(vibsim.CaseError, match="omega: needs a unit"):
        vibsim.sweep("I-C", {"omega": "4:7:1"})
    with pytest.raises(
        vibsim.BranchError, match=r"omega: frequencies need a unit, such as 3:9 Hz, got 4\.0:7\.0"
    ):
        vibsim.continue_branch("I-C", {"omega": (4, 7)})


def test_the_time_of_events_has_both_names(saved):
    events = vibsim.open_result(saved).events
    assert events["time"].tobytes() == events["t"].tobytes()
    assert events.column("time")[0] == 0 and "time" in events


@pytest.mark.parametrize(
    "values", [[0.01, 0.02], (0.01, "0.02 N s/m"), np.array([0.01, 0.02]), "0.01,0.02", ["0.01", "0.02"]]
)
def test_values_of_an_axis_may_be_listed(values):
    case = vibsim.load_case("II-B", SHORT)
    assert vibsim.sweep(case, {"c": values}, section=0, jobs=1)["c"].tolist() == [0.01, 0.02]


@pytest.mark.parametrize(
    ("values", "told"), [(3, "a range such as"), ([None], "a number, or a text"), ([True], "bool|number")]
)
def test_what_no_axis_takes_is_named(values, told):
    with pytest.raises((RangeError, ValueError), match=f"c: .*{told}"):
        vibsim.sweep("II-B", {"c": values})


@pytest.mark.parametrize("values", [[5, 5.5, 6], np.linspace(5, 6, 3), np.array([5, 5.5, 6], "f4")])
@pytest.mark.parametrize(("unit", "shown"), [("Hz", "Hz"), ("rad/s", "rad/s"), ("rev/min", "rpm")])
def test_values_of_an_axis_may_have_a_unit_of_their_own(values, unit, shown):
    made = vibsim.sweep("II-B", {"Omega0": (values, unit)}, section=0, jobs=1, overrides=SHORT)
    assert made["omega0"].tolist() == [5.0, 5.5, 6.0] and made.axes[0].unit == shown
    listed = vibsim.sweep("II-B", {"Omega0": f"5:6:0.5 {unit}"}, section=0, jobs=1, overrides=SHORT)
    assert made["mean_speed"].tobytes() == listed["mean_speed"].tobytes()


def test_units_of_an_axis_are_checked():
    with pytest.raises(RangeError, match="Omega0: unknown unit 'herz'"):
        vibsim.sweep("II-B", {"Omega0": ([5, 6], "herz")})
    with pytest.raises(vibsim.CaseError, match="N s/m"):
        vibsim.sweep("II-B", {"c": ([5, 6], "Hz")})


def test_values_may_be_changed_in_every_call():
    changed = vibsim.load_case("II-B", SHORT)
    for case in ("II-B", vibsim.load_case("II-B")):
        assert vibsim.simulate(case, overrides=SHORT).case.sha256 == changed.sha256
        assert vibsim.simulate(case, SHORT).case.sha256 == changed.sha256
        assert vibsim.load_case(case, SHORT).sha256 == changed.sha256
    one = vibsim.lyapunov("II-B", count=1, overrides=SHORT).exponents
    assert one.tobytes() == vibsim.lyapunov(changed, count=1).exponents.tobytes()


def test_verdicts_are_members_and_texts(saved):
    found = vibsim.analyse(saved, exponent=False)
    for verdict, kind in (
        (found.capture.verdict, CaptureVerdict),
        (found.drift.verdict, DriftVerdict),
        (found.regime.verdict, RegimeVerdict),
    ):
        assert isinstance(verdict, kind) and verdict == verdict.value == str(verdict) == f"{verdict}"
        assert json.loads(json.dumps([verdict])) == [verdict]
        assert pickle.loads(pickle.dumps(verdict)) is verdict
        assert {verdict.value: 1}[verdict] == 1
    with pytest.raises(ValueError, match="'caught' is not a valid CaptureVerdict"):
        replace(found.capture, verdict="caught")


def test_verdicts_are_words():
    case = vibsim.load_case("II-B", SHORT)
    made = vibsim.sweep(case, {"Omega0": "5,6 Hz"}, compute=["capture"], section=0, jobs=1)
    flags = made.column("capture").flags
    words = made.verdict("capture")
    assert words.shape == made["capture"].shape
    assert [flags[word] for word in words.ravel()] == made["capture"].ravel().tolist()
    with pytest.raises(KeyError, match="mean_speed is no verdict of this sweep; its verdicts are capture"):
        made.verdict("mean_speed")


def test_dir_shows_what_is_public_and_nothing_else():
    vibsim.load_case  # noqa: B018
    assert dir(vibsim) == sorted(vibsim.__all__)


def test_all_that_take_a_case_take_overrides():
    """As `load_case` does, by the same word."""
    changed, overrides = vibsim.load_case("I-A", {"mu": 0.002}), {"mu": 0.002}
    assert vibsim.orbit("I-A", overrides=overrides).state == vibsim.orbit(changed).state
    by_overrides = vibsim.search_orbits("I-A", count=1, seed=1, overrides=overrides)
    assert [one.state for one in by_overrides] == [
        one.state for one in vibsim.search_orbits(changed, count=1, seed=1)
    ]
    matrix = vibsim.monodromy("I-A", state={"v1": 0.1}, T=1.0, overrides=overrides).matrix
    assert np.array_equal(matrix, vibsim.monodromy(changed, state={"v1": 0.1}, T=1.0).matrix)


def test_an_orbit_can_be_saved(tmp_path):
    orbit = vibsim.orbit("gallery/friction-oscillator")
    path = orbit.save(tmp_path / "orbit.h5")
    assert vibsim.orbit(path).multipliers.tolist() == orbit.multipliers.tolist()
    with pytest.raises(vibsim.ResultFileError, match="exists"):
        orbit.save(path)
    assert orbit.save(path, force=True) == path


def _follow(path):
    orbit = vibsim.orbit(vibsim.load_case("gallery/impact-oscillator-coco"))
    vibsim.continue_branch(orbit, "forces.drive.omega", "1:1.001 rad/s", out=path)


SAVED = {
    "run": lambda path: vibsim.simulate("II-B", trust=False, overrides=SHORT).save(path),
    "sweep": lambda path: vibsim.sweep("II-B", {"c": [0.01, 0.02]}, section=0, jobs=1, out=path),
    "orbit": lambda path: vibsim.orbit(vibsim.load_case("gallery/impact-oscillator-coco")).save(path),
    "branch": _follow,
    "fit": lambda path: vibsim.fit("II-B", {"c": "0.01:0.02"}, ["captured"], out=path),
}


@pytest.mark.parametrize("name", ["x.txt", "x", "x.csv", "x.yaml"])
@pytest.mark.parametrize("write", SAVED.values(), ids=SAVED)
def test_a_result_is_called_what_it_is(write, name, tmp_path, monkeypatch):
    """As of `-o`: an HDF5 file under another suffix is opened by nothing, vibsim's commands included."""
    monkeypatch.chdir(tmp_path)
    with pytest.raises(
        vibsim.ResultFileError, match=rf"(^|/){name}: .* results are HDF5 files, .h5 or .hdf5"
    ):
        write(name)
    assert not list(tmp_path.iterdir())


def test_a_column_or_a_table_that_there_is_not_is_named(saved):
    result = vibsim.open_result(saved)
    for table, call in ((result, "trajectory has time, x1"), (result.events, "events have t, kind")):
        for ask in (table.__getitem__, table.column):
            with pytest.raises(KeyError, match=f"no column x9; th(is|ese) {call}"):
                ask("x9")
    with pytest.raises(ValueError, match=r"there are: none; .* result.events.to_dataframe\(\)"):
        result.to_dataframe("events")
    assert len(result.events.to_dataframe()) == len(result.events["t"])
    for wrong in (3, ["phase", "relative"]):
        with pytest.raises(PlotError, match="kind must be a name such as 'relative', got "):
            result.plot(kind=wrong)


def test_an_orbit_without_a_turn_of_a_gap_has_no_margin_of_it():
    orbit = vibsim.orbit("gallery/impact-oscillator")
    assert orbit.margin == np.inf and "inf" not in repr(orbit)
    assert "margin          no turn of a gap" in repr(orbit)


# Exceptions come through pickle, as from a process of a pool: one that does not makes the pool wait.


STATE = State(t=0.5, x=[1.0], v=[2.0], phase=0.0, turns=0.0, w=0.25)
RAISED = {  # all others are made of a message
    "EngineError": vibsim.EngineError("crushed", STATE, "left, right"),
    "CaseError": vibsim.CaseError([Problem("file.yaml", 1, 2, "c", "must be positive")]),
    "FormulaError": FormulaError("no name q", 3, 4),
    "UnitError": UnitError("metres and seconds", 3, 4),
    "NotConverged": NotConverged("no orbit is near", 0.25),
}


def exceptions_of_vibsim():
    """Every class of exceptions, private ones too."""
    for module in pkgutil.walk_packages(vibsim.__path__, "vibsim."):
        if module.name != "vibsim.__main__":
            try:
                names = vars(importlib.import_module(module.name))
            except ModuleNotFoundError as error:  # a peer that there is not for every machine
                assert error.name == "heyoka"
                continue
            for each in filter(inspect.isclass, names.values()):
                if issubclass(each, BaseException) and each.__module__ == module.name:
                    yield each


def test_every_exception_comes_through_pickle():
    every = {each.__name__: each for each in exceptions_of_vibsim()}
    assert len(every) > 40 and RAISED.keys() < every.keys()
    for name, each in every.items():
        raised = RAISED.get(name) or each("what it says")
        came = pickle.loads(pickle.dumps(raised))
        assert type(came) is each and str(came) == str(raised) and came.args == raised.args
        assert vars(came).keys() == vars(raised).keys()
        values = {key: value for key, value in vars(came).items() if key != "problems"}
        assert values.items() <= vars(raised).items()


def test_an_error_of_many_digits_comes_through_pickle():
    """Its message is the same as that of doubles, and its state comes as doubles."""
    kit = number_kit(40)
    in_words = {key: kit.number(value) for key, value in vars(STATE).items() if key not in ("x", "v")}
    state = State(x=[kit.number(1.0)], v=[kit.number(2.0)], **in_words)
    raised = vibsim.EngineError("crushed", state, "left, right")
    came = pickle.loads(pickle.dumps(raised))
    assert str(came) == str(raised) == str(RAISED["EngineError"])
    assert (came.reason, came.state, came.parts) == ("crushed", STATE, "left, right")


PAIRS = list(combinations("abcdefghijklmn", 2))
FAILING = {
    "domain": """
bodies: {a: 1 kg}
links: {s: {between: [a, ground], force: "k*d*sqrt(t1 - t)", k: 1 N/m/s^(1/2), t1: 1 s}}
initial: {a: {x: 1 m}}
run: {t_end: 2 s}
""",
    "entangled": f"""
bodies: {{{", ".join(f"{one}: 1 kg" for one in "abcdefghijklmn")}}}
friction: {{{", ".join(f"{P}{Q}: {{between: [{P}, {Q}], N: 1 N, mu: 1}}" for P, Q in PAIRS)}}}
run: {{t_end: 2 s}}
""",
}


@pytest.mark.parametrize("reason", FAILING)
def test_a_run_of_many_digits_fails_in_doubles(reason):
    """On its way, and where its start is decided."""
    with pytest.raises(vibsim.EngineError) as failed:
        list(open_truth(load_case_text(FAILING[reason]).exact_scene, 40).blocks())
    state = failed.value.state
    assert failed.value.reason == reason
    assert type(state.t) is type(state.x[0]) is type(state.w) is float


@pytest.mark.parametrize("name", [name for name in vibsim.__all__ if name.endswith("Error")])
def test_each_at_the_front_says_how_it_is_met(name):
    assert ">>>" in getattr(vibsim, name).__doc__
