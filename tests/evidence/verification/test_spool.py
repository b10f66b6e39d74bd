"""The stored truth of the spool is what a fresh run of 40 digits gives, by either method."""

from decimal import Decimal

import pytest

from vibsim.cases import load_case
from vibsim.engine.truth import open_truth
from vibsim.evidence.verification.catalogue import PERIOD, SPOOL, TRUTH
from vibsim.physics.parts import EVENT_NAMES


@pytest.mark.parametrize("method", ("auto", "taylor"))
def test_the_truth_of_the_second_period(method):
    case = load_case(SPOOL, {"run.t_end": "8 ms", "run.method": method})
    blocks = list(open_truth(case.exact_scene, 40).blocks())
    rows = [
        (EVENT_NAMES[kind], Decimal(text.decode()) - PERIOD)
        for block in blocks
        for kind, text in zip(block.events["kind"], block.event_digits["t"], strict=True)
    ]
    found = [(kind, t) for kind, t in rows if t > 0 and kind != "end"]
    assert [kind for kind, _ in found] == [kind for kind, _ in TRUTH]
    for (_, t), (_, stored) in zip(found, TRUTH, strict=True):
        assert abs(t - Decimal(stored)) <= Decimal("1e-24")
