"""Command lines as people mistype them."""

VALUES = [
    "0", "-1", "1", "2", "0.5", "nan", "inf", "1e400", "1e-400", "1e999999999", "", " ", "x", "1 s", "1s",
    "5ms", "0s", "-1s", "1e15s", "3:5:1", "5:3:1", "3:5", "3:5:0", "1e400:2:1", "3,4,4", "4,3", "3:5/0",
    "3:5/3", "0:1", "500:600", "0.2:0.2000001", "1:0", ":", "a:b", "c=0.03", "c=", "=", "nosuch=1",
    "Omega0=6 Hz", "G=0:2mm/20", "G=1,2 mm", "mu=1e30", "run.t_end=1e300", "name=", "title=\x1b[2J",
    "excitation.kind=none", "1/3", "3/1", "0/0", "all", "100", "20", "relative", "csv", "png", "\x1b]0;x\a",
    "drift none", "impacts at most 3", "NS1", "PD9", "x1", "events/v1", "12x8", "orbit.h5", "fit.h5", "é",
    "9" * 40,
]  # fmt: skip
OPTIONS = {
    "run": "-s --t-end --every --method --digits --lyapunov --discard --plot --dry-run --force --no-trust",
    "sweep": "--omega0 --omega --param --direction --carry-state --discard --section --every --compute "
    "--ensemble --seed --spread -s --t-end --shard --force -j --list",
    "orbit": "-s --from --period --search --seed --digits --force",
    "continue": "--omega0 --omega --param --energy --switch --locus --max-points -s --force",
    "fit": "--want --free --leave --try --ensemble --spread --method --candidates --at-most --screen "
    "--confirm --fresh --seed --list -s --every -j --force",
    "plot": "--kind --window --detail --x --y --width --size --font-size --style --list --force",
    "animate": "--window --speed --force",
    "info": "--case --json -v -q",
    "analyse": "--what --window --discard --no-exponent -s --json",
    "compare": "--tolerance --json",
    "export": "--window --along --ro-crate --events --force",
    "bench": "-s --methods --limit --truth --plot --force",
    "verify": "--list --json",
    "cases": "--json",
    "check": "--json -s",
    "schema": "",
    "new": "--from --force",
    "nosuch": "--nothing",
}
FLAGS = {"--dry-run", "--force", "--no-trust", "--carry-state", "--list", "--case", "--json", "-v", "-q"}
FLAGS |= {"--events", "--no-exponent", "--ro-crate"}
OUTPUTS = ["out.h5", "out.csv", "out.png", "out.html", "out", "nosuch/out.h5", "/dev/null"]
SOURCES = ["II-B", "I-A", "case.yaml", "run.h5", "sweep.h5", "orbit.h5", "branch.h5", "fit.h5", "locus.h5"]
SOURCES += ["nosuch", "nosuch.h5", "-", ".", "\x1b[2J.h5"]
OFTEN = [9, 3, 5, 9, 9, 5, 5, 2, 2, 1, 1, 1, 1, 1]  # how often each source
SHORT = {  # what keeps a command from running for long
    "run": "--t-end 0.2s",
    "sweep": "--t-end 0.2s",
    "continue": "--max-points 4",
    "fit": "--t-end 0.2s --candidates 4 --confirm 1 --fresh 1 --ensemble 1",
    "bench": "--t-end 0.1s --methods taylor",
}
USUAL = {  # what a command does little without
    "sweep": "--omega0 3:5:1",
    "continue": "--omega0 3:9",
    "fit": "--free J=1:2gm^2 --want captured",
}


def mutant(draw):
    """Words of one command line; what would run for long is cut short by options in front."""
    command = draw.choice(list(OPTIONS))
    words = [command, *draw.choices(SOURCES, OFTEN, k=draw.choice([0, 1, 1, 1, 2]))]
    words += SHORT.get(command, "").split()
    if draw.random() < 0.5:
        words += ["-o", draw.choice(OUTPUTS)]
    words += USUAL.get(command, "").split() if draw.random() < 0.5 else []
    for _ in range(draw.randint(0, 3)):
        option = draw.choice(OPTIONS[command].split() or ["--help"])
        words += [option] if option in FLAGS else [option, draw.choice(VALUES)]
    return words
