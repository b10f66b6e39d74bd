"""What the paper leaves open and this report had to decide; and words of the paper that are not judged."""

from __future__ import annotations

from vibsim.evidence.reports.claims.claim import Numbers
from vibsim.evidence.reports.claims.evidence import MOST
from vibsim.evidence.reports.measured.ensembles import EACH_WAY, STEP
from vibsim.evidence.reports.measured.paper_runs import MOTORS, PRINTED
from vibsim.evidence.reports.pages.document import Block, Paragraph, Said, Table
from vibsim.evidence.reports.quotes import said
from vibsim.evidence.reports.wording import between, mm, percent

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
    "The paper does not say how a captured motor is told. Here it is held while its mean speed over 12 "
    "turns stays within ±3 %; a hold counts as capture from 15 times the time that the motor alone would "
    "take through that band. That scale is relative: a rotor with more inertia runs up more slowly, and "
    "must be held for longer to count. Through ±3 % about 3.69 Hz with a no-load speed of 6.5 Hz, the least "
    "hold that counts is {least}. A reading with a larger J can therefore do what the paper says in seconds "
    "and still be judged to have passed; so the claim on the escape looks at the seconds, for any hold that "
    "lingers."
)


def assumption_blocks(numbers: Numbers) -> tuple[Block, ...]:
    """The section that comes first: assumptions and criteria of ours."""
    count = 2 * EACH_WAY
    words = CHAOS.format(
        furthest=f"{1e3 * EACH_WAY * STEP:g}", count=count, step=f"{1e3 * STEP:g}", most=percent(MOST)
    )
    least = ", ".join(
        f"{seconds:.3g} s with J = {inertia} kg m²"
        for inertia, seconds in numbers["facts"]["least_hold_s"].items()
    )
    return (
        Table("What the paper leaves open", ("", "Paper", "Here", "Effect"), OPEN),
        Paragraph(words),
        Paragraph(CAPTURE.format(least=least)),
    )


def unjudged_blocks(numbers: Numbers) -> tuple[Block, ...]:
    """Words of the paper that state a condition, slip, or are a matter of opinion."""
    return (
        Said(said("validity"), _validity(numbers)),
        Said(
            said("smaller", "greater"),
            "A slip: the first says the opposite of the second, of Eqs. (2.1), (2.2) and (2.9), (2.10), and "
            "of Fig. 2. Here the equations stand: contact while x2 − x1 ≥ G. Eq. (2.5) itself carries no "
            "condition.",
        ),
        Said(
            said("two regions"),
            "So without friction. The sign of the velocity of block 2, and its rest, divide each region in "
            "three.",
        ),
        Said(
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
