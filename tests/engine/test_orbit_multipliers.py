"""Floquet multipliers of periodic orbits of the paper's machine, against 16 digits of them from a Taylor code
in 60 digits that shares nothing with vibsim.
"""

from math import pi

import numpy as np
import pytest

from tests.scenes import paper
from vibsim.engine.tangent.monodromy import Carrier

# case, its changes; period [s]; y = x1 - x2, v1, v2 and phi' on the section; multipliers
ORBITS = {
    "I-C, one period": (
        "I-C",
        {},
        1 / 6.5,
        [0.00221591233416267523532846, 0.0795143535444696136309685, -0.00948483262611317310060900],
        [
            0.8486435858373631 - 0.5215168804985694j,
            0.8486435858373631 + 0.5215168804985694j,
            0.9303994608203476,
        ],
    ),
    "II-B captured at c = 0.03 N s/m": (
        "II-B",
        {"c": 0.03, "Omega0": 10 * pi},
        0.270774090699275292785594,
        [0.0510051736030986293, 0.467045664915594597, -0.0510059820589965368, 22.0065444916912567],
        [
            1.0,
            0.9883726784094159,
            0.8899776525368136 - 0.4215164486662168j,
            0.8899776525368136 + 0.4215164486662168j,
            0.9699636192328105,
        ],
    ),
    "II-B, the saddle beside it": (
        "II-B",
        {"c": 0.03, "Omega0": 10 * pi},
        0.271694636296761136249217,
        [0.00606853036322913163, 1.08387198971986805, -0.119909800332618670, 24.4654759973517533],
        [1.517679817697107, 1.0, 0.9884662578812469, 0.9704335598283750, 0.6385297838302939],
    ),
}


def without_shift(matrix, motor):
    """By (y, v1, v2, phi, w): a shift of both blocks is felt by no force."""
    taken = np.eye(len(matrix))[[0, 2, 3, *((4, 5) if motor else ())]]
    taken[0, 1] = -1.0
    put = np.eye(len(matrix))[:, [0, 2, 3, *((4, 5) if motor else ())]]
    return taken @ matrix @ put


@pytest.mark.parametrize("engine", ("c", "python"))
@pytest.mark.parametrize("label", ORBITS)
def test_multipliers(label, engine):
    name, changes, period, (y, v1, v2, *speed), multipliers = ORBITS[label]
    of = paper(name, **changes)
    rotor = [0.0, *speed] if speed else []
    carried = Carrier(of.as_parts(), engine).carry([y, 0.0, v1, v2, *rotor], period)
    x1, x2, *rest = carried.state
    np.testing.assert_allclose([x1 - x2, *rest[:2], *rest[3:]], [y, v1, v2, *speed], rtol=0, atol=3e-14)
    found = np.linalg.eigvals(without_shift(carried.matrix, bool(speed)))
    for multiplier in multipliers:
        assert min(abs(found - multiplier)) < 1e-12  # simple ones: rounding times their condition
    assert carried.uncertified == 0 and len(carried.events) >= 4
