"""Normal coordinates: what goes there and back is what it was."""

import numpy as np
import pytest

from vibsim.engine.flows.closed.matrices import jacobi
from vibsim.physics.numbers import Doubles


@pytest.mark.parametrize("apart", [0.0, 1e-12, 1e-6, 1e-3, 0.3, -1e-6, -0.3])
@pytest.mark.parametrize("off", [0.5, -0.5, 1e-9])
def test_rotations_are_orthogonal_however_close_the_diagonal_is(apart, off):
    K = np.array([[1.0, off, 0.1], [off, 1.0 + apart, 0.0], [0.1, 0.0, 2.0]])
    V = np.array(jacobi(Doubles, K.tolist(), np.zeros((3, 3)).tolist()))
    # some 20 rotations, each orthogonal to a few roundings
    np.testing.assert_allclose(V.T @ V, np.eye(3), rtol=0, atol=1e-14)
    rotated = V.T @ K @ V
    np.testing.assert_allclose(rotated, np.diag(np.diag(rotated)), rtol=0, atol=1e-13)
