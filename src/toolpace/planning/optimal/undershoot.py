"""Refinement of cells in which the squared speed falls far below its values at both nodes."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from toolpace.common.arrays import Floats
from toolpace.kernels.motion import cubic_spline
from toolpace.motion.laws import SplineLaw
from toolpace.planning.mesh.nodes import cut_cells

NOTHING = 1e-3
"""Share of z at the nodes of a cell below which it has fallen to nothing inside: there a parabola touches zero, and
is not told from it by cutting the cell."""
FLOOR = 0.3
"""What z starts from on a finer mesh where it dips between two nodes, as a share of z at the nodes."""
MOST_SPLITS = 6
SHORTEST = 1e3
"""Cells that are cut no further, as a multiple of the rounding of s."""


def without_undershoot(law: SplineLaw) -> SplineLaw:
    """The same z over a finer mesh, where it falls too far inside a cell; raised where it falls to nothing."""
    for _ in range(MOST_SPLITS):
        dips = law.dips()
        if not dips.any():
            break
        short = too_short(law.nodes)
        parts = np.where(dips & ~short, 4, 1)
        finer = cut_cells(law.nodes, parts)
        c, least = on_finer_mesh(law, finer)
        z = law.z_at_nodes()
        fallen = dips & (short | (lowest_z(law) <= NOTHING * np.minimum(z[:-1], z[1:])))
        if fallen.any():
            # all that touches the cells that have fallen
            near = np.convolve(np.repeat(fallen, parts), np.ones(4)) > 0.0
            c = np.where(near, np.maximum(c, least), c)
            for end, (one, two) in enumerate(((0, 1), (-1, -2))):
                if law.rest[end] > 0.0:
                    c[two] = c[one] * (1.0 + 4.0 * abs(finer[two] - finer[one]) / (9.0 * law.rest[end]))
        law = SplineLaw(finer, c, law.rest)
    return law


def on_finer_mesh(law: SplineLaw, finer: Floats) -> tuple[Floats, Floats]:
    """Coefficients of the same z over a finer mesh (n,), and what they should not be below (n + 2,)."""
    c = cubic_spline.on_finer_knots(law.nodes, law.cells, finer)
    least: Floats = FLOOR * np.interp(cubic_spline.control_points(finer), law.nodes, law.z_at_nodes())
    return c, least


def too_short(nodes: Floats) -> npt.NDArray[np.bool_]:
    """(n - 1,) cells that numbers do not resolve when they are cut."""
    short: npt.NDArray[np.bool_] = np.diff(nodes) < SHORTEST * np.spacing(np.abs(nodes).max())
    return short


def lowest_z(law: SplineLaw) -> Floats:
    """(n - 1,) least z in each cell, at the places where it is probed."""
    x = np.diff(law.nodes)[:, None] * law.inside
    a = law.cells.T[:, :, None]
    z: Floats = (a[0] + x * (a[1] + x * (a[2] + x * a[3]))).min(axis=1)
    return z
