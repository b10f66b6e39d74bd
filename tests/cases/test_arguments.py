"""Arguments of Python calls: what is wrong is named with what is allowed, before anything runs."""

import pytest

import vibsim
from vibsim.plots.subject import PlotError

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
