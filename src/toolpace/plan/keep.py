"""What the rounds between the nodes leave above the guarantee is taken away by slowing the whole motion down."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from toolpace.kernels import cubic
from toolpace.plan.course import FLOOR, Course
from toolpace.plan.crew import Crew
from toolpace.plan.mesh import split
from toolpace.plan.peaks import cell_peaks
from toolpace.plan.solve import LIMITS, Stalled
from toolpace.timelaw import SplineLaw

Floats = npt.NDArray[np.float64]

GUARANTEE = 1.0 + 9e-5
"""Usage between nodes that is never passed, a rounding below what is promised."""
MOST_SPLITS = 20


def kept(course: Course, law: SplineLaw, crew: Crew) -> SplineLaw:
    """The law within the guarantee, slowed down as a whole for it; one with an end in motion cannot be: Stalled."""
    law = without_dips(law)
    peak = cell_peaks(course, law, crew=crew)
    if peak.max() <= GUARANTEE:
        return law
    if not (law.rest[0] > 0.0 and law.rest[1] > 0.0 and np.isfinite(peak).all()):
        cell, kind = divmod(int(np.nan_to_num(peak, nan=np.inf).argmax()), peak.shape[1])
        raise Stalled(float(law.nodes[cell]), LIMITS[kind])
    return law.slowed(slowing(peak))


def slowing(peak: Floats) -> float:
    """By how much z must be divided for the peaks (cells, 3) of speed, acceleration and jerk to come down to 1."""
    speed, acceleration, jerk = peak.max(axis=0)
    return float(max(1.0, speed**2, acceleration, jerk ** (2.0 / 3.0)))


def without_dips(law: SplineLaw) -> SplineLaw:
    """The same z over a finer mesh, where it falls too far inside a cell; raised where it falls to nothing."""
    for _ in range(MOST_SPLITS):
        dips = law.dips()
        if not dips.any():
            break
        finer = split(law.nodes, np.where(dips, 4, 1))
        c = cubic.on_finer_knots(law.nodes, law.cells, finer)
        share = np.interp(cubic.control_points(finer), law.nodes, law.z_at_nodes())
        fallen = lowest(law) <= 0.0
        if fallen.any():
            # all that touches the cells that have fallen
            near = np.convolve(np.repeat(fallen, np.where(dips, 4, 1)), np.ones(4)) > 0.0
            c = np.where(near, np.maximum(c, FLOOR * share), c)
            for end, (one, two) in enumerate(((0, 1), (-1, -2))):
                if law.rest[end] > 0.0:
                    c[two] = c[one] * (1.0 + 4.0 * abs(finer[two] - finer[one]) / (9.0 * law.rest[end]))
        law = SplineLaw(finer, c, law.rest)
    return law


def lowest(law: SplineLaw) -> Floats:
    """(n - 1,) least z in each cell, at the places where it is probed."""
    x = np.diff(law.nodes)[:, None] * law.inside
    a = law.cells.T[:, :, None]
    z: Floats = (a[0] + x * (a[1] + x * (a[2] + x * a[3]))).min(axis=1)
    return z
