"""What a motion really uses of its limits, between the nodes too."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from toolpace.axispath import AxisRun
from toolpace.kernels import usage
from toolpace.kernels.speedlaw import REST_INSIDE
from toolpace.limits import Limits
from toolpace.timelaw import SplineLaw
from toolpace.trajectory import limit_ratios

Floats = npt.NDArray[np.float64]
Ints = npt.NDArray[np.int64]

CHUNK = 20_000
"""Cells whose usage is worked out at a time, to keep memory low."""


def cell_peaks(run: AxisRun, limits: Limits, law: SplineLaw, cells: Ints | None = None) -> Floats:
    """(n, 3) largest usage in the given cells of the spline (default: in all), by speed, acceleration and jerk."""
    m, k = len(limits), len(law.inside)
    kinds = np.split(np.arange(1 + 3 * m), [1 + m, 1 + 2 * m])
    probe = law.probe()
    first = len(REST_INSIDE) if law.rest[0] > 0.0 else 0
    wanted = np.arange(len(law.nodes) - 1) if cells is None else cells
    out = np.empty((len(wanted), 3))
    for low in range(0, len(wanted), CHUNK):
        part = wanted[low : low + CHUNK]
        sample = (first + part[:, None] * k + np.arange(k)).ravel()
        of_cell = usage.peaks(law.inside, limit_ratios(run, limits, probe.state[:, sample], probe.right[sample]))
        out[low : low + CHUNK] = np.stack([of_cell[:, kind].max(axis=1) for kind in kinds], axis=1)
    return out
