"""A stock as heights over a fine grid, cut by an upright flat mill: slow, simple, and with no code of the library.

Of each tooth angle the material ahead is looked up in the grid, and the force of a turn is added up tooth by tooth:
F = Kc A + Ke L, with the area A of the chips and the length L of the edges in material at one time.
"""

from __future__ import annotations

from itertools import pairwise

import numpy as np
from scipy.ndimage import grey_opening

CELL = 0.1
"""[mm]"""
STEP = 0.5
"""Of the tool along its way [mm]."""
ANGLES = 240
"""Of a turn."""


class HeightField:
    """Lengths in mm. Columns whose height is the bottom are empty."""

    def __init__(self, low: np.ndarray, high: np.ndarray, room: float, finer: int = 1) -> None:
        """A box from low (3,) to high (3,), in a grid that goes `room` beyond it; finer: by what it is than CELL, and
        than STEP and ANGLES."""
        self.finer, self.cell = finer, CELL / finer
        self.origin, self.bottom = low[:2] - room, float(low[2])
        count = np.ceil((high[:2] - low[:2] + 2.0 * room) / self.cell).astype(int)
        self.x, self.y = (self.origin[k] + self.cell * (np.arange(count[k]) + 0.5) for k in range(2))
        self.height = np.full(count, self.bottom)
        inside = [(axis > low[k]) & (axis < high[k]) for k, axis in enumerate((self.x, self.y))]
        self.height[np.ix_(*inside)] = high[2]

    def at(self, places: np.ndarray) -> np.ndarray:
        """(n,) height at places (n, 2); the bottom outside the grid."""
        cell = np.floor((places - self.origin) / self.cell).astype(int)
        inside = ((cell >= 0) & (cell < self.height.shape)).all(axis=1)
        found = np.full(len(places), self.bottom)
        found[inside] = self.height[cell[inside, 0], cell[inside, 1]]
        return found

    def cut(self, place: np.ndarray, radius: float) -> None:
        """Take away what a flat mill is in whose tip is at a place (3,)."""
        low, high = (np.floor((place[:2] + side * radius - self.origin) / self.cell).astype(int) for side in (-1, 1))
        i, j = (slice(max(low[k], 0), max(high[k] + 1, 0)) for k in range(2))
        within = np.hypot(self.x[i, None] - place[0], self.y[None, j] - place[1]) <= radius
        part = self.height[i, j]
        part[within] = np.minimum(part[within], max(float(place[2]), self.bottom))


def chips_along(
    stock: HeightField, start: np.ndarray, end: np.ndarray, radius: float, teeth: int, narrowest: float
) -> tuple[np.ndarray, np.ndarray]:
    """Cut along a straight level way (3,) to (3,): at each step, for each angle of the tool over a pitch, (n, angles)
    the area of the chips per feed per tooth, and the length of the edges. Fins that are narrower than `narrowest` along
    the rim count as nothing."""
    way, step, angles = end - start, STEP / stock.finer, ANGLES * stock.finer
    count = max(int(np.ceil(np.linalg.norm(way) / step)), 1)
    heading = np.arctan2(way[1], way[0])
    # angles are counted from the side on the left of the feed, as a spindle turns that runs clockwise
    angle = 2.0 * np.pi * (np.arange(angles) + 0.5) / angles
    direction = heading + 0.5 * np.pi - angle
    rim = (radius - 0.5 * stock.cell) * np.column_stack([np.cos(direction), np.sin(direction)])
    chip = np.maximum(np.sin(angle), 0.0)
    width = 1 + int(narrowest / (2.0 * np.pi * radius / angles))
    heights = []
    for k in range(1, count + 1):
        before, place = start + way * (k - 1) / count, start + way * k / count
        # ahead of where the tool was: what the next step takes
        heights.append(stock.at(before[:2] + rim + step * way[:2] / np.linalg.norm(way)) - place[2])
        stock.cut(place, radius)
    engaged = grey_opening(np.where(chip > 0.0, np.maximum(heights, 0.0), 0.0), (1, width), mode="wrap")
    area, edge = ((each * engaged).reshape(count, teeth, -1).sum(axis=1) for each in (chip, np.ones(angles)))
    return area, edge


Chips = tuple[np.ndarray, np.ndarray]
"""Of a way: (steps, angles) area of the chips per feed per tooth [mm], and length of the edges [mm]."""


def chips_of_ways(stock: HeightField, tips: np.ndarray, radius: float, teeth: int, narrowest: float) -> list[Chips]:
    """Cut along the ways between tips (n + 1, 3) [mm]. Those that are not level only cut. narrowest: see
    `chips_along`."""
    found = []
    for start, end in pairwise(tips):
        if np.linalg.norm((end - start)[:2]) < 1e-9 or abs(end[2] - start[2]) > 1e-6:
            for share in np.linspace(0.0, 1.0, 20):
                stock.cut(start + share * (end - start), radius)
            found.append((np.zeros((1, 1)), np.zeros((1, 1))))
        else:
            found.append(chips_along(stock, start, end, radius, teeth, narrowest))
    return found


def forces_of(chips: list[Chips], feeds: np.ndarray, teeth: int, turns: float, edge_share: float) -> np.ndarray:
    """(n,) largest force on each way at feeds (n,) [mm/s], with Kc = 1 and Ke as a share of it [mm]; `turns` a second.

    Where the feed is zero it is that of the edges alone.
    """
    largest = [
        (area * feed / (turns * teeth) + edge_share * edge).max(initial=0.0) for (area, edge), feed in zip(chips, feeds)
    ]
    return np.array(largest)
