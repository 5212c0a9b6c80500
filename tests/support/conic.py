"""The relaxation of the planner's problem, by an independent conic solver."""

from __future__ import annotations

import numpy as np
import pytest
from scipy import sparse

from toolpace.kernels.optimal import newton


def conic_optimum(knots, c, low=None, high=None):
    """The relaxation by a conic solver: pace^(2/3) z^(1/3) >= 1 is a power cone. Unknowns are scaled by c.

    Where low (n,) > 0, z lies between low and high and the pace is below the chord of 1 / sqrt(z) there.
    """
    clarabel = pytest.importorskip("clarabel")
    n, m = len(knots.weight), len(c)
    z = knots.state(c)[:, 0]
    half = knots.rows.shape[1] // 2
    place = (np.repeat(np.arange(n), 3), (np.arange(n)[:, None] + np.arange(3)).ravel())
    value = [sparse.csr_matrix((knots.basis[:, d].ravel(), place), (n, m)) @ sparse.diags(abs(c)) for d in range(3)]
    knot = np.repeat(np.arange(n), np.diff(knots.first))
    none, own = sparse.csr_matrix((len(knot), n)), sparse.identity(n, format="csr")[knot]
    left, right = [sparse.hstack([sparse.diags(1.0 / knots.cap) @ value[0], sparse.csr_matrix((n, n))])], [np.ones(n)]
    for i in range(2 * half):
        row = sum(sparse.diags(knots.rows[:, i, d]) @ value[d][knot] for d in range(3))
        if i >= half:
            row = sparse.diags(np.sqrt(z)[knot]) @ row
        left += [sparse.hstack([sign * row, none if i < half else -own]) for sign in (1.0, -1.0)]
        right += [np.full(len(knot), 1.0 if i < half else 0.0)] * 2
    if low is not None:
        some = np.flatnonzero(low > 0.0)
        fall = (low[some] ** -0.5 - high[some] ** -0.5) / (high[some] - low[some])
        top, unit, zero = low[some] ** -0.5 + fall * low[some], np.sqrt(z[some]), sparse.csr_matrix((len(some), n))
        left += [sparse.hstack([-sparse.diags(1.0 / low[some]) @ value[0][some], zero])]
        left += [sparse.hstack([sparse.diags(1.0 / high[some]) @ value[0][some], zero])]
        left += [sparse.hstack([sparse.diags(fall * unit) @ value[0][some], sparse.identity(n, format="csr")[some]])]
        right += [-np.ones(len(some)), np.ones(len(some)), top * unit]
    ties, given_ = [], []
    for k, (one, two) in enumerate(((0, 1), (m - 1, m - 2))):
        rest = knots.end[k] == newton.REST
        for i in (two,) if rest else (one, two):
            tie = np.zeros(m + n)
            tie[i] = 1.0
            tie[one] -= knots.ratio[k] * abs(c[one] / c[two]) if rest else 0.0
            ties.append(tie)
            given_.append(0.0 if rest else np.sign(c[i]))
    cones = [clarabel.ZeroConeT(len(ties)), clarabel.NonnegativeConeT(sum(map(len, right)))]
    left, right = [sparse.csr_matrix(np.array(ties)), *left], [np.array(given_), *right]
    for k in range(n):
        pace = sparse.csr_matrix((-np.ones(1), (np.zeros(1, int), np.array([m + k]))), (1, m + n))
        share = sparse.hstack([-value[0][k] / z[k], sparse.csr_matrix((1, n))])
        left += [pace, share, sparse.csr_matrix((1, m + n))]
        right.append(np.array([0.0, 0.0, 1.0]))
        cones.append(clarabel.PowerConeT(2.0 / 3.0))
    time = knots.weight / np.sqrt(z)
    quiet = clarabel.DefaultSettings()
    quiet.verbose = False
    answer = clarabel.DefaultSolver(
        sparse.csc_matrix((m + n, m + n)), np.concatenate([np.zeros(m), time / time.sum()]),
        sparse.csc_matrix(sparse.vstack(left)), np.concatenate(right), cones, quiet,
    ).solve()  # fmt: skip
    assert "Solved" in str(answer.status)
    return answer.obj_val * time.sum()
