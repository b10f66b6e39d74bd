"""Which compiler builds the engine: what answers, else the one of the package index."""

import json
import subprocess
import sys
import sysconfig
from importlib.util import find_spec
from types import SimpleNamespace

import pytest

from tests.docs.pages import ROOT

pytest.importorskip("setuptools")  # of which the backend is made; pip brings it for the build


@pytest.fixture
def backend(monkeypatch):
    monkeypatch.syspath_prepend(ROOT)
    monkeypatch.delenv("VIBSIM_BUILD", raising=False)
    import build_backend

    return build_backend


@pytest.mark.parametrize("wanted", ("get_requires_for_build_wheel", "get_requires_for_build_editable"))
def test_a_compiler_is_asked_for_where_none_answers(backend, monkeypatch, wanted):
    monkeypatch.setattr(backend.build_meta, wanted, lambda settings: ["another"])
    monkeypatch.setattr(backend, "target", lambda: "x86_64-linux-gnu.2.17")
    for answers, more in ((True, []), (False, [backend.COMPILER_PACKAGE])):
        monkeypatch.setattr(backend, "compiler_answers", lambda answers=answers: answers)
        assert getattr(backend, wanted)() == ["another", *more]
    monkeypatch.setattr(backend, "WINDOWS", True)  # whose own compiler makes the engine on doubles alone
    monkeypatch.setattr(backend, "compiler_answers", lambda: True)
    assert getattr(backend, wanted)() == ["another", backend.COMPILER_PACKAGE]


def test_none_is_asked_for_where_the_package_has_none(backend, monkeypatch):
    monkeypatch.setattr(backend, "compiler_answers", lambda: False)
    monkeypatch.setattr(sysconfig, "get_platform", lambda: "freebsd-14.1-RELEASE-amd64")
    assert backend.target() is None
    assert backend.missing_compiler() == []
    assert backend.zig() is None


def test_a_compiler_that_fails_does_not_answer(backend, monkeypatch):
    for program in ("false", "a-compiler-that-there-is-not"):
        monkeypatch.setenv("CC", program)
        assert not backend.compiler_answers()


@pytest.mark.parametrize(
    ("platform", "triplet", "target"),
    [
        ("linux-x86_64", "x86_64-pc-linux-gnu", "x86_64-linux-gnu.2.17"),
        ("linux-aarch64", "aarch64-unknown-linux-gnu", "aarch64-linux-gnu.2.17"),
        ("linux-riscv64", "riscv64-unknown-linux-gnu", "riscv64-linux-gnu.2.27"),
        ("linux-x86_64", "x86_64-alpine-linux-musl", "x86_64-linux-musl"),
        ("win-amd64", None, "x86_64-windows-gnu"),
    ],
)
def test_the_target_is_the_oldest_of_its_kind(backend, monkeypatch, platform, triplet, target):
    """Not this processor and this C library: the engine may be used beside them."""
    monkeypatch.setattr(sysconfig, "get_platform", lambda: platform)
    monkeypatch.setattr(sysconfig, "get_config_var", {"HOST_GNU_TYPE": triplet}.get)
    assert backend.target() == target


def test_the_engine_is_compiled_with_the_rounding_of_setup_py(backend, monkeypatch, tmp_path):
    monkeypatch.setattr(backend, "target", lambda: "x86_64-linux-gnu.2.17")
    record = "import json, os, sys; json.dump([sys.argv[1:], dict(os.environ)], open('called.json', 'w'))"
    extension = SimpleNamespace(
        extra_compile_args=["-O3", "-ffp-contract=off"], define_macros=[("LIMBS", "2")],
        include_dirs=["here"], sources=["a.c", "b.cpp"],
    )  # fmt: skip
    monkeypatch.chdir(tmp_path)
    backend.build_with_zig([sys.executable, "-c", record], extension, "out/module.so", "cache")
    words, environment = json.loads((tmp_path / "called.json").read_text())
    assert {"-ffp-contract=off", "-mcpu=baseline", "-DLIMBS=2", "-Ihere", "a.c", "b.cpp"} <= set(words)
    assert words[-2:] == ["-o", "out/module.so"]
    assert environment["ZIG_GLOBAL_CACHE_DIR"] == str(tmp_path / "cache")
    with pytest.raises(backend.CompileError, match=r"did not make out/module\.so"):
        backend.build_with_zig(
            [sys.executable, "-c", "raise SystemExit(1)"], extension, "out/module.so", "cache"
        )


@pytest.mark.skipif(find_spec("ziglang") is not None, reason="the compiler of the package is installed here")
def test_setup_says_what_to_do_where_there_is_no_compiler(tmp_path, monkeypatch):
    for name, value in {"CC": "false", "CXX": "false", "VIBSIM_BUILD": "strict"}.items():
        monkeypatch.setenv(name, value)
    words = [sys.executable, "setup.py", "-q", "build_ext", "--build-lib", str(tmp_path)]
    done = subprocess.run(words, cwd=ROOT, capture_output=True, text=True, check=False)
    assert done.returncode == 1
    assert "python -m pip install ziglang" in done.stderr
