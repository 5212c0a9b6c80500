"""A random smooth path of five joints that is as long as one likes, and equally hard everywhere."""

from __future__ import annotations

import numpy as np

from testbed.jets import path_of
from toolpace.kernels.fit.quintic_spline import jets
from toolpace.machine.limits import Limits
from toolpace.path.axis_path import AxisPath

JOINTS = 5
CELLS_A_FEATURE = 50
"""Mesh cells for each knot of the spline: about eight for the time in which the quickest joint's acceleration grows."""
SEED = 2026
PIECE = np.array(
    [
        [1, 26, 66, 26, 1, 0],
        [-5, -50, 0, 50, 5, 0],
        [10, 20, -60, 20, 10, 0],
        [-10, 20, 0, -20, 10, 0],
        [5, -20, 30, -20, 5, 0],
        [-1, 5, -10, 10, -5, 1],
    ]
) / 120.0  # fmt: skip
"""Powers of the place in a piece of a uniform quintic B-spline, by its six control points."""


def long_path(cells: int, hints: bool = False) -> tuple[AxisPath, Limits]:
    """A quintic B-spline through random control points, a knot for every 50 cells, and limits of its joints.

    The spline is four times continuously differentiable. `hints` tells the planner the knots.
    """
    features = max(cells // CELLS_A_FEATURE, 4)
    random = np.random.default_rng(SEED)
    limits = Limits(
        random.uniform(0.5, 2.0, JOINTS), random.uniform(1.5, 6.0, JOINTS), random.uniform(10.0, 40.0, JOINTS)
    )
    control = random.normal(size=(features + 5, JOINTS))
    pieces = np.stack([np.einsum("pk,kj->pj", PIECE, control[i : i + 6]) for i in range(features)])
    knots = np.arange(features + 1.0)
    path = path_of(lambda s: jets(knots, pieces, s), 0.0, float(features), hints=knots if hints else ())
    return path, limits
