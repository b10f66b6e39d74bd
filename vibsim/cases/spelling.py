"""The allowed word that a misspelt one most likely stands for.

Two words are near where few slips of the typing hand lie between them: a letter left out, put in, mistyped,
or two neighbours exchanged (the restricted Damerau-Levenshtein distance). One slip is allowed per three
letters of the shorter word, one at least, and one more where first and last letter are right: `rnu` is `run`,
`herz` is `Hz`, and `nosuch` is not `bench`.
"""

from collections.abc import Iterable
from typing import NamedTuple

LETTERS_PER_SLIP = 3
LONGEST = 60  # characters; nothing that is allowed is longer


class Limit(NamedTuple):
    """Something that users of other programs expect, by the words that they write, and what there is."""

    words: tuple[str, ...]
    instead: str


LIMITS_PAGE = "docs/scenes.md, What a scene cannot have"
LIMITS = (
    Limit(
        ("k3", "kc", "cubic", "quadratic", "nonlinear", "duffing", "hertz", "c3"),
        "links and stops have linear springs and dampers",
    ),
    Limit(
        ("pulse", "ramp", "square", "sawtooth", "chirp", "table", "formula", "expression", "function"),
        "forces and the base are sums of sines, with A, omega and phase, or terms",
    ),
    Limit(("noise", "random", "stochastic"), "all that happens in a scene follows from its numbers"),
    Limit(
        ("delay", "control", "controller", "feedback", "pid"),
        "forces and the base follow from the time alone",
    ),
    Limit(
        ("gravity", "weight", "angle", "slope", "incline", "tilt"),
        "weight, or its part along the line, is a constant force F0 on each body",
    ),
    Limit(
        ("theta", "rotation", "torsion", "torque"), "bodies move along one line; only a motor's rotor turns"
    ),
    Limit(("voltage", "current", "resistance", "inductance"), "a motor has the torque M0 (1 - w / Omega0)"),
)


def nearest(word: str, allowed: Iterable[str]) -> str | None:
    """The allowed word with the fewest slips, or None where none is near; letter case counts for nothing.

    Of several, the one with the fewest slips among letters and digits, then the first. A word that begins
    just one allowed word, or goes on behind one, stands for it too.
    """
    typed, names = _folded(word)[:LONGEST], {_folded(name): name for name in reversed(list(allowed))}
    if not typed or not names:
        return None
    near = min(reversed(names), key=lambda name: (slips(typed, name), slips(_letters(typed), _letters(name))))
    if slips(typed, near) <= _slips_allowed(typed, near):
        return names[near]
    begun = [name for name in names if len(typed) > 1 and name.startswith(typed)]
    if len(begun) == 1:
        return names[begun[0]]
    longest = max((name for name in names if len(name) > 1 and typed.startswith(name)), key=len, default=None)
    return names[longest] if longest else None


def did_you_mean(word: str, allowed: Iterable[str]) -> str:
    """ " (did you mean X?)", or an empty text where nothing allowed is near."""
    match = nearest(word, allowed)
    return f" (did you mean {match}?)" if match else ""


def unsupported(word: str) -> str:
    """What there is in place of something that no scene has, and where that is written; empty for others."""
    limit = next((limit for limit in LIMITS if word.casefold() in limit.words), None)
    return f"is not supported: {limit.instead} ({LIMITS_PAGE})" if limit else ""


def slips(a: str, b: str) -> int:
    """Restricted Damerau-Levenshtein distance: letters left out, put in, mistyped, neighbours exchanged."""
    before: list[int] = []
    row = list(range(len(b) + 1))
    for i, x in enumerate(a, start=1):
        last, before, row = before, row, [i]
        for j, y in enumerate(b, start=1):
            best = min(before[j] + 1, row[j - 1] + 1, before[j - 1] + (x != y))
            if i > 1 and j > 1 and x == b[j - 2] and y == a[i - 2]:
                best = min(best, last[j - 2] + 1)
            row.append(best)
    return row[-1]


def _slips_allowed(typed: str, name: str) -> int:
    shorter = min(len(typed), len(name))
    if shorter < 2:
        return 0
    ends_right = typed[0] == name[0] and typed[-1] == name[-1]
    return max(1, shorter // LETTERS_PER_SLIP) + (ends_right and max(len(typed), len(name)) > 2)


def _letters(word: str) -> str:
    return "".join(filter(str.isalnum, word))


def _folded(word: str) -> str:
    return word.casefold().replace("_", "-")
