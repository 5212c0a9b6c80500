"""Triangles and lines as pixels: a depth buffer in plain NumPy, at twice the size, which smooths edges.

    pixels in the box about each triangle, many triangles at a time
    kept where they are within it (edge functions, Pineda 1988) and nearer than what is there
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
import numpy.typing as npt

from toolpace.common.arrays import Floats, Ints

FINER = 2
"""Pixels that are drawn for each one of the picture, in each direction."""
PORTION = 2_000_000
"""Pixels that are worked out at a time."""
OUTLINE = 0.55
"""Brightness of a pixel behind which the depth jumps."""


class Canvas:
    """A picture in the making. Places are (x, y) in its pixels from the upper left, and the depth behind the screen."""

    def __init__(self, width: int, height: int, ground: tuple[float, float, float]) -> None:
        self.width, self.height = width * FINER, height * FINER
        self.colour = np.tile(np.array(ground, dtype=np.float32), (self.width * self.height, 1))
        self.depth = np.full(self.width * self.height, np.inf)

    def triangles(self, corners: Floats, colours: Floats) -> None:
        """Draw triangles (n, 3, 3), each of one colour (n, 3) from 0 to 1; what is turned away is left out."""
        corners = corners * [FINER, FINER, 1.0]
        a, b, c = corners[:, 0], corners[:, 1], corners[:, 2]
        area = (b[:, 0] - a[:, 0]) * (c[:, 1] - a[:, 1]) - (b[:, 1] - a[:, 1]) * (c[:, 0] - a[:, 0])
        low = np.maximum(np.ceil(corners[:, :, :2].min(axis=1) - 0.5), 0).astype(np.int64)
        most = np.array([self.width, self.height]) - 1
        high = np.minimum(np.floor(corners[:, :, :2].max(axis=1) - 0.5), most).astype(np.int64)
        # y is downwards: what is counterclockwise seen from outside has a negative area
        seen = (area < 0.0) & (high >= low).all(axis=1)
        corners, colours, low, high, area = (each[seen] for each in (corners, colours, low, high, area))
        for which in _portions((high - low + 1).prod(axis=1)):
            self._portion(corners[which], colours[which], low[which], high[which], area[which])

    def _portion(self, corners: Floats, colours: Floats, low: Ints, high: Ints, area: Floats) -> None:
        wide, tall = (high - low + 1).T
        count = wide * tall
        of = np.repeat(np.arange(len(count)), count)
        within = np.arange(len(of)) - np.repeat(np.cumsum(count) - count, count)
        x = low[of, 0] + within % wide[of]
        y = low[of, 1] + within // wide[of]
        # each weight, and the depth, is linear in x and y
        planes = np.empty((4, 3, len(count)))
        for k in range(3):
            (px, py), (qx, qy) = corners[:, (k + 1) % 3, :2].T, corners[:, (k + 2) % 3, :2].T
            slope_x, slope_y = (py - qy) / area, (qx - px) / area
            planes[k] = slope_x, slope_y, slope_x * (0.5 - px) + slope_y * (0.5 - py)
        planes[3] = sum(planes[k] * corners[:, k, 2] for k in range(3))
        inside = np.ones(len(of), np.bool_)
        for slope_x, slope_y, constant in planes[:3]:
            inside &= slope_x[of] * x + slope_y[of] * y + constant[of] >= 0.0
        of, x, y = of[inside], x[inside], y[inside]
        slope_x, slope_y, constant = planes[3]
        depth = slope_x[of] * x + slope_y[of] * y + constant[of]
        self._put(y * self.width + x, depth, colours[of])

    def lines(self, ends: Floats, colours: Floats, width: float, in_front: float) -> None:
        """Draw straight lines (n, 2, 3), each of one colour (n, 3), so many pixels wide, so far in front of the faces
        that they are on."""
        ends = ends * [FINER, FINER, 1.0]
        long = np.abs(ends[:, 1, :2] - ends[:, 0, :2]).max(axis=1)
        most = 4.0 * (self.width + self.height)
        count = np.maximum(np.ceil(np.minimum(long, most)), 1.0).astype(np.int64) + 1
        reach = 0.5 * width * FINER
        steps = np.arange(np.ceil(-reach), np.floor(reach) + 1)
        brush = [(dx, dy) for dx in steps for dy in steps if np.hypot(dx, dy) <= reach]
        for which in _portions(count * len(brush)):
            begin, end, number = ends[which, 0], ends[which, 1], count[which]
            of = np.repeat(np.arange(len(number)), number)
            share = (np.arange(len(of)) - np.repeat(np.cumsum(number) - number, number)) / (number[of] - 1)
            places = begin[of] + share[:, None] * (end - begin)[of]
            for dx, dy in brush:
                x, y = np.floor(places[:, 0] + dx).astype(np.int64), np.floor(places[:, 1] + dy).astype(np.int64)
                on = (x >= 0) & (x < self.width) & (y >= 0) & (y < self.height)
                depth = places[on, 2] - in_front
                self._put((y * self.width + x)[on], depth, colours[which][of[on]])

    def _put(self, pixel: Ints, depth: Floats, colours: Floats) -> None:
        """Pixels (k,) where they are nearer than what is there."""
        np.minimum.at(self.depth, pixel, depth)
        nearest = depth <= self.depth[pixel]
        self.colour[pixel[nearest]] = colours[nearest]

    def outlined(self, jump: float) -> None:
        """Darken what is in front of a jump of the depth."""
        depth = self.depth.reshape(self.height, self.width)
        edge = np.zeros(depth.shape, np.bool_)
        with np.errstate(invalid="ignore"):
            for axis in range(2):
                step = np.diff(depth, axis=axis)
                before, behind = (slice(None), slice(-1)), (slice(None), slice(1, None))
                if axis == 0:
                    before, behind = before[::-1], behind[::-1]
                edge[before] |= step > jump
                edge[behind] |= step < -jump
        self.colour[edge.ravel()] *= OUTLINE

    def pixels(self) -> npt.NDArray[np.uint8]:
        """(height, width, 3) of the picture."""
        shape = self.height // FINER, FINER, self.width // FINER, FINER, 3
        mean = self.colour.reshape(shape).mean(axis=(1, 3))
        return np.asarray(np.clip(np.round(255.0 * mean), 0, 255), dtype=np.uint8)


def _portions(pixels: Ints) -> Iterator[slice]:
    """Neighbours that have at most PORTION pixels together, or are alone."""
    total = np.cumsum(pixels)
    begin = 0
    while begin < len(pixels):
        before = total[begin - 1] if begin else 0
        end = max(int(np.searchsorted(total, before + PORTION, side="right")), begin + 1)
        yield slice(begin, end)
        begin = end
