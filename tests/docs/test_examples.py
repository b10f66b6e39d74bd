"""Every public name has an example in its docstring, and all of them print what they show."""

import doctest
import sys

import pytest

import vibsim

NAMES = [name for name in vibsim.__all__ if not name.startswith("__")]
FLAGS = doctest.NORMALIZE_WHITESPACE | doctest.ELLIPSIS


def examples(name):
    """The examples of a public name: of a class those of its methods too."""
    tests = doctest.DocTestFinder(exclude_empty=True).find(getattr(vibsim, name), name, globs={})
    return [test for test in tests if test.examples]


@pytest.mark.parametrize("name", NAMES)
def test_the_examples_run(name, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("MPLBACKEND", "agg")
    assert examples(name), f"vibsim.{name} has no example"
    for test in examples(name):
        assert doctest.DocTestRunner(optionflags=FLAGS).run(test).failed == 0
    if "matplotlib.pyplot" in sys.modules:
        sys.modules["matplotlib.pyplot"].close("all")
