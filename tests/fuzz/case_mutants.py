"""Case files as a hurried user, an editor or a broken disk would leave them."""

import re

WORDS = [
    "0", "-1", "1e308", "-1e308", "1e-320", "1e400", "1e999999999", "nan", "inf", ".inf", "~", "null", "",
    "1/0", "0x10", "1_000", "1,5", "3:7:0.05", "true", "[1, 2]", "{a: 1}", "&a 1", "*a",
    "!!python/object 1", "1e15 s", "1 mm mm", "1 furlong", "9" * 400, "fixed", "compression", "motor",
    "harmonic", "none", "\u22125", "\x1b[2J", "\u0000", "\ud7ff", "'", '"',
]  # fmt: skip
CHARACTERS = "\t\n\r\0\x1b\x7f{}[]:,#&*!|>'\"%@`-?é漢\u2028\ufeff0123456789eE+.~"
NUMBER = re.compile(r"-?\d+(?:\.\d+)?(?:e-?\d+)?")


def mutant(text, draw):
    """The text of a case with one to four mutations, as bytes."""
    for _ in range(draw.randint(1, 4)):
        text = draw.choice(MUTATIONS)(text, draw)
    data = text.encode("utf-8", "surrogatepass")
    return with_a_random_byte(data, draw) if draw.random() < 0.1 else data


def another_number(text, draw):
    places = list(NUMBER.finditer(text))
    if not places:
        return text
    place = draw.choice(places)
    nasty = (
        draw.choice(WORDS)
        if draw.random() < 0.6
        else f"{draw.uniform(-10, 10) * 10 ** draw.randint(-30, 30):g}"
    )
    return text[: place.start()] + nasty + text[place.end() :]


def another_word(text, draw):
    places = list(re.finditer(r"\w+", text))
    place = draw.choice(places) if places else None
    return text if place is None else text[: place.start()] + draw.choice(WORDS) + text[place.end() :]


def a_character(text, draw):
    at = draw.randint(0, len(text))
    return text[:at] + draw.choice(CHARACTERS) + text[at + draw.randint(0, 2) :]


def lines_moved(text, draw):
    lines = text.splitlines(keepends=True)
    if len(lines) < 2:
        return text
    i, j = draw.randrange(len(lines)), draw.randrange(len(lines))
    what = draw.randrange(4)
    if what == 0:
        del lines[i]
    elif what == 1:
        lines.insert(j, lines[i])
    elif what == 2:
        lines[i], lines[j] = lines[j], lines[i]
    else:
        lines[i] = "  " + lines[i]
    return "".join(lines)


def a_line_more(text, draw):
    keys = [
        "extends: II-B",
        "extends: /dev/null",
        "extends: case.yaml",
        "extends: " + 300 * "x",
        "title: '$x^{2 $'",
    ]
    keys += [
        "run: {t_end: 1e15 s}",
        "run: {every: 1e-15 s}",
        "friction: {mu: 1e30}",
        "stop: {k2: 1e30, G: 0}",
    ]
    return f"{text}\n{draw.choice(keys)}\n"


def with_a_random_byte(data, draw):
    at = draw.randint(0, len(data))
    return data[:at] + bytes([draw.randrange(256)]) + data[at:]


MUTATIONS = [
    another_number, another_number, another_number, another_word, a_character, lines_moved, a_line_more,
]  # fmt: skip
