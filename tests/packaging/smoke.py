"""What an installed vibsim must do, with nothing beside it: run in an empty environment and folder.

    python smoke.py [--with-engine | --without-engine]

With --with-engine the C engine must be there, and agree with the Python engine bit for bit; with
--without-engine it must not.
"""

import argparse
import os
import subprocess
import sys
import tempfile
from importlib import metadata
from importlib.util import find_spec
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


def check_engines() -> None:
    """The C engine is there and agrees with the Python engine."""
    import vibsim

    case = vibsim.load_case("II-B", {"run.t_end": "2 s"})
    runs = [vibsim.simulate(case, engine=name, trust=False) for name in ("c", "python")]
    require(runs[0]["x2"].tobytes() == runs[1]["x2"].tobytes(), "both engines agree bit for bit")


def main() -> None:
    """Run all checks in a new folder."""
    parser = argparse.ArgumentParser(description=__doc__)
    expected = parser.add_mutually_exclusive_group()
    expected.add_argument("--with-engine", action="store_true")
    expected.add_argument("--without-engine", action="store_true")
    asked = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        os.chdir(folder)
        check_installation()
        check_results()
        if asked.with_engine:
            check_engines()
        if asked.without_engine:
            require(find_spec("vibsim.engine._engine") is None, "there is no C engine")
        os.chdir(os.path.dirname(folder))


if __name__ == "__main__":
    main()
