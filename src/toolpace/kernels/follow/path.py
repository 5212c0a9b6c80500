"""The path in time as a uniform cubic B-spline with its samples as control points.

Each derivative of such a spline is a mean of the differences of the samples, and these are means of the derivative
sampled: so it passes no limit that the motion keeps, at any time. It leaves the samples by a sixth of their second
difference (Schoenberg 1946; de Boor, A Practical Guide to Splines, chapter IX).
"""

from __future__ import annotations

from toolpace.kernels.arrays import Floats
from toolpace.kernels.follow.layout import (
    CELL,
    CELL_COLUMNS,
    CELLS,
    COLUMNS,
    FROM,
    LONGER,
    PATH,
    SAMPLES,
    STEP,
    TOOL_COLUMNS,
    TOOLS,
)
from toolpace.kernels.jit import jit


@jit()
def place_on_path(piece: Floats, tau: float, column: int, out: Floats) -> None:
    """Value and three derivatives by the time of the path (4,) of one column at a time [s]."""
    h = piece[STEP]
    last = int(piece[SAMPLES]) - 1
    x = min(max(tau / h, 0.0), float(last))
    i = min(int(x), last - 1)
    u = x - i
    at = PATH + i * COLUMNS + column
    a, b, c, d = piece[at], piece[at + COLUMNS], piece[at + 2 * COLUMNS], piece[at + 3 * COLUMNS]
    first = ((b - a), (c - b), (d - c))
    second = (first[1] - first[0], first[2] - first[1])
    w = 1.0 - u
    # about the control point that is nearest, so that no digits are lost
    out[0] = (
        b
        + (w * w * w * (a - b) + (1.0 + 3.0 * u + 3.0 * u * u - 3.0 * u * u * u) * (c - b) + u * u * u * (d - b)) / 6.0
    )
    out[1] = (0.5 * w * w * first[0] + (0.5 + u - u * u) * first[1] + 0.5 * u * u * first[2]) / h
    out[2] = (w * second[0] + u * second[1]) / (h * h)
    out[3] = (second[1] - second[0]) / (h * h * h)


@jit()
def cell_at(piece: Floats, tau: float) -> int:
    """First place in the piece of the cell that a time of the path lies in."""
    count = int(piece[CELLS])
    k = min(max(int(tau / piece[CELL]), 0), count - 1)
    return PATH + (int(piece[SAMPLES]) + 3) * COLUMNS + k * CELL_COLUMNS


@jit()
def longer_at(piece: Floats, tau: float) -> float:
    """By how much the tool in the spindle at a time of the path is longer than that of the machine file [m]."""
    table = PATH + (int(piece[SAMPLES]) + 3) * COLUMNS + int(piece[CELLS]) * CELL_COLUMNS
    low, high = 0, int(piece[TOOLS])
    while high - low > 1:
        middle = (low + high) // 2
        if piece[table + middle * TOOL_COLUMNS + FROM] <= tau:
            low = middle
        else:
            high = middle
    longer: float = piece[table + low * TOOL_COLUMNS + LONGER]
    return longer
