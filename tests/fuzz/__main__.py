"""Mutants of case files, command lines and result files: `python -m tests.fuzz --count 3000 --seed 1`.

A mutant fails that ends in a traceback, a signal or an exit code that its kind does not allow, that goes on
for more than two seconds after Ctrl-C, fails without a word, or sends control characters to the terminal.
What failed stays in the folder of --keep, with its command; the same seed makes the same mutants.
"""

import argparse
import random
import shutil
import sys
import tempfile
from collections import Counter
from pathlib import Path

from tests.fuzz import case_mutants, file_mutants, option_mutants
from tests.fuzz.running import PATIENCE, control_characters, preload, run

INTERRUPTED = {130, -2}  # -2: by the signal itself, which a shell calls 130
CODES = {
    "case": {0, 3, 4},
    "options": {0, 2, 3, 4, 5, 6},
    "file": {0, 2, 6},
}
ON_CASES = [["check", "case.yaml"], ["run", "case.yaml", "--t-end", "0.2s", "--force", "-o", "out.h5"]]
ON_CASES += [["run", "case.yaml", "--force", "-o", "out.h5"], ["check", "case.yaml", "--json"]]
ON_FILES = [
    ["info", "mutant.h5"],
    ["info", "mutant.h5", "--json"],
    ["analyse", "mutant.h5"],
    ["info", "mutant.h5", "--case"],
]
ON_FILES += [
    ["plot", "mutant.h5", "-o", "p.png", "--force"],
    ["export", "mutant.h5", "-o", "out.csv", "--force"],
]
ON_FILES += [
    ["compare", "mutant.h5", "run.h5"],
    ["plot", "mutant.h5", "--list"],
    ["run", "mutant.h5", "--dry-run", "-o", "o.h5"],
]


def main(words=None):
    parser = argparse.ArgumentParser(prog="python -m tests.fuzz", description=__doc__)
    parser.add_argument("--count", type=int, default=3000)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--kinds", default="case,options,file")
    parser.add_argument("--patience", type=float, default=PATIENCE)
    parser.add_argument("--keep", type=Path, default=Path("fuzz-failures"))
    options = parser.parse_args(words)
    preload()
    failed = Counter()
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        wholes = whole_files(folder / "whole")
        for number in range(options.count):
            kind = options.kinds.split(",")[number % len(options.kinds.split(","))]
            problem = one(f"{options.seed}/{number}", kind, folder / "scratch", wholes, options)
            if problem:
                failed[kind] += 1
                print(f"{kind} {options.seed}/{number}: {problem}", flush=True)
    print(f"{options.count} mutants, {sum(failed.values())} failed")
    return 1 if failed else 0


def whole_files(folder):
    """A folder with a file of every kind, for mutants to begin from."""
    folder.mkdir()
    for words in (
        ["run", "II-B", "--t-end", "1s", "-o", "run.h5"],
        ["run", "I-A", "--t-end", "0.1s", "--digits", "20", "-o", "digits.h5"],
        ["run", "II-B", "--t-end", "2s", "--lyapunov", "2", "-o", "exponents.h5"],
        ["sweep", "II-B", "--omega0", "3:5:1", "--t-end", "1s", "--section", "5", "-o", "sweep.h5"],
        ["sweep", "II-B", "--ensemble", "3", "--compute", "all", "--t-end", "1s", "-o", "ensemble.h5"],
        ["bench", "I-A", "--t-end", "0.5s", "--methods", "taylor", "-o", "bench.h5"],
    ):
        outcome = run(words, folder, limit=120)
        if outcome.code:
            raise SystemExit(f"{' '.join(words)}: {outcome.stderr}")
    shutil.copy(case_files()[0], folder / "case.yaml")
    return folder


def case_files():
    return sorted((Path(__file__).parents[2] / "cases").rglob("*.yaml"))


def one(seed, kind, scratch, wholes, options):
    """Make a mutant and run a command on it; what is wrong with how it ended, or None."""
    draw = random.Random(f"{seed}/{kind}")
    shutil.rmtree(scratch, ignore_errors=True)
    scratch.mkdir()
    words = MAKERS[kind](draw, scratch, wholes)
    outcome = run(words, scratch, patience=options.patience)
    problem = judged(outcome, CODES[kind], options.patience)
    if problem:
        kept = options.keep / f"{kind}-{seed.replace('/', '-')}"
        shutil.rmtree(kept, ignore_errors=True)
        shutil.copytree(scratch, kept)
        (kept / "words").write_text(repr(words))
        return f"{problem}: {words!r}"
    return None


def judged(outcome, codes, patience):
    """What is wrong with an outcome, in words; None where nothing is."""
    last = outcome.stderr.strip().rpartition("\n")[2]
    swallowed = (
        outcome.ending is not None and "Exception ignored" in outcome.stderr
    )  # by Python, in a callback
    if "Traceback" in outcome.stderr and not swallowed:
        return f"traceback, {last}"
    if outcome.ending is not None:
        ended = outcome.ending <= patience and outcome.code in INTERRUPTED | codes
        return None if ended else f"{outcome.ending:.1f} s to end after SIGINT, code {outcome.code}"
    if outcome.code not in codes:
        return f"exit code {outcome.code}, {last}"
    if outcome.code and not (last or outcome.stdout):
        return f"exit code {outcome.code} without a word"
    if found := control_characters(outcome.stdout + outcome.stderr):
        return f"control characters {sorted(found)!r}"
    return None


def of_a_case(draw, scratch, wholes):
    source = draw.choice(case_files())
    (scratch / "case.yaml").write_bytes(case_mutants.mutant(source.read_text(encoding="utf-8"), draw))
    return draw.choice(ON_CASES)


def of_options(draw, scratch, wholes):
    for name in ("run.h5", "sweep.h5", "case.yaml"):
        shutil.copy(wholes / name, scratch)
    return option_mutants.mutant(draw)


def of_a_file(draw, scratch, wholes):
    shutil.copy(wholes / "run.h5", scratch)
    file_mutants.mutant(draw.choice(sorted(wholes.glob("*.h5"))), scratch / "mutant.h5", draw)
    return draw.choice(ON_FILES)


MAKERS = {"case": of_a_case, "options": of_options, "file": of_a_file}

if __name__ == "__main__":
    sys.exit(main())
