"""README's commands run as printed, and print what README shows (labels, not the timings beside them)."""

import os
import re
import shlex
import shutil
import subprocess
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
README = (ROOT / "README.md").read_text(encoding="utf-8")
LABEL = re.compile(r"^  (\w+(?: \w+)?)\s")


def console_blocks():
    """Each console block of README as a list of (command, lines of output)."""
    blocks = []
    for text in re.findall(r"```console\n(.*?)```", README, flags=re.DOTALL):
        commands = []
        for line in text.splitlines():
            if line.startswith("$ "):
                commands.append((line[2:].split("  #")[0].strip(), []))
            else:
                commands[-1][1].append(line)
        blocks.append(commands)
    return blocks


def labels(lines):
    """The labels in front of a summary's values."""
    return [found.group(1) for found in map(LABEL.match, lines) if found]


def run(command, folder):
    """Run one `vibsim` command of README in `folder`; its output, both streams."""
    words = shlex.split(command)
    environment = {**os.environ, "NO_COLOR": "1", "PYTHONPATH": str(ROOT)}
    done = subprocess.run(
        [sys.executable, "-m", *words],
        cwd=folder,
        env=environment,
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        text=True,
        check=False,
    )
    assert done.returncode == (3 if "broken" in command else 0), f"{command}\n{done.stdout}"
    return done.stdout.splitlines()


def test_the_commands_run_as_printed(tmp_path):
    shutil.copytree(ROOT / "cases", tmp_path / "cases")
    good = (ROOT / "cases" / "II-B.yaml").read_text(encoding="utf-8")
    bad = good.replace("5.5 Hz  ", "-5.5 Hz ").replace("mu: 0", "mue: 0").replace("200 N/m", "200 kg")
    (tmp_path / "broken.yaml").write_text(bad, encoding="utf-8")
    commands = [pair for block in console_blocks() for pair in block if pair[0].startswith("vibsim")]
    assert len(commands) >= 8
    for command, shown in commands:
        assert labels(run(command, tmp_path)) == labels(shown), command


def test_make_run_and_make_test_are_shown_and_exist():
    makefile = (ROOT / "Makefile").read_text(encoding="utf-8")
    for target in ("run", "test"):
        assert f"$ make {target}" in README
        assert re.search(rf"^{target}:", makefile, flags=re.MULTILINE)


def test_the_python_example_runs(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (code,) = re.findall(r"```python\n(.*?)```", README, flags=re.DOTALL)
    exec(compile(code, "README.md", "exec"), {})
    assert (tmp_path / "faster.h5").exists()


def test_the_pictures_exist():
    for target in re.findall(r"!\[[^]]*\]\(([^)]+)\)", README):
        assert (ROOT / target).is_file(), target
