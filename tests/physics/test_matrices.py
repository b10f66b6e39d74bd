"""Matrices in one order of operations, against their residuals, numpy and closed forms."""

import numpy as np
import pytest

from vibsim.orbits import stability as faces
from vibsim.orbits.stability import NoEigenvalues, directions, eigenvalues, least_squares, solved_by_pivots
from vibsim.physics.linear_algebra import symmetric_eigenvalues

EPS = 2.0**-52


def drawn(count):
    """Matrices and vectors: full, of low rank, of whole numbers, badly scaled, triangular."""
    random = np.random.default_rng(1)
    for trial in range(count):
        m, n = random.integers(1, 9, 2)
        A, B = random.standard_normal((n, n)), random.standard_normal((m, n))
        if trial % 3 == 0:
            A = A * 10.0 ** random.integers(-3, 4, (n, n))
        if trial % 4 == 0:
            A, B = np.round(A), np.round(B)
        if trial % 5 == 0:
            A[:, -1], B[-1] = A[:, 0], B[0]
        if trial % 7 == 0:
            A = np.tril(A)
        yield A, B, random.standard_normal(n)


def test_what_they_say_is_so_to_rounding():
    """Backward errors: of elimination below n^2 eps, of rotations and of the QR method below some n eps."""
    for A, B, b in drawn(300):
        n, size = len(b), np.linalg.norm(A)
        x, pivots = solved_by_pivots(A, b)
        if pivots:
            assert np.abs(A @ x - b).max() <= 8 * n * n * EPS * size * np.abs(x).max()
        values, vectors, images = directions(B)
        assert (np.diff(values) <= 0).all()
        np.testing.assert_allclose(vectors @ vectors.T, np.eye(n), atol=16 * n * EPS)
        np.testing.assert_allclose(B @ vectors.T, images.T, atol=16 * n * EPS * np.linalg.norm(B))
        across = images @ images.T
        assert np.abs(across - np.diag(np.diag(across))).max() <= 16 * n * EPS * values[0] ** 2
        for mu in eigenvalues(A):
            least = np.linalg.svd(A - mu * np.eye(n), compute_uv=False)[-1]
            assert least <= 16 * n * EPS * size
        whole = A + A.T
        own = symmetric_eigenvalues(whole)
        np.testing.assert_allclose(own, np.linalg.eigvalsh(whole), atol=8 * n * EPS * np.linalg.norm(whole))


def test_eigenvalues_in_closed_form():
    """Of a tridiagonal matrix: 2 - 2 cos(k pi / (n + 1)); of one that turns by an angle its two of size 1."""
    n = 60
    A = 2 * np.eye(n) - np.eye(n, k=1) - np.eye(n, k=-1)
    exact = 2 - 2 * np.cos(np.arange(1, n + 1) * np.pi / (n + 1))
    np.testing.assert_allclose(sorted(mu.real for mu in eigenvalues(A)), exact, atol=64 * EPS * 4)
    np.testing.assert_allclose(symmetric_eigenvalues(A), exact, atol=64 * EPS)
    one, other = eigenvalues(np.array([[0.6, -0.8], [0.8, 0.6]]))
    assert one == other.conjugate() and one == pytest.approx(0.6 + 0.8j, abs=2 * EPS)


def test_zeros_isolate_eigenvalues_exactly():
    """As where a motion forgets a direction: a row of zeros, and what it takes with it."""
    A = np.array([[0.0, 0.0, 0.0], [0.3, 0.7, 0.0], [5.0, 0.1, 1.0 / 3]])
    assert sorted(mu.real for mu in eigenvalues(A)) == [0.0, 1.0 / 3, 0.7]
    assert all(mu.imag == 0 for mu in eigenvalues(A))


def test_the_kernel_of_fewer_equations_than_unknowns():
    J = np.array([[1.0, 2.0, 3.0], [2.0, 4.0, 6.0]])
    values, vectors, _ = directions(J)
    assert values[0] == pytest.approx(np.sqrt(70), rel=4 * EPS) and values[1:].max() < 8 * EPS * values[0]
    assert np.abs(J @ vectors[1:].T).max() < 8 * EPS * values[0]
    shortest = least_squares(J, np.array([1.0, 2.0]), 1e-9)
    np.testing.assert_allclose(shortest, np.array([1.0, 2.0, 3.0]) / 14, atol=4 * EPS)


@pytest.mark.parametrize("value", [np.nan, np.inf])
def test_what_is_not_finite_is_refused(value):
    matrix = np.array([[1.0, value], [0.0, 2.0]])
    for ask in (directions, eigenvalues):
        with pytest.raises(NoEigenvalues, match="not finite"):
            ask(matrix)
    assert np.isnan(solved_by_pivots(np.full((2, 2), np.nan), np.ones(2))[0]).all()


def test_a_root_and_a_modulus():
    for z in (3 + 4j, -3 + 4j, -3 - 4j, -4.0 + 0j, 2e200 + 1e200j, 0j):
        root = faces.square_root(z)
        assert root.real >= 0 and root * root == pytest.approx(z, rel=8 * EPS, abs=0)
        assert faces.modulus(z) == pytest.approx(abs(z), rel=2 * EPS)
