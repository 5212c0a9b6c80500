"""The picture of `toolpace tolerance`: duration over tolerance, on a scale of ratios."""

from __future__ import annotations

import math
from collections.abc import Sequence

from toolpace.common.units import format_length
from toolpace.study.svg import INK, SOFT, Drawing

WIDTH, HEIGHT = 720, 420
LEFT, RIGHT, TOP, BOTTOM = 84.0, 28.0, 56.0, 58.0
"""Margins [pixels]."""
LINE = "#2f6fed"
LINES = 5
"""About so many lines of equal duration."""


def drawn(found: Sequence[tuple[float, float]], program: str) -> str:
    """The picture (SVG) of pairs of tolerance [m], ascending, and duration [s]."""
    picture = Drawing(WIDTH, HEIGHT, f"{program}: duration over tolerance of the tip")
    low, high = (math.log(found[k][0]) for k in (0, -1))
    marks = round_values(min(each[1] for each in found), max(each[1] for each in found))

    def at(tolerance: float, duration: float) -> tuple[float, float]:
        across = (math.log(tolerance) - low) / ((high - low) or 1.0)
        up = (duration - marks[0]) / (marks[-1] - marks[0])
        return LEFT + across * (WIDTH - LEFT - RIGHT), HEIGHT - BOTTOM - up * (HEIGHT - TOP - BOTTOM)

    for mark in marks:
        foot, end = at(found[0][0], mark), at(found[-1][0], mark)
        picture.line([foot, end], "#e4e8ee", 1.0)
        picture.words(foot, f"{mark:.6g} s", SOFT, off=(-8.0, 4.0), anchor="end", size=12)
    points = [at(*each) for each in found]
    picture.line(points, LINE, 2.0)
    for (tolerance, _), point in zip(found, points):
        picture.circle(point, 3.5, LINE, "#ffffff")
        picture.words(
            (point[0], HEIGHT - BOTTOM), format_length(tolerance), SOFT, off=(0.0, 20.0), anchor="middle", size=12
        )
    picture.words((LEFT, TOP), f"{program}: what a micrometre costs", INK, off=(0.0, -24.0), size=15, bold=True)
    picture.words((WIDTH - RIGHT, HEIGHT), "tolerance of the tip", SOFT, off=(0.0, -12.0), anchor="end", size=12)
    return picture.svg()


def round_values(low: float, high: float) -> list[float]:
    """Round values, evenly apart, from at most `low` to at least `high`."""
    span = max(high - low, 1e-3 * high)
    rough = span / LINES
    size = 10.0 ** math.floor(math.log10(rough))
    step = next(size * k for k in (1.0, 2.0, 5.0, 10.0) if size * k >= rough)
    first, last = math.floor(low / step), math.ceil(high / step)
    return [step * k for k in range(first, max(last, first + 1) + 1)]
