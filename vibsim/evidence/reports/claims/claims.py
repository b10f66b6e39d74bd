"""All claims of the paper, and the findings on them."""

from __future__ import annotations

from vibsim.evidence.reports.claims.claim import Claim, Finding, Numbers
from vibsim.evidence.reports.claims.of_capture import capture_claims
from vibsim.evidence.reports.claims.of_drift import drift_claims
from vibsim.evidence.reports.claims.of_escape import escape_claims
from vibsim.evidence.reports.claims.of_impacts import impact_claims
from vibsim.evidence.reports.claims.of_models import models_claims
from vibsim.evidence.reports.claims.of_regimes import regime_claims


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
    """Until when the runs that a finding rests on are right, in words."""
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
