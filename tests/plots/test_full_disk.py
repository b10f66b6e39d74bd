"""Pictures on a disk that fills up: one line, no picture, whatever the format and wherever the disk ends."""

import subprocess
import sys

import pytest

import vibsim
from tests.command_line.made import call

DRAW = """
import resource
from vibsim.command_line.main import main
for words in {commands}:
    for limit in (0, {limit}):  # no file grows beyond that
        resource.setrlimit(resource.RLIMIT_FSIZE, (limit, resource.RLIM_INFINITY))
        sys.argv[1:] = words
        try:
            main()
        except SystemExit as end:
            assert end.code == 6, words
"""
COMMANDS = [
    ["plot", "a.h5", "--kind", "motor", "-o", "p.pdf"],
    ["plot", "a.h5", "--kind", "motor", "-o", "p.svg"],
    ["plot", "a.h5", "--kind", "motor,stiffness", "-o", "p.pdf"],
    ["cases", "II-B", "--draw", "-o", "p.pdf"],
]


def test_no_picture_and_one_line(tmp_path):
    vibsim.simulate(vibsim.load_case("II-B", {"t_end": "2 s"})).save(tmp_path / "a.h5")
    program = "import sys" + DRAW.format(commands=COMMANDS, limit=6_000)
    done = subprocess.run([sys.executable, "-c", program], cwd=tmp_path, capture_output=True, text=True)
    lines = done.stderr.splitlines()
    assert done.returncode == 0 and len(lines) == 2 * len(COMMANDS), done.stderr
    assert all(line.startswith("Error: p.") and line.endswith(": disk full") for line in lines)
    assert [path.name for path in tmp_path.iterdir()] == ["a.h5"]


@pytest.mark.parametrize("length", [249, 260])
def test_a_name_that_is_too_long(tmp_path, length, monkeypatch):
    """Longer than the system takes, and such that only NAME.partial is."""
    monkeypatch.chdir(tmp_path)
    vibsim.simulate(vibsim.load_case("II-B", {"t_end": "1 s"})).save("a.h5")
    for words, suffix in (("plot a.h5 --kind motor -o", ".png"), ("run II-B --t-end 1s -o", ".hdf5")):
        name = "x" * (length - len(suffix)) + suffix
        done = call(*words.split(), name)
        assert (done.exit_code, done.stderr) == (6, f"Error: {name}: cannot write: File name too long\n")
