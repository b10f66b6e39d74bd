"""What is said of files that the same command completes: sweeps, branches, fits, the paper's report."""

from pathlib import Path

from vibsim.command_line.text.quantities import size


def goes_on(path: str | Path) -> str:
    """Where an interrupted command has left what it did, and how that is completed."""
    return f"{path} holds what was done; the same command goes on from there"


def completed_file(path: Path, count: int, had: int, took: float) -> str:
    """A file with its size, and how long its points took.

    count, had : of points that it holds, and that it held before; took : for the others [s]
    """
    text = f"{path} ({size(path)})"
    if had == count:
        return f"{text}, was complete: nothing to compute"
    return f"{text}, {took:.2f} s" + (f", {had} points were there" if had else "")
