"""The numbers of docs/paper.md: phrases of the page, each with what its numbers are made from.

docs/paper-numbers.json is the table of numbers of a whole `vibsim paper`, rounded. Both are
brought up to date by

    python -m tests.docs.paper_page results/paper/numbers.json    (make paper-page)
"""

import json
import re
import sys
from collections import Counter
from itertools import pairwise
from pathlib import Path

from tests.docs.pages import DOCS
from vibsim.evidence.reports.claims import (
    EXAMPLE,
    FAILS,
    HOLDS,
    IN_KIND,
    ONLY_IF,
    how_many,
    is_captured,
    is_settled,
    near_natural,
    share_above,
)
from vibsim.evidence.reports.measurements import EQUAL_FORCE, MOTORS, PRINTED, SHIPPED_READINGS
from vibsim.evidence.reports.model_claims import one_impact
from vibsim.evidence.reports.motor_claims import peaks_late
from vibsim.evidence.reports.paper import table_of
from vibsim.evidence.reports.paper_document import judge_claims, named, price_of

PAGE, STORED = DOCS / "paper.md", DOCS / "paper-numbers.json"
DIGITS = 6  # of a stored number
NUMBER = r"(−?-?\d+(?:\.\d+)?)"
PAIRS = tuple(zip(MOTORS, PRINTED, strict=True))


def rounded(value):
    """Numbers to DIGITS, in whatever holds them."""
    if isinstance(value, dict):
        return {key: rounded(each) for key, each in value.items()}
    if isinstance(value, list):
        return [rounded(each) for each in value]
    return float(f"{value:.{DIGITS}g}") if isinstance(value, float) else value


def stored_numbers():
    """The table that the page is held against."""
    return json.loads(STORED.read_text(encoding="utf-8"))


def count_of(verdicts, *words):
    return sum(verdict.word in words for verdict in verdicts)


def judged(n):
    findings = [finding for _, finding in judge_claims(n)]
    both = [finding for finding in findings if finding.starts is not None]
    alone = [finding.rest for finding in findings if finding.starts is None]
    rest, starts = ([getattr(finding, which) for finding in both] for which in ("rest", "starts"))
    return findings, both, rest, starts, alone


def verdict_counts(n):
    """Of the summary: all, about motions; hold, under a condition or in kind, with other numbers, do not."""
    findings, both, rest, starts, alone = judged(n)
    kinds = ((HOLDS,), (ONLY_IF, IN_KIND), (EXAMPLE,), (FAILS,))
    of_rest, of_starts = ([count_of(each, *words) for words in kinds] for each in (rest, starts))
    return [
        len(findings),
        len(both),
        *of_rest,
        starts_of(n),
        *of_starts,
        len(alone),
        *(count_of(alone, w) for w in (HOLDS, FAILS)),
    ]


def starts_of(n):
    return len(n["ensembles"]["II-B"]["outcomes"])


def run(n, name):
    return n["runs"][name]


def end_mm(n, name):
    """x2 at the end [mm]."""
    return 1e3 * run(n, name)["overall"] * run(n, name)["t_end"]


def final(n, name):
    return f"{run(n, name)['capture']['final_speed_hz']:.2f}"


def finals(n, name):
    """Least and greatest final speed of the perturbed starts that settle [Hz]."""
    outcomes = n["ensembles"][name]["outcomes"]
    speeds = [each["final_hz"] for each in outcomes if is_settled(each) and each["final_hz"] is not None]
    return [f"{each:.2f}" for each in (min(speeds), max(speeds))]


def percents(n, pairs, key):
    return [f"{100 * share_above(n, *pair, key):.0f}" for pair in pairs]


def amplitudes(n, key, form):
    return [form.format(row[key]) for row in n["facts"]["amplitudes"]]


def digits_of(n):
    """Least and greatest digits carried, and the least right at the end."""
    words = [re.findall(r"\d+", each["how"]) for each in n["runs"].values() if each["how"]]
    carried, right = ([int(one[i]) for one in words] for i in (1, 2))
    return min(carried), max(carried), min(right)


def chaotic_hz(n):
    """Frequencies of the chaotic points by Table 1's rule with the printed damping [Hz]."""
    found = [
        row["hz"]
        for row in n["nearby"]
        if (row["law"], row["c"], row["regime"]) == ("Table 1", 0.001, "chaotic")
    ]
    return [f"{each:.1f}" for each in found]


def gaps(n):
    rows = n["gaps"]
    held = [row for row in rows if near_natural(row["speed_hz"])]
    assert not any(row["impacts_per_turn"] for row in held)
    return [len(rows), f"{rows[0]['gap_mm']:g}", f"{rows[-1]['gap_mm']:g}", f"{held[0]['gap_mm']:g}"]


def growth(n, key, form):
    ends = [n["ends"][words] for words in ("as printed", "the reading")]
    return [form.format(100 * (end[key] / end["half"][key] - 1)) for end in ends]


def captured_from(outcomes):
    return sum(map(is_captured, outcomes))


def escape_times(n):
    capture = run(n, "II-C-escape")["capture"]
    return [f"{capture[key]:.0f}" for key in ("since", "until")]


def ratios(n):
    rows = n["facts"]["amplitudes"]
    times = [row["eq211"] / row["printed"] for row in rows]
    off = max(abs(row["printed"] / row["m3_e_omega"] - 1) for row in rows)
    return f"{100 * off:.1f}", f"{min(times):.0f}", f"{max(times):.0f}"


def slopes(n):
    rows = n["facts"]["characteristics"]
    torques = [f"{1e3 * rows[0]['slope'] * row['M0'] / row['slope']:.2f}" for row in rows[1:]]
    captured = [captured_from(n["voltages"][name]["outcomes"]) for name in ("II-B", "II-C")]
    return [*(f"{1e3 * row['slope']:.3f}" for row in rows), *torques, *captured, starts_of(n)]


# phrase of the page, {} for each number, and the numbers
PHRASES = (
    ("judges {} statements of it", lambda n: verdict_counts(n)[:1]),
    (
        "{} of them are about motions and have two verdicts. On the motions from rest, which are "
        "known exactly, {} "
        "hold, {} hold under a condition or in kind, {} with other numbers, {} do not; over {} "
        "perturbed starts {} "
        "hold, {} hold under a condition, {} with other numbers, {} do not. No start enters into "
        "the other {}: {} "
        "hold, {} do not.",
        lambda n: verdict_counts(n)[1:],
    ),
    ("a run of {} to {} digits, {} or more of them right at 300 s", digits_of),
    (
        "From rest II-B ends at x2 = {} mm after {} impacts and {} stick phases, "
        "II-C at {} mm after {} impacts",
        lambda n: (
            f"{end_mm(n, 'II-B'):.3f}",
            run(n, "II-B")["impacts"],
            run(n, "II-B")["sticks"],
            f"{end_mm(n, 'II-C'):.3f}",
            run(n, "II-C")["impacts"],
        ),
    ),
    ("prints {}, {} and {} (in m)", lambda n: amplitudes(n, "printed", "{:.4f}")),
    ("m3 e omega to {} %", lambda n: ratios(n)[:1]),
    ("demands m3 e omega^2: {}, {} and {} N, {} to {} times more",
     lambda n: (*amplitudes(n, "eq211", "{:.3f}"), *ratios(n)[1:])),
    ("frequency with m1 + m3 is {} Hz", lambda n: [f"{n['facts']['free_hz_II']:.3f}"]),
    ("in Case I it is {} Hz", lambda n: [f"{n['facts']['free_hz_I']:.3f}"]),
    ("{} Hz in Case I, {} Hz in Case II",
     lambda n: [f"{n['facts'][f'bilinear_hz_{kind}']:.2f}" for kind in ("I", "II")]),
    (
        "(printed cases: {} to {} mm)",
        lambda n: [
            f"{1e3 * pick(run(n, name)['rest_distance_needed'] for name in (*PRINTED, *MOTORS)):.3g}"
            for pick in (min, max)
        ],
    ),
    (
        "II-B is held at {} Hz for {} s, then runs up to {} Hz, II-C passes to {} Hz; of {} "
        "perturbed starts each, {} "
        "and {} are captured",
        lambda n: (
            f"{run(n, 'II-B')['capture']['speed_hz']:.2f}",
            f"{run(n, 'II-B')['capture']['until'] - run(n, 'II-B')['capture']['since']:.0f}",
            final(n, "II-B"),
            final(n, "II-C"),
            starts_of(n),
            *(captured_from(n["ensembles"][name]["outcomes"]) for name in ("II-B", "II-C")),
        ),
    ),
    ("II-C is held from {} to {} s", escape_times),
    ("and ends at {} Hz. By itself", lambda n: [final(n, "II-C-escape")]),
    (
        "end at a no-load speed of {} Hz as printed, {} with the c and {} with the J of the two "
        "cases alone, {} with "
        "both",
        lambda n: [
            f"{n['ends'][name]['no_load_hz']:.3f}"
            for name in ("as printed", "c alone", "J alone", "the reading")
        ],
    ),
    (
        "({} Hz at {} Hz)",
        lambda n: (
            f"{run(n, 'II-B')['held']['lines'][0]['hz']:.2f}",
            f"{run(n, 'II-B')['capture']['speed_hz']:.2f}",
        ),
    ),
    ("Without the stop both motors are captured, at {} and {} Hz",
     lambda n: [f"{n['without_stop'][name]['capture']['speed_hz']:.2f}" for name in ("II-B", "II-C")]),
    ("Of {} gaps from {} to {} mm, those from {} mm on hold II-B at 4.0 Hz", gaps),
    ("are periodic, with periods {}, {} and {}",
     lambda n: [run(n, name)["regime"]["period"] for name in PRINTED]),
    ("most of {} starts are chaotic at {}, {} and {} Hz",
     lambda n: [len(n["nearby"][0]["starts"]), *chaotic_hz(n)]),
    ("in each of the {} turns of its second half; from {} of {} perturbed starts it does",
     lambda n: (sum(run(n, "II-C")["cycles"]["impact_counts"].values()), *how_many(n, "II-C", one_impact))),
    (
        "as the paper says: {}, {} and {} mm in 300 s as printed, {}, {} and {} mm with equal forces",
        lambda n: [
            *(f"{abs(end_mm(n, name)):.1f}" for name in PRINTED),
            *(f"{abs(end_mm(n, name)):.0f}" for name in EQUAL_FORCE),
        ],
    ),
    ("than II-C: {} against {} mm", lambda n: [f"{abs(end_mm(n, name)):.0f}" for name in ("II-B", "II-C")]),
    ("faster than I in {}, {} and {} % of the pairs", lambda n: percents(n, PAIRS, "drift")),
    ("and in {}, {} and {} % over the whole run", lambda n: percents(n, PAIRS, "overall")),
    ("II-B is faster than II-C in {} % of them", lambda n: percents(n, [("II-B", "II-C")], "drift")),
    ('peaks at {} s from rest, and "around 170 s" from {} of {} starts',
     lambda n: (f"{run(n, 'II-C')['peak']['time']:.0f}", *how_many(n, "II-C", peaks_late))),
    (
        "cases of 5 it is {} % and {} of {}, but then II-B is faster than I-B in {} % of the "
        "pairs, II-C than I-C in {} %",
        lambda n: (
            *percents(n, [SHIPPED_READINGS], "drift"),
            *how_many(n, "II-C-escape", peaks_late),
            *percents(n, zip(SHIPPED_READINGS, PRINTED[1:], strict=True), "drift"),
        ),
    ),
    ("here it is {} Hz from rest, {} to {} Hz from perturbed starts",
     lambda n: (final(n, "II-C"), *finals(n, "II-C"))),
    (
        "II-A comes to {} to {} Hz and II-C to {} to {} Hz from all perturbed starts that settle, "
        "but II-B to {} to {} Hz",
        lambda n: (*finals(n, "II-A"), *finals(n, "II-C"), *finals(n, "II-B")),
    ),
    ("the amplitude grows by {} % as printed and by {} % in the reading, the speed by {} and {} %",
     lambda n: (*growth(n, "amplitude", "{:.0f}"), *growth(n, "speed_hz", "{:.1f}"))),
    (
        "M0 / Omega0 is {}, {} and {} mN m s at 3.5, 5.5 and 6.5 Hz, so these are three motors. "
        "With M0 in proportion ({} "
        "and {} mN m) II-B and II-C are captured from {} and {} of {} starts",
        slopes,
    ),
)  # fmt: skip

# what is given and not measured: places in the paper, names, the paper's own numbers and those of the cases
GIVEN = (
    r"!\[[^\]]*\]\([^)]*\)",
    r"2 f1 f2/\(f1 \+ f2\)",
    r"J and c of the two cases of 5",
    r'"[^"]*"',
    r"`[^`]*`",
    r"\]\([^)]*\)",
    r"Eqs?\. \([\d.]+\)",
    r"Table 1",
    r"Fig\. \d+",
    r"\bI{1,2}-[ABC][-\w]*",
    r"\b[mxfkev][123]\b",
    r"\bM0\b",
    r"\bOmega0\b",
    r"m3 e omega\^2",
    r"m/s\^2",
    r"sgn\(0\)",
    r"g and no solver; 300 s, rest, 9\.81",
    r"for some 80 s of the 300",
    r"block 2",
    r"4\.1 Hz is said",
    r"for good or for 100 s",
    r"how many of 25 starts",
    r"up to 1 mm to either side",
    r"0\.1 for each factor of 10",
    r"the 4\.1 Hz below",
    r"passes 4\.5 Hz after 124 s",
    r"4\.5 Hz after 85 s",
    r"the paper's 100 s",
    r"15 times",
    r"5\.5 Hz can just be held then, that of 6\.5 Hz",
    r"near 3\.7 Hz, not 4\.1",
    r"for 3000 s",
    r"chaotic for 300 s",
    r"At 6\.5 Hz",
    r"3\.5, 5\.5 and 6\.5 Hz",
    r"\(6\.5 Hz\)",
)


def rows_of(n):
    """The rows of the table of readings, as they stand on the page."""
    ranking = sorted(n["search"]["readings"]["ranking"], key=price_of)
    return "".join(f"   | {_row(row)} |\n" for row in ranking)


def _row(row):
    against = any(key in row["changes"] for key in ("excitation.m3", "excitation.e"))
    changed = f"{named(row['changes']) or 'nothing'}{' (against Table 1)' if against else ''}"
    counts = [str(share["count"]) for share in row["statements"][:-1]]
    return " | ".join([changed, *counts, f"{price_of(row):.2f}"])


TABLE = re.compile(r"(   \| changed \|.*\n   \|[-|]+\|\n)((?:   \|.*\|\n)+)")


def pattern_of(phrase):
    """A phrase with its numbers as groups, broken into lines anywhere."""
    words = [re.escape(word).replace(r"\{\}", NUMBER) for word in phrase.split()]
    return re.compile(r"\s+".join(words))


def rewritten(page, n):
    """The page with the numbers of the table; AssertionError where a phrase is not there once."""
    for phrase, numbers in PHRASES:
        (match,) = list(pattern_of(phrase).finditer(page)) or [None]
        assert match, f"docs/paper.md: not there: {phrase}"
        values = [str(value) for value in numbers(n)]
        assert len(values) == len(match.groups()), phrase
        ends = [match.start(), *(edge for i in range(len(values)) for edge in match.span(i + 1)), match.end()]
        kept = [page[a:b] for a, b in list(pairwise(ends))[::2]]
        text = "".join(part + value for part, value in zip(kept, [*values, ""], strict=True))
        page = page[: match.start()] + text + page[match.end() :]
    return TABLE.sub(lambda match: match[1] + rows_of(n), page, count=1)


def numbers_left(page):
    """Numbers of the page that are neither given nor in a phrase, with some words around them."""
    page = re.sub(r"(?m)^\d+\. \*\*", "", TABLE.sub("", page))  # the numbers of the list
    for phrase, _ in PHRASES:
        page = pattern_of(phrase).sub(" ", page)
    page = re.sub(r"\s+", " ", page)
    for given in GIVEN:
        page = re.sub(given, " ", page)
    return [page[max(match.start() - 30, 0) : match.end() + 20] for match in re.finditer(r"\d[\d.]*", page)]


def main(path):
    """Store the numbers of a report, and write them into the page."""
    sections = json.loads(Path(path).read_text(encoding="utf-8"))
    n = rounded(table_of({name: section["numbers"] for name, section in sections.items()}))
    del n["search"]["plane"], n["solvers"]  # drawn and told, not judged
    STORED.write_text(json.dumps(n, separators=(",", ":"), ensure_ascii=False) + "\n", encoding="utf-8")
    PAGE.write_text(rewritten(PAGE.read_text(encoding="utf-8"), n), encoding="utf-8")
    print(Counter(verdict.word for _, finding in judge_claims(n) for verdict in finding.verdicts))


if __name__ == "__main__":
    main(sys.argv[1])
