"""Every public name has an example in its docstring, and all examples print what they show."""

import doctest
import sys
from importlib import import_module
from pathlib import Path

import pytest

import vibsim

PACKAGE = Path(vibsim.__file__).parent
NAMES = [name for name in vibsim.__all__ if not name.startswith("__")]
WITH_EXAMPLES = [path for path in sorted(PACKAGE.rglob("*.py")) if " >>> " in path.read_text("utf-8")]
MODULES = [".".join(path.relative_to(PACKAGE.parent).with_suffix("").parts) for path in WITH_EXAMPLES]


@pytest.mark.parametrize("name", NAMES)
def test_every_public_name_has_an_example(name):
    """Of a class those of its methods count too; their modules are among those whose examples run."""
    of = getattr(vibsim, name)
    assert any(test.examples for test in doctest.DocTestFinder().find(of, name, globs={}))
    assert of.__module__ in MODULES


@pytest.mark.parametrize("name", MODULES)
def test_the_examples_run(name, here, monkeypatch):
    monkeypatch.setenv("MPLBACKEND", "agg")
    done = doctest.testmod(import_module(name), optionflags=doctest.NORMALIZE_WHITESPACE | doctest.ELLIPSIS)
    assert done.attempted > 0 and done.failed == 0
    if "matplotlib.pyplot" in sys.modules:
        sys.modules["matplotlib.pyplot"].close("all")
