"""What builds and checks vibsim elsewhere: packages, workflows, versions."""

import json
import re
import subprocess
import sys
import sysconfig
from importlib.util import find_spec
from types import SimpleNamespace

import pytest
import yaml

from tests.docs.pages import ROOT

WORKFLOWS = sorted((ROOT / ".github" / "workflows").glob("*.yml"))
TARGETS = set(re.findall(r"^([a-z-]+):", (ROOT / "Makefile").read_text(encoding="utf-8"), flags=re.MULTILINE))
PROJECT = (ROOT / "pyproject.toml").read_text(encoding="utf-8")
OTHER_STEPS = {"choco install make --no-progress"}  # what a runner lacks


def jobs():
    for path in WORKFLOWS:
        content = yaml.safe_load(path.read_text(encoding="utf-8"))
        for name, job in content["jobs"].items():
            yield pytest.param(job, id=f"{path.stem}-{name}")


@pytest.mark.parametrize("job", [*jobs()])
def test_a_job_calls_targets_that_run_here_too(job):
    lines = [step["run"] for step in job["steps"] if "run" in step]
    calls = [line.split() for line in lines if line not in OTHER_STEPS]
    assert calls
    for program, *words in calls:
        assert program == "make" and {word for word in words if "=" not in word} <= TARGETS
    assert job["timeout-minutes"] <= 90


def test_long_targets_run_every_week():
    """README's examples, the known cases, the paper and the benchmark: what no pull request runs."""
    # YAML reads the key `on` as true
    weekly = [yaml.safe_load(path.read_text(encoding="utf-8")) for path in WORKFLOWS]
    scheduled = [content for content in weekly if "schedule" in (content[True] or {})]
    crons = [rule["cron"].split() for content in scheduled for rule in content[True]["schedule"]]
    assert all(len(fields) == 5 and fields[2] == "*" for fields in crons)
    steps = [step for content in scheduled for job in content["jobs"].values() for step in job["steps"]]
    called = {word for step in steps for word in step.get("run", "").split()}
    assert {"run", "sweep", "verify", "paper", "bench"} <= called


def test_actions_run_on_what_the_runners_have():
    """Node 20 is gone from GitHub's runners since September 2026: these are the first majors on Node 24."""
    first = {"actions/checkout": 5, "actions/setup-python": 6, "actions/upload-artifact": 6}
    texts = [path.read_text(encoding="utf-8") for path in WORKFLOWS]
    used = [line for text in texts for line in re.findall(r"uses: (\S+)", text)]
    assert len(used) > 20
    for action, _, major in (line.partition("@v") for line in used):
        assert int(major) >= first[action], action


def test_all_systems_and_the_oldest_and_newest_python_are_tested():
    content = yaml.safe_load((ROOT / ".github" / "workflows" / "tests.yml").read_text(encoding="utf-8"))
    places = content["jobs"]["suite"]["strategy"]["matrix"]["include"]
    assert {place["os"].partition("-")[0] for place in places} == {"ubuntu", "macos", "windows"}
    versions = re.findall(r"Python :: (3\.\d+)\"", PROJECT)
    assert {versions[0], versions[-1]} <= {place["python"] for place in places}
    assert f'requires-python = ">={versions[0]}"' in PROJECT


def test_wheels_are_built_for_every_python_that_is_declared():
    built = re.search(r'^build = "(.*)"', PROJECT, flags=re.MULTILINE)[1].split()
    declared = re.findall(r"Python :: 3\.(\d+)\"", PROJECT)
    assert {f"cp3{minor}-*" for minor in declared} | {f"cp3{declared[-1]}t-*"} == set(built)


def test_the_oldest_dependencies_are_those_that_are_declared():
    declared = re.search(r"\ndependencies = \[(.*?)\n\]", PROJECT, flags=re.DOTALL)[1]
    lines = (ROOT / "tests" / "packaging" / "oldest.txt").read_text(encoding="utf-8").splitlines()
    oldest = {line.replace("==", ">=").removesuffix(".*") for line in lines if not line.startswith("#")}
    assert oldest >= set(re.findall(r'"([^"]+)"', declared))


def test_every_folder_with_modules_is_a_package():
    """Otherwise setup.py does not find it, and a wheel lacks it."""
    folders = {path.parent for path in (ROOT / "vibsim").rglob("*.py")}
    assert [folder.name for folder in folders if not (folder / "__init__.py").exists()] == []


def test_the_engine_declares_that_it_needs_no_gil():
    source = (ROOT / "vibsim" / "engine" / "module.c").read_text(encoding="utf-8")
    assert "PyUnstable_Module_SetGIL(made, Py_MOD_GIL_NOT_USED)" in source
    methods = re.findall(r"\(PyCFunction\)([\w#]+)", source)
    assert methods and all(name.endswith("##_alone") for name in methods)  # each call holds its Run


def test_words_of_one_compiler_stand_where_others_have_theirs():
    """An `__attribute__` outside these headers, which ask for the compiler, ends the build on Windows."""
    folder = ROOT / "vibsim" / "engine"
    sources = [*folder.rglob("*.c"), *folder.rglob("*.h")]
    users = {path.name for path in sources if "__attribute__" in path.read_text(encoding="utf-8")}
    users.remove("limbs.h")  # of engines that setup.py leaves out there
    assert users == {"inlining.h", "pair.h", "wide.h"}


def test_extras_that_texts_name_are_there():
    """A text that names one that is gone sends its reader to pip for nothing."""
    texts = [*(ROOT / "vibsim").rglob("*.py"), *(ROOT / "docs").rglob("*.md"), ROOT / "README.md"]
    whole = "\n".join(path.read_text(encoding="utf-8") for path in texts)
    named = {*re.findall(r"\b(?:vibsim|extra )\[(\w+)\]", whole)}
    assert {"video", "parquet"} <= named
    assert {name for name in named if f"\n{name} = [" not in PROJECT} == set()


# Which compiler builds the engine: what answers, else the one of the package index.


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


def test_the_engine_is_compiled_with_the_rounding_of_setup_py(backend, monkeypatch, here):
    monkeypatch.setattr(backend, "target", lambda: "x86_64-linux-gnu.2.17")
    record = "import json, os, sys; json.dump([sys.argv[1:], dict(os.environ)], open('called.json', 'w'))"
    extension = SimpleNamespace(
        extra_compile_args=["-O3", "-ffp-contract=off"], define_macros=[("LIMBS", "2")],
        include_dirs=["here"], sources=["a.c", "b.cpp"],
    )  # fmt: skip
    backend.build_with_zig([sys.executable, "-c", record], extension, "out/module.so", "cache")
    words, environment = json.loads((here / "called.json").read_text())
    assert {"-ffp-contract=off", "-mcpu=baseline", "-DLIMBS=2", "-Ihere", "a.c", "b.cpp"} <= set(words)
    assert words[-2:] == ["-o", "out/module.so"]
    assert environment["ZIG_GLOBAL_CACHE_DIR"] == str(here / "cache")
    failing = [sys.executable, "-c", "raise SystemExit(1)"]
    with pytest.raises(backend.CompileError, match=r"did not make out/module\.so"):
        backend.build_with_zig(failing, extension, "out/module.so", "cache")


@pytest.mark.skipif(find_spec("ziglang") is not None, reason="the compiler of the package is installed here")
def test_setup_says_what_to_do_where_there_is_no_compiler(tmp_path, monkeypatch):
    for name, value in {"CC": "false", "CXX": "false", "VIBSIM_BUILD": "strict"}.items():
        monkeypatch.setenv(name, value)
    words = [sys.executable, "setup.py", "-q", "build_ext", "--build-lib", str(tmp_path)]
    done = subprocess.run(words, cwd=ROOT, capture_output=True, text=True, check=False)
    assert done.returncode == 1
    assert "python -m pip install ziglang" in done.stderr
