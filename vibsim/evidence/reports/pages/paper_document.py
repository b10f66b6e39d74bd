"""The report on the paper: what it says, in which order, from the numbers and the figures."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Mapping, Sequence

from vibsim import __version__
from vibsim.evidence.reports.claims.claim import EXAMPLE, VERDICTS, Numbers, Verdict
from vibsim.evidence.reports.claims.claims import judge_claims, trust_of
from vibsim.evidence.reports.load_curves import ends_table, load_words
from vibsim.evidence.reports.measured.ensembles import EACH_WAY, STEP
from vibsim.evidence.reports.pages.assumptions import assumption_blocks, unjudged_blocks
from vibsim.evidence.reports.pages.document import (
    FROM_REST,
    FROM_STARTS,
    Block,
    Document,
    Judged,
    Paragraph,
    Picture,
    Section,
    Table,
)
from vibsim.evidence.reports.pages.run_tables import facts_table, regime_table
from vibsim.evidence.reports.pages.search_tables import (
    captured_by,
    capturing_solvers,
    ensemble_table,
    readings_table,
    solver_table,
)

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
    "those here are ours. Figs. 1 and 3 are sketches of the models and not drawn again. Case I is shown "
    "with both amplitudes, that of Table 1 and that of Eq. (2.11). The motions are those from rest, exactly; "
    "each caption says how they were had. Figures marked as readings use a J and c under which the "
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
    "Which other numbers would make the account hold? Readings are ranked by price: the mean shortfall of "
    "the statements over all starts, and 0.1 for each factor of 10 by which a number is changed (vibsim "
    "fit), or for taking the stop away. Each was run from rest and from 24 starts, x1 up to 1 mm to either "
    "side and the rotor anywhere; a statement holds where it does from four of five. Table 1 has the "
    "amplitudes m3 e ω: a reading that changes m3 or e contradicts it."
)
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
    sections = (
        Section("assumptions", "Assumptions first", assumption_blocks(numbers)),
        Section("summary", "At a glance", _summary(judged)),
        Section("claims", "Claim by claim", tuple(judged)),
        Section("unjudged", "Words that are not judged", unjudged_blocks(numbers)),
        Section("why", "What makes the account of the motors hold", _search(numbers, judged, audit)),
        Section("runs", "The runs", (regime_table(numbers), facts_table(numbers))),
        Section("figures", "The figures", (Paragraph(FIGURES), *pictures)),
    )
    provenance = (("Made by", f"vibsim {__version__}, vibsim paper"), ("Cases", ", ".join(numbers["runs"])))
    return Document("The paper, reproduced and audited", f"{PAPER} {SUBTITLE}", sections, provenance)


def _judged(numbers: Numbers, pictures: Sequence[Picture], audit: Mapping[str, Picture]) -> list[Judged]:
    """Every claim with its finding and what shows it; a picture stands with the first claim it decides."""
    headings = {picture.path.stem: picture.heading for picture in (*pictures, *audit.values())}
    shown: set[str] = set()
    judged = []
    for number, (claim, finding) in enumerate(judge_claims(numbers), start=1):
        here = tuple(name for name in claim.pictures if name in audit and name not in shown)
        elsewhere = [key for key in (*claim.figures, *claim.pictures) if key in headings and key not in here]
        links = tuple((key, headings[key]) for key in elsewhere)
        own = tuple(audit[name] for name in here)
        judged.append(Judged(number, claim, finding, trust_of(numbers, finding), links, own))
        shown.update(here)
    return judged


def _summary(judged: Sequence[Judged]) -> tuple[Block, ...]:
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
        Table(
            "Claims, in our words, and verdicts",
            ("Claim", "Paper", FROM_REST, FROM_STARTS),
            rows,
            verdicts=(2, 3),
        ),
    )


def _counted(verdicts: Iterable[Verdict | None]) -> str:
    """How many verdicts there are of each kind, in words."""
    count = Counter(verdict.word for verdict in verdicts if verdict is not None)
    return ", ".join(f"{count[word]} × {word}" for word in VERDICTS if count[word])


def _search(numbers: Numbers, judged: Sequence[Judged], audit: Mapping[str, Picture]) -> tuple[Block, ...]:
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
