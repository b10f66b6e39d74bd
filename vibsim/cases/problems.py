"""Problems of a case: one per line, all at once."""

import re
from collections.abc import Collection, Iterable, Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple
from unicodedata import category

MOST_LISTED = 25  # problems of one case that are printed


@dataclass(frozen=True)
class Problem:
    """One thing that is wrong, and where.

    Attributes
    ----------
    file : path as the user gave it, "overrides" for one of them, or the name asked for
    line, column : counted from 1; None where there is no place (an override, a missing file)
    key : dotted key such as "excitation.Omega0"; empty where the problem belongs to no key
    message : what is wrong, what was found and what is allowed
    """

    file: str
    line: int | None
    column: int | None
    key: str
    message: str

    def __str__(self) -> str:
        key = shown(self.key, limit=100) if self.key else ""
        file = plain_text(self.file)
        if self.line is None:
            return f"{f'{file} {key}'.strip()}: {self.message}"
        return f"{file}:{self.line}:{self.column}: {f'{key}: ' if key else ''}{self.message}"


class CaseError(Exception):
    """A case that cannot be used; `problems` lists everything that was found wrong with it.

    >>> import vibsim
    >>> try:
    ...     vibsim.load_case("II-B", {"c": "1 kg", "mu": -1})
    ... except vibsim.CaseError as error:
    ...     print([problem.key for problem in error.problems])
    ['coupling.c', 'friction.mu']
    """

    def __init__(self, problems: Iterable[Problem]):
        self.problems = list(problems)
        super().__init__("\n".join(listed(self.problems)))

    def __reduce__(self) -> tuple[Any, ...]:
        return CaseError, (self.problems,)


def listed(problems: Sequence[Problem]) -> list[str]:
    """A line for each problem, of many for the first ones: a file that is no case is wrong in every line."""
    more = len(problems) - MOST_LISTED
    rest = [f"and {counted(more, 'more problem')}"] if more > 0 else []
    return [*map(str, problems[:MOST_LISTED]), *rest]


def shown(text: object, limit: int = 60) -> str:
    """A user's text on one line, shortened, for use inside a message."""
    line = one_line(text)
    if not line:
        return "nothing"
    return line if len(line) <= limit else line[: limit - 3] + "..."


# Keys that stand in place of one another: the one that a child or an override gives drops the other.


ALTERNATIVES: dict[str, tuple[tuple[frozenset[str], frozenset[str]], ...]] = {
    "friction": (
        (frozenset({"N"}), frozenset({"g"})),
        (frozenset({"mu", "static", "mu_s", "mu_d", "d", "v0"}), frozenset({"plus", "minus"})),
        (frozenset({"mu", "static"}), frozenset({"mu_s", "mu_d", "d", "v0"})),
        (frozenset({"d"}), frozenset({"v0"})),
    ),
    "stops": ((frozenset({"e"}), frozenset({"k", "c", "release"})),),
    "forces": ((frozenset({"terms"}), frozenset({"A", "omega", "phase"})),),
    "base": ((frozenset({"terms"}), frozenset({"a", "omega", "phase"})),),
}
DEPTH = {"stops": 2, "friction": 2, "forces": 2, "base": 1}  # of the dotted key of the part that has them


def superseded(part: str, keys: Collection[str]) -> set[str]:
    """Keys of a part, such as "friction.guide", that give way when `keys` are set over it."""
    section, *names = part.split(".")
    out: set[str] = set()
    if DEPTH.get(section) != len(names) + 1:
        return out
    for one, other in ALTERNATIVES[section]:
        for new, old in ((one, other), (other, one)):
            if new & set(keys) and not old & set(keys):
                out |= old
    return out


# The allowed word that a misspelt one most likely stands for.
#
# Two words are near where few slips of the typing hand lie between them: a letter left out, put in, mistyped,
# or two neighbours exchanged (the restricted Damerau-Levenshtein distance). One slip is allowed per three
# letters of the shorter word, one at least, and one more where first and last letter are right: `rnu` is
# `run`, `herz` is `Hz`, and `nosuch` is not `bench`.


LETTERS_PER_SLIP = 3
LONGEST = 60  # characters; nothing that is allowed is longer


class KnownLimit(NamedTuple):
    """Something that users of other programs expect, by the words that they write, and what there is."""

    words: tuple[str, ...]
    instead: str


LIMITS_PAGE = "docs/limits.md, What other programs call by a key"
LIMITS = (
    KnownLimit(("noise", "random", "stochastic"), "all that happens in a scene follows from its numbers"),
    KnownLimit(("delay",), "forces follow from the state of the scene and from the time"),
    KnownLimit(
        ("gravity", "weight", "angle", "slope", "incline", "tilt"),
        "weight, or its part along the line, is a constant force F0 on each body",
    ),
)
FORMULAS_PAGE = "docs/scenes.md, Formulas"
BY_FORMULAS = (
    KnownLimit(
        ("k3", "kc", "cubic", "quadratic", "nonlinear", "duffing", "hertz", "c3"),
        "a spring that is not linear is a formula at force, with its numbers beside it: k*d + k3*d**3",
    ),
    KnownLimit(
        ("pulse", "ramp", "square", "sawtooth", "chirp", "table", "formula", "expression", "function"),
        "a load of another course in time is a formula at force: A*sin(w*t + r*t**2/2)",
    ),
    KnownLimit(
        ("control", "controller", "feedback", "pid"),
        "a force that follows from the motion is a formula at force: -kp*x_ram - kd*v_ram",
    ),
    KnownLimit(
        ("theta", "rotation", "torsion"),
        "bodies turn where their unit is one of inertia, and rotors on bodies stand in rotors",
    ),
    KnownLimit(
        ("acceleration",),
        "the base moves by its displacement, with the amplitude a = a0/omega^2 of an acceleration a0",
    ),
    KnownLimit(("zeta",), "a damping ratio is the damping c = 2 zeta m 2 pi f0"),
    KnownLimit(
        ("voltage", "current", "resistance", "inductance"),
        "the current of a motor is a further state, with a formula at rate: (U - R*i - K*w)/L",
    ),
)
SPELLED_OUT = {  # keys, by the words that other programs have for them
    "springs": ("links",),
    "dampers": ("links",),
    "masses": ("bodies",),
    "contacts": ("stops",),
    "stiffness": ("k", "k1", "k2"),
    "damping": ("c",),
    "restitution": ("e",),
    "clearance": ("gap", "G"),
    "amplitude": ("A", "a"),
    "frequency": ("omega",),
    "duration": ("t_end",),
    "dt": ("every",),
}
TOLD = ((LIMITS, "is not supported", LIMITS_PAGE), (BY_FORMULAS, "is no key", FORMULAS_PAGE))


def nearest(word: str, allowed: Iterable[str]) -> str | None:
    """The allowed word with the fewest slips, or None where none is near; letter case counts for nothing.

    Of several, the one with the fewest slips among letters and digits, then the first. A word that begins
    just one allowed word, or goes on behind one, stands for it too; so does a word of `SPELLED_OUT`.
    """
    allowed = list(allowed)
    for name in SPELLED_OUT.get(word, ()):
        if name in allowed:
            return name
    typed, names = _folded(word)[:LONGEST], {_folded(name): name for name in reversed(allowed)}
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


def counted(number: int | str, word: str) -> str:
    """A number with its word: 1 impact, 2 impacts, 1 loss, 2 losses, 1 body, 2 bodies."""
    if str(number) == "1":
        return f"1 {word}"
    if re.search(r"[^aeou]y$", word):
        return f"{number} {word[:-1]}ies"
    return f"{number} {word}{'es' if word.endswith(('s', 'x', 'ch', 'sh')) else 's'}"


def unsupported(word: str) -> str:
    """Where to look instead of something that no scene has, or has under no key, and where that is written;
    empty for others.
    """
    for limits, what, page in (
        (LIMITS, "is not supported", LIMITS_PAGE),
        (BY_FORMULAS, "is no key", FORMULAS_PAGE),
    ):
        limit = next((limit for limit in limits if word.casefold() in limit.words), None)
        if limit:
            return f"{what}: {limit.instead} ({page})"
    return ""


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


# User text as text: what a terminal would obey and no font can show is written out, such as \x1b.


UNSTORABLE = re.compile("[\0\ud800-\udfff]")  # the end of a text in HDF5; what UTF-8 does not take


def plain_text(text: object, allowed: str = "") -> str:
    """A text with every character that is not printed as an escape of ASCII characters.

    Control and format characters (colours, cursor, direction of writing), line breaks, lone surrogates and
    code points without a character become \\x1b, \\n, \\u202e ...; those in `allowed` stay as they are.
    """
    return "".join(
        ch if ch.isprintable() or ch in allowed or category(ch) == "Zs" else _escape(ch) for ch in str(text)
    )


def one_line(text: object) -> str:
    """A plain text on one line, runs of white space as one blank."""
    return plain_text(" ".join(str(text).split()))


def unstorable(text: str) -> str:
    """The first character of a text that files cannot hold (null, lone surrogates), written out."""
    match = UNSTORABLE.search(text)
    return _escape(match.group()) if match else ""


def _escape(character: str) -> str:
    return character.encode("unicode_escape").decode("ascii")
