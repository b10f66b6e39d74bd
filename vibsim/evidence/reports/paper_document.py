"""The report on the paper: what it says, in which order, from the numbers and the figures."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from typing import Any

from vibsim import __version__
from vibsim.evidence.reports.claims import (
    EXAMPLE,
    MOST,
    VERDICTS,
    Claim,
    ClaimVerdict,
    Finding,
    Numbers,
    between,
    drift_rate,
    hz,
    mm,
    of_all,
    percent,
    said,
    seconds,
    typeset,
)
from vibsim.evidence.reports.measurements import EACH_WAY, MOTORS, PRINTED, SHIPPED_READINGS, STEP
from vibsim.evidence.reports.model_claims import models_claims, regime_claims
from vibsim.evidence.reports.motion_claims import drift_claims, impact_claims
from vibsim.evidence.reports.motor_claims import capture_claims, escape_claims
from vibsim.evidence.reports.pages import (
    FROM_REST,
    FROM_STARTS,
    Block,
    Document,
    JudgedClaim,
    PageSection,
    PageTable,
    Paragraph,
    Picture,
    QuotedWords,
)
from vibsim.evidence.reports.paper_figures import ends_table, load_words
from vibsim.evidence.reports.readings import NO_STOP, STATEMENTS, keeps_table_1
from vibsim.fitting.statements import LEAVE

PAPER = (
    "Fernando H. Moraes, Bento R. Pontes Jr, Marcos Silveira, José M. Balthazar, Reyolando M. L. R. F. "
    "Brasil: Influence of ideal and non-ideal excitation sources on the dynamics of a nonlinear "
    "vibro-impact system (received 31 October 2012, accepted 4 February 2013)."
)
SUBTITLE = (
    "Every figure drawn again from its cases, every statement quoted and held against what was measured. "
    "Words in quotation marks are the paper's; all others are ours."
)

FIGURES = (
    "Panels (a) and (b) as the captions of the paper have them; these give neither windows nor ranges, so "
    "those here are ours. Figs. 1 and 3, the sketches of the models, are drawn from the cases. Case I is "
    "shown with both amplitudes, that of Table 1 and that of Eq. (2.11). The motions are those from rest, "
    "exactly; each caption says how they were had. Figures marked as readings use a J and c under which the "
    "paper's account of them holds, but for the 4.1 Hz."
)
MECHANISM = (
    "Two things are needed at once. The motor must not get away while the vibration is still small: a "
    "heavier rotor, a larger unbalance m3 e, more losses or less torque see to that. And the power that the "
    "vibration takes up must be lost again at an amplitude that still holds the rotor. Where that is so, the "
    "motor stays; where it is not, the vibration grows until it throws the rotor round. J and c together "
    "decide which of the two happens, and they can be such that a 5.5 Hz motor stays and a 6.5 Hz motor "
    "leaves."
)
READ = (
    "Which other numbers would make the account hold? Readings are ranked by penalty: the mean shortfall of "
    "the statements over all starts, and 0.1 for each factor of 10 by which a number is changed (vibsim "
    "fit), or for taking the stop away. Each was run from rest and from 24 starts, x1 up to 1 mm to either "
    "side and the rotor anywhere; a statement holds where it does from four of five. Table 1 has the "
    "amplitudes m3 e ω: a reading that changes m3 or e contradicts it."
)
FURTHER_FIGURES = ("sommerfeld", "powers")  # of ours, behind those of the paper
FURTHEST, APART = f"{1e3 * EACH_WAY * STEP:g} mm", f"{1e3 * STEP:g} mm"
STARTS = (
    "Does it survive perturbed starts? Block 1 was displaced at the start by up to "
    f"{FURTHEST} to either side, in steps of {APART}."
)
SOLVERS = (
    "Could it have come from the solver? The same equations with sgn(v2), no events and the printed "
    "parameters, by methods in common use. What a method loses by its own errors acts like damping; how "
    "much that is hangs on its step control, so that another implementation of the same method may end "
    "elsewhere."
)


def paper_document(numbers: Numbers, pictures: Sequence[Picture], audit: Mapping[str, Picture]) -> Document:
    """The document.

    pictures : the figures of the paper; audit : those of the audit by name
    """
    judged = _judged(numbers, pictures, audit)
    further = tuple(audit[name] for name in FURTHER_FIGURES if name in audit)
    sections = (
        PageSection("figures", "The figures", (Paragraph(FIGURES), *pictures, *further)),
        PageSection("assumptions", "Assumptions first", assumption_blocks(numbers)),
        PageSection("summary", "At a glance", _summary(judged)),
        PageSection("claims", "Claim by claim", tuple(judged)),
        PageSection("unjudged", "Words that are not judged", unjudged_blocks(numbers)),
        PageSection("why", "What makes the account of the motors hold", _search(numbers, judged, audit)),
        PageSection("runs", "The runs", (regime_table(numbers), facts_table(numbers))),
    )
    provenance = (("Made by", f"vibsim {__version__}, vibsim paper"), ("Cases", ", ".join(numbers["runs"])))
    return Document("The paper, reproduced and audited", f"{PAPER} {SUBTITLE}", sections, provenance)


def _judged(numbers: Numbers, pictures: Sequence[Picture], audit: Mapping[str, Picture]) -> list[JudgedClaim]:
    """Every claim with its finding and what shows it; a picture stands with the first claim it decides."""
    headings = {picture.path.stem: picture.heading for picture in (*pictures, *audit.values())}
    shown: set[str] = set()
    judged = []
    for number, (claim, finding) in enumerate(judge_claims(numbers), start=1):
        here = tuple(name for name in claim.pictures if name in audit and name not in shown)
        elsewhere = [key for key in (*claim.figures, *claim.pictures) if key in headings and key not in here]
        links = tuple((key, headings[key]) for key in elsewhere)
        own = tuple(audit[name] for name in here)
        judged.append(JudgedClaim(number, claim, finding, trust_of(numbers, finding), links, own))
        shown.update(here)
    return judged


def _summary(judged: Sequence[JudgedClaim]) -> tuple[Block, ...]:
    findings = [each.finding for each in judged]
    alone = [finding.rest for finding in findings if finding.starts is None]
    both = [finding for finding in findings if finding.starts is not None]
    rest = _counted(finding.rest for finding in both)
    starts = _counted(finding.starts for finding in both)
    rows = tuple(
        (
            f"{each.number}. {each.claim.statement}",
            each.claim.quotes[0].place.replace("Section ", "§ "),
            each.finding.rest.word,
            "" if each.finding.starts is None else each.finding.starts.word,
        )
        for each in judged
    )
    words = (
        f"{len(judged)} claims. {len(both)} of them are about motions and have two verdicts. On the motions "
        f"from rest, which are known exactly: {rest}. Over {2 * EACH_WAY} perturbed starts: {starts}. No "
        f"start enters into the other {len(alone)}: {_counted(alone)}. Each verdict follows from the numbers "
        "in numbers.json, by the criterion given with it."
    )
    return (
        Paragraph(words),
        PageTable(
            "Claims, in our words, and verdicts",
            ("Claim", "Paper", FROM_REST, FROM_STARTS),
            rows,
            verdicts=(2, 3),
        ),
    )


def _counted(verdicts: Iterable[ClaimVerdict | None]) -> str:
    """Numbers of verdicts of each kind, in words."""
    count = Counter(verdict.word for verdict in verdicts if verdict is not None)
    return ", ".join(f"{count[word]} × {word}" for word in VERDICTS if count[word])


def _search(
    numbers: Numbers, judged: Sequence[JudgedClaim], audit: Mapping[str, Picture]
) -> tuple[Block, ...]:
    outcomes = {name: numbers["runs"][name]["capture"]["verdict"] for name in ("II-B", "II-C")}
    printed = ", ".join(f"{name}: {verdict}" for name, verdict in outcomes.items())
    verdicts = {each.claim.key: each.finding.rest.word for each in judged}
    conditional = all(verdicts[key] == EXAMPLE for key in ("II-B-captured", "II-C-escapes"))
    why = (Paragraph(MECHANISM),) if conditional else ()
    return (
        Paragraph(f"Verdicts on the motors as printed: {printed}. {READ}"),
        readings_table(numbers["search"]["readings"]["ranking"]),
        Paragraph(captured_by(numbers["search"]["readings"]["ranking"])),
        *why,
        Paragraph(load_words(numbers["ends"])),
        audit["load-curves"],
        ends_table(numbers["ends"]),
        audit["search"],
        audit["growth"],
        Paragraph(STARTS),
        ensemble_table(numbers["ensembles"]),
        Paragraph(f"{SOLVERS} {capturing_solvers(numbers['solvers'])}"),
        solver_table(numbers["solvers"]),
    )


# All claims of the paper, and the findings on them.


def paper_claims() -> list[Claim]:
    """Every claim, in the order of the report."""
    return [
        *models_claims(),
        *regime_claims(),
        *impact_claims(),
        *drift_claims(),
        *capture_claims(),
        *escape_claims(),
    ]


def judge_claims(numbers: Numbers) -> list[tuple[Claim, Finding]]:
    """Each claim with the finding that the numbers lead to; nothing else is looked at."""
    return [(claim, claim.judge(numbers)) for claim in paper_claims()]


def trust_of(numbers: Numbers, finding: Finding) -> str:
    """Trust horizons of the runs that a finding rests on, in words."""
    if not finding.runs:
        return finding.basis or "exact: from the numbers of the cases"
    to_the_end, until = [], []
    for name in finding.runs:
        run = numbers["runs"][name]
        horizon = run["trust_horizon"]
        if horizon is not None and horizon >= run["t_end"]:
            to_the_end.append(name)
        else:
            until.append(f"{name} until {horizon:.4g} s" if horizon is not None else f"{name}: not known")
    parts = [f"{', '.join(to_the_end)}: right over the whole run"] if to_the_end else []
    parts = [finding.basis, *parts] if finding.basis else parts
    return "; ".join([*parts, *until]) + (" (beyond it, statistics and ensembles only)" if until else "")


# What the paper leaves open and this report had to decide; and words of the paper that are not judged.


OPEN = (
    ("Duration", "not stated; about 100 s and around 170 s are mentioned", "300 s",
     "second halves are 150 to 300 s; rates over the whole run depend on it"),
    ("Start", "not stated", "at rest, rotor at φ = 0; the ideal force sets in at full size at t = 0",
     "perturbed starts show how much depends on it"),
    ("Gravity", "the symbol g in Eq. (2.7), no value", "9.81 m/s²", "enters as μ m2 g alone"),
    ("Solver, step, tolerance", "not stated", "events located, error at rounding level",
     "coarse solvers can end elsewhere: see the table of solvers"),
    ("Friction at rest", "sgn(0) of Eq. (2.7) is open", "set-valued Coulomb law (Filippov)",
     "block 2 can stick"),
    ("Unit of A", "Table 1 prints m", "N", "A is a force in Eq. (2.3)"),
    ("Figures", "captions give no windows and no ranges", "whole runs, and the last periods",
     "ours, and automatic"),
)  # fmt: skip

CHAOS = (
    "The motions from rest are known to their end. I-A, I-B and I-C are right in double precision; the "
    "others are run with as many decimal digits as leave ten right ones at 300 s, and made again from states "
    "of those runs. A motion from rest is one of many that the model allows, and the paper states no start. "
    "So each claim has a second verdict, over an ensemble: block 1 displaced at the start by up to "
    "{furthest} mm to either side, {count} starts in steps of {step} mm. A property of the system is what "
    "{most} of them have: four in five. This rule is ours."
)
CAPTURE = (
    "The paper does not say how a captured motor is recognised. Here it is held while its mean speed over 12 "
    "turns stays within ±3 %; a hold counts as capture from 15 times the time that the motor alone would "
    "take through that band. That scale is relative: a rotor with more inertia runs up more slowly, and "
    "must be held for longer to count. Through ±3 % about 3.69 Hz with a no-load speed of 6.5 Hz, the least "
    "hold that counts is {least}. A reading with a larger J can therefore do what the paper says in seconds "
    "and still be judged to have passed; so the claim on the escape looks at the seconds, for any hold that "
    "lingers."
)


def assumption_blocks(numbers: Numbers) -> tuple[Block, ...]:
    """The section behind the figures: assumptions and criteria of ours."""
    count = 2 * EACH_WAY
    words = CHAOS.format(
        furthest=f"{1e3 * EACH_WAY * STEP:g}", count=count, step=f"{1e3 * STEP:g}", most=percent(MOST)
    )
    least = ", ".join(
        f"{seconds:.3g} s with J = {inertia} kg m²"
        for inertia, seconds in numbers["facts"]["least_hold_s"].items()
    )
    return (
        PageTable("What the paper leaves open", ("", "Paper", "Here", "Effect"), OPEN),
        Paragraph(words),
        Paragraph(CAPTURE.format(least=least)),
    )


def unjudged_blocks(numbers: Numbers) -> tuple[Block, ...]:
    """Words of the paper that state a condition, slip, or are a matter of opinion."""
    return (
        QuotedWords(said("validity"), _validity(numbers)),
        QuotedWords(
            said("smaller", "greater"),
            "A slip: the first says the opposite of the second, of Eqs. (2.1), (2.2) and (2.9), (2.10), and "
            "of Fig. 2. Here the equations stand: contact while x2 − x1 ≥ G. Eq. (2.5) itself carries no "
            "condition.",
        ),
        QuotedWords(
            said("two regions"),
            "So without friction. The sign of the velocity of block 2, and its rest, divide each region in "
            "three.",
        ),
        QuotedWords(
            said("complete", "importance", "helped"),
            "Opinions on the value of the models; not for measurement. That the comparison is of unequal "
            "forces is said under its claim.",
        ),
    )


def _validity(numbers: Numbers) -> str:
    """The condition, and the rest distances that the runs need."""
    needed = [numbers["runs"][name]["rest_distance_needed"] for name in (*PRINTED, *MOTORS)]
    condition = (
        "A condition of the model, not a claim that the motions shown meet it; the distance of the blocks "
        "at rest is not given. "
    )
    if None in needed:
        return condition + "How far apart they must be is not known for every run."
    span = between(1e3 * min(needed), 1e3 * max(needed), "mm")
    return (
        f"{condition}The printed cases meet it if the blocks are {span} apart at rest, {mm(max(needed))} "
        "for all of them; with displacements counted as positions, every run breaks it."
    )


# Tables of the runs: regimes, and what was measured.


def regime_table(numbers: Numbers) -> PageTable:
    """The regime of each run in the paper's span, and the one that the motion settles in."""
    columns = ("Run", "150 to 300 s", "1500 to 3000 s")
    rows = tuple(
        (name, _regime(run["regime"]), _regime(numbers["long_runs"][name]["regime"]))
        for name, run in numbers["runs"].items()
    )
    return PageTable(
        "Regime in cycles of the source, with its evidence; the largest Lyapunov exponent", columns, rows
    )


def _regime(regime: dict[str, Any]) -> str:
    period = f", period {regime['period']}" if regime["period"] else ""
    exponent = regime["exponent"]
    known = f"; exponent {exponent['value']:.2g} ± {exponent['half_width']:.1g} 1/s" if exponent else ""
    return f"{regime['verdict']}{period}: {regime['reason']}{known}"


def facts_table(numbers: Numbers) -> PageTable:
    """Table of the measurements of each run."""
    columns = (
        "Run", "Right until", "Impacts", "Sticks", "Impacts per cycle", "Drift of block 2",
        "Strongest line of x1 − x2", "Rest distance needed", "How it is known",
    )  # fmt: skip
    rows = tuple((name, *_facts(run)) for name, run in numbers["runs"].items())
    return PageTable("Measured in the second half of each run; counts over all of it", columns, rows)


def _facts(run: Numbers) -> tuple[str, ...]:
    cycles, lines, horizon = run["cycles"], run["frequencies"]["lines"], run["trust_horizon"]
    per_cycle = "" if cycles["impacts"] is None else f"{cycles['impacts']:.3g} ({cycles['verdict']})"
    return (
        "unknown" if horizon is None else "the end" if horizon >= run["t_end"] else f"{horizon:.4g} s",
        str(run["impacts"]),
        str(run["sticks"]),
        per_cycle,
        drift_rate(run["drift"]),
        f"{hz(lines[0]['hz'])}, {mm(lines[0]['amplitude'])}" if lines else "none",
        mm(run["rest_distance_needed"]),
        run["how"] or "a run in double precision",
    )


# Tables of the search: readings ranked, ensembles of starts, solvers.
#
# A stop that is out of reach is no stop, and its gap says nothing: taking it away costs as much as a factor
# of 10.


RESONANT_HZ = 4.5  # a hold below this is one near half the bilinear frequency
KINDS = ("captured", "escaped", "passed", "not met", "undecided")


def readings_table(ranking: Sequence[Numbers]) -> PageTable:
    """Every reading: what it changes, from how many starts each statement then holds, and its penalty."""
    heads = ("Changed", "Table 1", *(statement.head for statement in STATEMENTS), "Hold", "Penalty")
    return PageTable(
        "Readings of the printed numbers, the least penalty first",
        heads,
        tuple(_reading(row) for row in sorted(ranking, key=price_of)),
    )


def _reading(row: Numbers) -> tuple[str, ...]:
    changes = row["changes"]
    counts = (f"{share['count']}/{share['of']}" for share in row["statements"])
    explained = f"{row['explained']}/{len(row['statements'])}"
    table_1 = "kept" if keeps_table_1(changes) else "contradicted"
    return named(changes) or "nothing, as printed", table_1, *counts, explained, f"{price_of(row):.2f}"


def named(changes: Mapping[str, str]) -> str:
    """Changes in words: "J = 0.01 kg m², c = 0.003 N s/m"."""
    return ", ".join(_named(key, text) for key, text in changes.items())


def _named(key: str, text: str) -> str:
    return "no stop" if {key: text} == NO_STOP else typeset(f"{key.rpartition('.')[2]} = {text}")


def price_of(row: Numbers) -> float:
    """The penalty of a reading."""
    price: float = row["price"]
    return price - row["leaving"] + LEAVE if row["changes"] == NO_STOP else price


def captured_by(ranking: Sequence[Numbers]) -> str:
    """Sentence on the single changes that capture II-B for good."""
    alone = [row for row in ranking if len(row["changes"]) == 1 and row["statements"][0]["holds"]]
    names = sorted(named(row["changes"]) for row in alone)
    return f"Of single changes, {', '.join(names) or 'none tried'} capture II-B for good."


def ensemble_table(ensembles: Mapping[str, Any]) -> PageTable:
    """Verdicts, holds and final speeds of the perturbed starts."""
    motors = {
        name: each["outcomes"] for name, each in ensembles.items() if name in (*MOTORS, *SHIPPED_READINGS)
    }
    rows = tuple((name, *_ensemble(outcomes)) for name, outcomes in motors.items())
    columns = (
        "Case", "Captured", "Escaped", "Passed", "Not met", "Undecided", "Held until",
        "Final speed: median, range",
    )  # fmt: skip
    return PageTable("Perturbed starts of the motors", columns, rows)


def _ensemble(outcomes: Sequence[Numbers]) -> tuple[str, ...]:
    counts = [sum(each.get("verdict") == kind for each in outcomes) for kind in KINDS]
    ends = [each["until"] for each in outcomes if each.get("until") is not None]
    finals = sorted(each["final_hz"] for each in outcomes if each.get("final_hz") is not None)
    middle = finals[len(finals) // 2] if finals else None
    return (
        *(of_all(count, len(outcomes)) for count in counts),
        between(min(ends), max(ends), "s") if ends else "",
        f"{hz(middle)}, {between(finals[0], finals[-1], 'Hz')}" if finals else "none",
    )


def solver_table(rows: Sequence[Numbers]) -> PageTable:
    """Table of the results of each solver for II-B and II-C."""
    columns = ("Solver", "II-B", "II-C", "x2 of II-C at 300 s")
    outcomes = tuple(
        (row["solver"], _solved(row["II-B"]), _solved(row["II-C"]), _drifted(row["II-C"])) for row in rows
    )
    return PageTable("The printed parameters by solvers without events", columns, outcomes)


def capturing_solvers(rows: Sequence[Numbers]) -> str:
    """Sentences on which solvers capture which motor."""
    sentences = []
    for name in ("II-B", "II-C"):
        names = [row["solver"] for row in rows if is_captured(row[name])]
        sentences.append(f"{name} is captured for good by {' and '.join(names) or 'none of them'}.")
    return " ".join(sentences)


def is_captured(outcome: Numbers) -> bool:
    """Whether a run ends captured near half the bilinear frequency."""
    return outcome.get("verdict") == "captured" and outcome["speed_hz"] < RESONANT_HZ


def _solved(outcome: Numbers) -> str:
    if "failed" in outcome:
        return str(outcome["failed"])
    held = ""
    if outcome["since"] is not None:
        until = "the end" if outcome["until"] is None else seconds(outcome["until"])
        held = f", held at {hz(outcome['speed_hz'])} until {until}"
    return f"{outcome['verdict']}{held}; final speed {hz(outcome['final_hz'])}"


def _drifted(outcome: Numbers) -> str:
    return "" if "failed" in outcome else f"{outcome['drifted']:.3g} m"
