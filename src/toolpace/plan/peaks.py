"""What a motion really uses of its limits, between the nodes too."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from toolpace.kernels import usage
from toolpace.plan.course import Course
from toolpace.plan.crew import Crew
from toolpace.timelaw import SplineLaw
from toolpace.trajectory import limit_ratios

Floats = npt.NDArray[np.float64]
Ints = npt.NDArray[np.int64]

CHUNK = 5_000
"""Cells whose usage is worked out at a time, to keep memory low."""


def cell_peaks(course: Course, law: SplineLaw, cells: Ints | None = None, crew: Crew | None = None) -> Floats:
    """(n, 3) largest usage in the given cells of the spline (default: in all), by speed, acceleration and jerk."""
    m = len(course.limits)
    kinds = np.split(np.arange(1 + 3 * m), [1 + m, 1 + 2 * m])
    wanted = np.arange(len(law.nodes) - 1) if cells is None else cells

    def of_part(first: int) -> Floats:
        state, right = law.states_within(wanted[first : first + CHUNK])
        of_cell = usage.peaks(law.inside, limit_ratios(course.run, course.limits, state, right))
        return np.stack([of_cell[:, kind].max(axis=1) for kind in kinds], axis=1)

    parts = (crew or Crew()).each(of_part, range(0, len(wanted), CHUNK))
    return np.concatenate(parts) if parts else np.empty((0, 3))
