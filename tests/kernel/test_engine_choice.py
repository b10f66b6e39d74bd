"""Which engine runs, and what is said where the C engine was not built."""

import os
import shutil
import subprocess
import sys
from dataclasses import replace
from pathlib import Path

import pytest

import vibsim.engine.choice
from tests.scenes import fixed_block, paper
from tests.trajectories import opened
from vibsim.engine.choice import engine_name, flow_of
from vibsim.engine.errors import EngineError

ROOT = Path(__file__).parents[2]


@pytest.fixture
def without_c(monkeypatch):
    """An installation that found no compiler."""
    monkeypatch.setattr(vibsim.engine.choice, "compiled", lambda: False)
    monkeypatch.setattr(vibsim.engine.choice, "_noticed", False)


def test_auto_takes_the_c_engine():
    assert engine_name("auto") == "c"
    assert opened(paper("I-A")).engine == "c"
    assert engine_name("python") == "python"
    assert opened(paper("I-A"), "python").engine == "python"


def test_auto_falls_back_with_one_notice(without_c, capsys):
    assert engine_name("auto") == "python"
    first = capsys.readouterr()
    assert first.out == ""
    assert "no C engine" in first.err
    assert "slower" in first.err
    assert first.err.count("\n") == 1
    assert opened(paper("I-A")).engine == "python"
    assert capsys.readouterr().err == ""


def test_asking_for_python_is_no_occasion_for_a_notice(without_c, capsys):
    assert engine_name("python") == "python"
    assert capsys.readouterr().err == ""


def test_asking_for_c_where_it_was_not_built(without_c):
    with pytest.raises(RuntimeError, match="C engine was not built"):
        engine_name("c")


def test_unknown_engine():
    with pytest.raises(ValueError, match="auto, c, python, got 'fortran'"):
        engine_name("fortran")


def test_the_c_engine_is_there_before_any_thread_can_ask_for_it(monkeypatch):
    """A module of C stands among the modules before its specification does: who looked it up then failed."""
    monkeypatch.setattr(sys.modules["vibsim.engine._engine"], "__spec__", None)
    assert engine_name("auto") == "c"
    program = "import sys, vibsim.engine.choice; print(sys.modules['vibsim.engine._engine'].__spec__.name)"
    done = subprocess.run([sys.executable, "-c", program], check=True, capture_output=True, text=True)
    assert done.stdout == "vibsim.engine._engine\n"


def test_methods():
    assert flow_of(paper("I-A").as_parts()) == "closed_form"
    assert flow_of(paper("II-A").as_parts()) == "taylor"
    assert flow_of(paper("I-A", method="taylor").as_parts()) == "taylor"
    with pytest.raises(ValueError, match=r"closed_form .* motor"):
        flow_of(paper("II-A", method="closed_form").as_parts())
    with pytest.raises(ValueError, match="got 'euler'"):
        flow_of(paper("I-A", method="euler").as_parts())


@pytest.mark.parametrize("engine", ("c", "python"))
def test_a_failing_run_says_what_when_where_and_what_to_do(engine):
    wild = fixed_block(x1=1e308, v1=1e308, G=None, t_end=1.0)
    with pytest.raises(EngineError) as failure:
        list(opened(wild, engine).blocks())
    message = str(failure.value)
    assert message.startswith("t = 0.0 s: the state is no longer finite")
    assert "x = 1e+308 m" in message
    assert message.endswith("check the parameters for values far outside each other's scale")
    assert "\n" not in message


@pytest.mark.slow
@pytest.mark.timeout(600)
def test_without_a_compiler_the_package_builds_and_runs(tmp_path):
    """A package built with a compiler that fails has no C engine and runs the same on Python."""
    source, installed = tmp_path / "source", tmp_path / "installed"
    leave = shutil.ignore_patterns(".git", ".venv", "build", "*.so", "*.egg-info", "__pycache__", ".*_cache")
    shutil.copytree(ROOT, source, ignore=leave)
    build = [sys.executable, "setup.py", "-q", "build", "--build-lib", str(installed)]
    done = subprocess.run(
        build, cwd=source, env={**os.environ, "CC": "/bin/false"}, capture_output=True, text=True
    )
    assert done.returncode == 0, done.stderr
    assert not [path for path in installed.rglob("_engine.*") if path.suffix in (".so", ".pyd")]
    program = (
        # an editable install looks for the engine beside its sources, whichever package asks
        "import sys; sys.meta_path = [one for one in sys.meta_path if 'Editable' not in repr(one)]\n"
        f"sys.path[:0] = [{str(installed)!r}, {str(ROOT)!r}]\n"
        "import vibsim.engine.choice as k\n"
        "from tests.scenes import paper; from tests.trajectories import run\n"
        "print(k.__file__, k.engine_name(), run(paper('I-A', t_end=1.0), 'auto').final('x1').hex())"
    )
    done = subprocess.run(
        [sys.executable, "-c", program], check=True, capture_output=True, text=True, cwd=tmp_path
    )
    where, engine, x1 = done.stdout.split()
    assert Path(where).is_relative_to(installed)
    assert engine == "python"
    assert "no C engine" in done.stderr
    trajectory = opened(replace(paper("I-A"), t_end=1.0), "c")
    assert float.fromhex(x1) == list(trajectory.blocks())[-1].events["x1"][-1]
