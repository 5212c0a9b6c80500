"""What a motion really uses of its limits, between the nodes too."""

from __future__ import annotations

import numpy as np

from toolpace.arrays import Floats, Ints
from toolpace.axispath.run import AxisRun
from toolpace.kernels.motion import usage
from toolpace.laws.linear import LinearLaw
from toolpace.laws.spline import SplineLaw
from toolpace.machine.limits import Limits
from toolpace.motion import limit_ratios
from toolpace.workers import Workers

CHUNK = 5_000
"""Cells whose usage is worked out at a time, to keep memory low."""


def cell_peaks(
    run: AxisRun, limits: Limits, law: SplineLaw, cells: Ints | None = None, workers: Workers | None = None
) -> Floats:
    """(n, 3) largest usage in the given cells of the spline (default: in all), by speed, acceleration and jerk."""
    wanted = np.arange(len(law.nodes) - 1) if cells is None else cells

    def of_part(first: int) -> Floats:
        return peaks_of(run, limits, law, wanted[first : first + CHUNK])

    parts = (workers or Workers()).each(of_part, range(0, len(wanted), CHUNK))
    return np.concatenate(parts) if parts else np.empty((0, 3))


def peaks_of(run: AxisRun, limits: Limits, law: SplineLaw | LinearLaw, cells: Ints) -> Floats:
    """(n, 3) the same for a law of either planner, worked out in one piece."""
    m = len(limits)
    state, right = law.states_within(cells)
    of_cell = usage.peaks(law.inside, limit_ratios(run, limits, state, right))
    kinds = np.split(of_cell, [1 + m, 1 + 2 * m], axis=1)
    return np.stack([kind.max(axis=1) for kind in kinds], axis=1)
