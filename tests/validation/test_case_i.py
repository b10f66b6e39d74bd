"""V1: Case I over 300 s against 40- and 60-digit Taylor integrations, equal in all digits shown."""

import pytest

from tests.scenes import paper
from tests.trajectories import run

# x1 [m], x2 [m], v1 [m/s], v2 [m/s] at 300 s; impacts, sticks, events
PUBLISHED = {
    "I-A": (
        0.0049838576146675,
        0.0050150524787833,
        -0.0017985024624189,
        -0.00037796325802528,
        630,
        419,
        3780,
    ),
    "I-B": (-0.0208657036721520, -0.0233895811558076, 0.0056039388001598, -0.0015125299416625, 1466, 0, 6232),
    "I-C": (-0.0846686050797213, -0.0868864712155865, 0.0795244964939589, -0.0094857232508406, 1948, 0, 7794),
}
TOLERANCE = {"closed_form": 1e-11, "taylor": 1e-9}  # absolute, in m and m/s; by 60 digits


@pytest.mark.parametrize("method", TOLERANCE)
@pytest.mark.parametrize("name", PUBLISHED)
def test_state_and_events_at_300_s(name, method):
    *state, impacts, sticks, events = PUBLISHED[name]
    result = run(paper(name, t_end=300.0, method=method))
    got = [result.final(column) for column in ("x1", "x2", "v1", "v2")]
    assert got == pytest.approx(state, abs=TOLERANCE[method], rel=0)
    assert (result.totals["impacts"], result.totals["sticks"], result.totals["events"]) == (
        impacts,
        sticks,
        events,
    )
    assert result.totals["uncertified"] == 0
    assert len(result.samples["time"]) == 60001
