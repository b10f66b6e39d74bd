"""The report on the paper: what it says, in which order, from the numbers and the figures."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping, Sequence

from vibsim import __version__
from vibsim.reports.claim import ONLY_IF, VERDICTS, Numbers
from vibsim.reports.claims import judge_claims, trust_of
from vibsim.reports.document import Block, Document, Judged, Paragraph, Picture, Section, Table
from vibsim.reports.ensembles import EACH_WAY, STEP
from vibsim.reports.run_tables import facts_table, regime_table
from vibsim.reports.search_tables import capturing_solvers, ensemble_table, search_table, solver_table

PAPER = (
    "Moraes, Pontes, Silveira, Balthazar, Brasil: Influence of ideal and non-ideal excitation sources on the "
    "dynamics of a nonlinear vibro-impact system (2013)."
)
SUBTITLE = "Every figure drawn again from its cases, every claim held against what was measured."

FIGURES = (
    "Laid out as in the paper; Figs. 1 and 3 are sketches of the models. Case I is shown with both "
    "amplitudes, that of Table 1 and that of Eq. (2.11). Beyond a trust horizon (hatched) the motion is "
    "one of many that the model allows. Figures marked as readings use an m3 and c under which the paper's "
    "account of them holds."
)
MECHANISM = (
    "Two things are needed at once. The motor must not get away while the vibration is still small: a "
    "larger unbalance m3 e, more losses or less torque see to that. And the power that the vibration takes "
    "up must be lost again at an amplitude that still holds the rotor. Where that is so, the motor stays; "
    "where it is not, the vibration grows until it throws the rotor round. m3 and c together decide which "
    "of the two happens, and they can be such that a 5.5 Hz motor stays and a 6.5 Hz motor leaves."
)
FURTHEST, APART = f"{1e3 * EACH_WAY * STEP:g} mm", f"{1e3 * STEP:g} mm"
STARTS = (
    "Does it survive perturbed starts? Block 1 was displaced at the start by up to "
    f"{FURTHEST} to either side, in steps of {APART}."
)
SOLVERS = (
    "Could it have come from the solver? The same equations with sgn(v2), no events and the printed "
    "parameters, by methods in common use. What a method loses by its own errors acts like damping."
)


def paper_document(numbers: Numbers, pictures: Sequence[Picture], audit: Mapping[str, Picture]) -> Document:
    """The document.

    pictures : the figures of the paper; audit : those of the audit, "search" and "growth"
    """
    judged = [
        Judged(number, claim, finding, trust_of(numbers, finding))
        for number, (claim, finding) in enumerate(judge_claims(numbers), start=1)
    ]
    sections = (
        Section("summary", "At a glance", _summary(judged)),
        Section("claims", "Claim by claim", tuple(judged)),
        Section("why", "What makes the account of the motors hold", _search(numbers, judged, audit)),
        Section("runs", "The runs", (regime_table(numbers), facts_table(numbers))),
        Section("figures", "The figures", (Paragraph(FIGURES), *pictures)),
    )
    provenance = (("Made by", f"vibsim {__version__}, vibsim paper"), ("Cases", ", ".join(numbers["runs"])))
    return Document("The paper, reproduced and audited", f"{PAPER} {SUBTITLE}", sections, provenance)


def _summary(judged: Sequence[Judged]) -> tuple[Block, ...]:
    count = Counter(each.finding.verdict for each in judged)
    words = ", ".join(f"{count[verdict]} × {verdict}" for verdict in VERDICTS if count[verdict])
    rows = tuple((f"{each.number}. {each.claim.statement}", each.finding.verdict) for each in judged)
    basis = "Each verdict follows from the numbers in numbers.json, by the criterion given with it."
    return (
        Paragraph(f"{len(judged)} claims: {words}. {basis}"),
        Table("Claims and verdicts", ("Claim", "Verdict"), rows, verdict=1),
    )


def _search(numbers: Numbers, judged: Sequence[Judged], audit: Mapping[str, Picture]) -> tuple[Block, ...]:
    outcomes = {name: numbers["runs"][name]["capture"]["verdict"] for name in ("II-B", "II-C")}
    printed = " and ".join(f"the motor of {name} is judged “{verdict}”" for name, verdict in outcomes.items())
    verdicts = {each.claim.key: each.finding.verdict for each in judged}
    conditional = all(verdicts[key] == ONLY_IF for key in ("II-B-captured", "II-C-escapes"))
    why = (Paragraph(MECHANISM),) if conditional else ()
    return (
        Paragraph(f"As printed, {printed}. Each parameter was varied alone, and both cases run for 300 s."),
        search_table(numbers["search"]["alone"]),
        *why,
        audit["search"],
        audit["growth"],
        Paragraph(STARTS),
        ensemble_table(numbers["ensembles"]),
        Paragraph(f"{SOLVERS} {capturing_solvers(numbers['solvers'])}"),
        solver_table(numbers["solvers"]),
    )
