"""Command lines as people mistype them."""

VALUES = [
    "0",
    "-1",
    "1",
    "2",
    "0.5",
    "nan",
    "inf",
    "1e400",
    "1e-400",
    "1e999999999",
    "",
    " ",
    "x",
    "1 s",
    "1s",
    "5ms",
    "0s",
    "-1s",
    "1e15s",
    "3:5:1",
    "5:3:1",
    "3:5",
    "3:5:0",
    "1e400:2:1",
    "3,4,4",
    "4,3",
    "3:5/0",
    "3:5/3",
    "0:1",
    "500:600",
    "0.2:0.2000001",
    "1:0",
    ":",
    "a:b",
    "c=0.03",
    "c=",
    "=",
    "nosuch=1",
    "Omega0=6 Hz",
    "G=0:2mm/20",
    "G=1,2 mm",
    "mu=1e30",
    "run.t_end=1e300",
    "name=",
    "title=\x1b[2J",
    "excitation.kind=none",
    "1/3",
    "3/1",
    "0/0",
    "all",
    "100",
    "20",
    "relative",
    "csv",
    "png",
    "\x1b]0;x\a",
    "é",
    "9" * 40,
]
LONG = ["--t-end", "0.2s"]
OPTIONS = {
    "run": [
        "-s",
        "--t-end",
        "--every",
        "--method",
        "--lyapunov",
        "--plot",
        "--dry-run",
        "--force",
        "--no-trust",
    ],
    "sweep": [
        "--omega0",
        "--omega",
        "--param",
        "--direction",
        "--carry-state",
        "--discard",
        "--section",
        "--every",
    ]
    + [
        "--compute",
        "--ensemble",
        "--seed",
        "--spread",
        "-s",
        "--t-end",
        "--shard",
        "--force",
        "-j",
        "--list",
    ],
    "plot": ["--kind", "--window", "--detail", "--width", "--list", "--force"],
    "info": ["--case", "--json", "-v", "-q"],
    "analyse": ["--window", "-s", "--json"],
    "compare": ["--tolerance", "--json"],
    "export": ["--window", "--format", "--events", "--force"],
    "cases": ["--json"],
    "check": ["--json", "-s"],
    "schema": [],
    "nosuch": ["--nothing"],
}
FLAGS = {
    "--dry-run",
    "--force",
    "--no-trust",
    "--carry-state",
    "--list",
    "--case",
    "--json",
    "-v",
    "-q",
    "--events",
}
OUTPUTS = ["out.h5", "out.csv", "out.png", "out", "nosuch/out.h5", "/dev/null"]
SOURCES = ["II-B", "I-A", "case.yaml", "run.h5", "sweep.h5", "nosuch", "nosuch.h5", "-", ".", "\x1b[2J.h5"]


def mutant(draw):
    """Words of one command line; what would run for long is cut short by options in front."""
    command = draw.choice(list(OPTIONS))
    words = [command, *draw.choices(SOURCES, [9, 3, 5, 9, 9, 1, 1, 1, 1, 1], k=draw.choice([0, 1, 1, 1, 2]))]
    words += LONG if command in ("run", "sweep") else []
    if draw.random() < 0.5:
        words += ["-o", draw.choice(OUTPUTS)]
    words += ["--omega0", "3:5:1"] if command == "sweep" and draw.random() < 0.5 else []
    for _ in range(draw.randint(0, 3)):
        option = draw.choice(OPTIONS[command] or ["--help"])
        words += [option] if option in FLAGS else [option, draw.choice(VALUES)]
    return words
