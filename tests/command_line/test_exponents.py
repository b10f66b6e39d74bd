"""vibsim run --lyapunov: exponents in the summary, in JSON and in the file."""

import json

import h5py
import numpy as np
import pytest

import vibsim
from tests.command_line.made import call
from vibsim.analysis.regime import stored_exponents

pytestmark = pytest.mark.usefixtures("here")


def run(*words, code=0):
    done = call("run", *words, "--no-trust")
    assert done.exit_code == code, done.output
    return done


SHORT = ("--t-end", "40s", "--every", "1s")


def expected(name, count=None, discard=None):
    case = vibsim.load_case(name, {"run.t_end": "40 s", "run.every": "1 s"})
    return vibsim.lyapunov(case, count=count, discard=discard)


def test_the_file_holds_what_the_library_finds():
    run("I-C-eq211", *SHORT, "--lyapunov", "all")
    theirs, ours = stored_exponents(vibsim.open_result("I-C-eq211.h5")), expected("I-C-eq211")
    for name in ("exponents", "half_widths", "times", "running", "finite_time"):
        np.testing.assert_array_equal(getattr(theirs, name), getattr(ours, name))
    assert (theirs.span, theirs.rank_losses, theirs.warnings) == (ours.span, ours.rank_losses, ours.warnings)
    assert theirs.volume_residual == ours.volume_residual
    with h5py.File("I-C-eq211.h5") as file:
        assert file.attrs["lyapunov_growth"].shape == (101, 4)


def test_the_summary_has_the_exponents_and_info_too():
    text = run("I-A", *SHORT, "--lyapunov", "all", "--discard", "10s").stdout
    found = expected("I-A", discard=10.0)
    assert f"exponents       {found.exponents[0]:.3g} +- {found.half_widths[0]:.2g}, " in text
    assert f", -inf 1/s\n{' ' * 18}from 10 to 40 s, {found.rank_losses} rank losses by sticking" in text
    assert "rank losses by sticking" in call("info", "I-A.h5").stdout


def test_json_has_no_infinity():
    line = run("I-A", *SHORT, "--lyapunov", "all", "--json").stdout
    attrs = json.loads(line, parse_constant=pytest.fail)
    found = expected("I-A")
    assert attrs["lyapunov_exponents"] == [*found.exponents[:2], None]
    assert attrs["lyapunov_half_widths"] == [*found.half_widths[:2], None]
    assert attrs["lyapunov_warnings"] == [] and attrs["lyapunov_rank_losses"] == found.rank_losses
    assert "lyapunov_growth" not in attrs


def test_each_case_has_as_many_as_it_has():
    run("I-A", "II-A", *SHORT, "--lyapunov", "all")
    counts = [len(vibsim.open_result(f"{name}.h5").attrs["lyapunov_exponents"]) for name in ("I-A", "II-A")]
    assert counts == [3, 5]


def test_without_the_option_nothing_is_stored():
    text = run("I-A", *SHORT).stdout
    assert "exponents" not in text
    result = vibsim.open_result("I-A.h5")
    assert stored_exponents(result) is None
    assert not any(name.startswith("lyapunov") for name in result.attrs)


def test_the_run_is_the_same_with_and_without():
    run("II-A", *SHORT, "-o", "plain.h5")
    run("II-A", *SHORT, "-o", "carried.h5", "--lyapunov", "1")
    plain, carried = (vibsim.open_result(f"{name}.h5") for name in ("plain", "carried"))
    for name in plain:
        np.testing.assert_array_equal(plain[name], carried[name])


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (("--lyapunov", "4"), "--lyapunov 4: I-A has 3 exponents"),
        (("--lyapunov", "0"), "must be a whole number above 0, or all, got '0'"),
        (("--lyapunov", "some"), "must be a whole number above 0, or all, got 'some'"),
        (("--discard", "5s"), "--discard leaves a transient out of --lyapunov, which is not given"),
        (("--lyapunov", "1", "--discard", "40s"), "--discard 40 s: leaves nothing of I-A, 40 s"),
        (("--lyapunov", "1", "--discard", "1.5"), "must be at least 0 and below 1"),
        (("--lyapunov", "1", "--digits", "30"), "--lyapunov needs doubles; leave --digits out"),
    ],
)
def test_what_cannot_be(words, message):
    done = run("I-A", *SHORT, *words, code=2)
    assert message in done.stderr
