"""What an installed vibsim must do, with nothing beside it: run in an empty environment and folder.

python smoke.py
"""

import os
import subprocess
import sys
import tempfile
from importlib import metadata
from pathlib import Path


def command(*words: str) -> str:
    """Output of `vibsim words...`, of the script that was installed. Raises CalledProcessError."""
    script = Path(sys.executable).with_name("vibsim.exe" if os.name == "nt" else "vibsim")
    done = subprocess.run([str(script), *words], capture_output=True, text=True, check=False)
    if done.returncode:
        raise SystemExit(f"vibsim {' '.join(words)}: exit code {done.returncode}\n{done.stdout}{done.stderr}")
    return done.stdout


def require(holds: bool, what: str) -> None:
    """End with an error where something does not hold."""
    if not holds:
        raise SystemExit(f"smoke test: {what}")
    print(f"ok: {what}")


def check_installation() -> None:
    """The package is the installed one, and whole."""
    import vibsim

    here = Path(vibsim.__file__).parent
    require(Path.cwd() not in here.parents, f"vibsim is the installed one ({here})")
    require(metadata.version("vibsim") == vibsim.__version__, f"version {vibsim.__version__}")
    require(command("--version").split()[-1] == vibsim.__version__, "the command has the same version")
    require("gallery/energy-sink" in command("cases"), "the cases are shipped")


def check_results() -> None:
    """A run, its file, a picture, a sweep and a known case."""
    import vibsim

    require("trust horizon" in command("run", "II-B", "--t-end", "20s"), "a run")
    require(vibsim.open_result("II-B.h5").attrs["impacts"] == 115, "115 impacts until 20 s in its file")
    command("plot", "II-B.h5", "-o", "II-B.png")
    require(Path("II-B.png").stat().st_size > 10_000, "a picture")
    swept = command("sweep", "II-B", "--omega0", "5,6", "--t-end", "5s", "-o", "swept.h5")
    require("2 of 2 done" in swept, "a sweep")
    require("all within their bounds" in command("verify", "V3"), "a known case")


def main() -> None:
    """Run all checks in a new folder."""
    with tempfile.TemporaryDirectory() as folder:
        os.chdir(folder)
        check_installation()
        check_results()
        os.chdir(os.path.dirname(folder))


if __name__ == "__main__":
    main()
