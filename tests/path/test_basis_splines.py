"""Splines in arrays, beside scipy's, to the last bit."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.interpolate import BSpline

from toolpace.path.fit.spline import cells_of, nonzero_basis, spline_values

CASES = [(degree, order) for degree in (1, 2, 3, 5) for order in range(degree + 1)]


@pytest.mark.parametrize("ends", ["clamped", "open"])
@pytest.mark.parametrize(("degree", "order"), CASES)
def test_values_are_those_of_scipy(degree: int, order: int, ends: str):
    rng = np.random.default_rng(degree)
    breaks = np.cumsum(rng.uniform(0.001, 2.0, 60))
    if ends == "clamped":
        breaks = np.concatenate([np.repeat(breaks[0], degree), breaks, np.repeat(breaks[-1], degree)])
    coefficients = rng.normal(size=(len(breaks) - degree - 1, 3))
    # knots and both sides of the ends too
    at = np.concatenate([breaks, rng.uniform(breaks[0] - 0.1, breaks[-1] + 0.1, 1000)])
    expected = BSpline(breaks, coefficients, degree)(at, nu=order)
    np.testing.assert_array_equal(spline_values(breaks, coefficients, degree, at, order), expected)
    np.testing.assert_array_equal(spline_values(breaks, coefficients[:, 0], degree, at, order), expected[:, 0])


def test_basis_functions_add_up_to_one():
    knots = np.array([0.0, 0.0, 0.0, 1.0, 1.5, 4.0, 4.0, 4.0])
    at = np.linspace(0.0, 4.0, 41)
    basis = nonzero_basis(knots, 2, cells_of(knots, 2, at), at)
    assert basis.shape == (41, 3) and basis.min() >= 0.0
    np.testing.assert_allclose(basis.sum(axis=1), 1.0, rtol=1e-15)
