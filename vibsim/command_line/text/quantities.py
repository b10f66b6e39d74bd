"""Counts, lengths, durations and sizes as a summary writes them."""

from pathlib import Path

PREFIXES = ((1.0, "m"), (1e-3, "mm"), (1e-6, "um"), (1e-9, "nm"))
DURATIONS = ((1.0, "s"), (1e-3, "ms"), (1e-6, "us"), (1e-9, "ns"))
SIZES = ((1e9, "GB"), (1e6, "MB"), (1e3, "kB"))


def counted(number: int, word: str) -> str:
    """1 impact, 2 impacts."""
    return f"{number} {word}{'' if number == 1 else 's'}"


def metres(x: float) -> str:
    """A length to four digits with the prefix that suits it; 0 has no sign."""
    factor, unit = next(((f, u) for f, u in PREFIXES if abs(x) >= f), PREFIXES[-1]) if x else PREFIXES[0]
    return f"{x / factor + 0.0:.4g} {unit}"


def seconds(t: float) -> str:
    """A duration with the prefix that suits it: s, ms, us or ns, and below that s again."""
    factor, unit = next(((f, u) for f, u in DURATIONS if t >= f), (1.0, "s"))
    return f"{t / factor:g} {unit}"


def size(path: str | Path) -> str:
    """Size of a file with the prefix that suits it."""
    count = Path(path).stat().st_size
    factor, unit = next(((f, u) for f, u in SIZES if count >= 0.9995 * f), (1, "bytes"))
    return f"{count / factor:.3g} {unit}"
