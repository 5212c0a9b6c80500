"""The banded solver against a dense one."""

from __future__ import annotations

import numpy as np
import pytest

from toolpace.kernels.fit import band


def system(n, w, seed=0):
    """A positive definite matrix (n, n) of that band width, and its band."""
    random = np.random.default_rng(seed)
    lower = np.tril(random.normal(size=(n, n)))
    lower[np.subtract.outer(np.arange(n), np.arange(n)) >= w] = 0.0
    matrix = lower @ lower.T + np.eye(n)
    rows = band.empty(n, w)
    rows[:] = 0.0
    for k in range(min(w, n)):
        rows[: n - k, k] = np.diagonal(matrix, -k)
    return matrix, rows


@pytest.mark.parametrize("w", [6, 12, 18])
@pytest.mark.parametrize("n", [1, 2, 7, 18, 61])
def test_solution(n, w):
    matrix, rows = system(n, w)
    b = np.arange(1.0, n + 1.0)
    x = b.copy()
    assert band.factor(rows)
    band.solve(rows, x)
    assert x == pytest.approx(np.linalg.solve(matrix, b), rel=1e-9, abs=1e-9)


@pytest.mark.parametrize("wrong", [-1.0, 0.0, np.nan])
@pytest.mark.parametrize("row", [4, 5])
def test_a_matrix_that_is_not_positive_is_refused(wrong, row):
    _, rows = system(12, 6)
    rows[row] = 0.0
    rows[row, 0] = wrong
    assert not band.factor(rows)
