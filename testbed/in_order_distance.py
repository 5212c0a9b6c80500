"""The in-order distance of two polylines of poses, decided over all pairs: slow, exact, and of nobody else's making.

Fréchet's distance after Alt and Godau (1995), by dynamic programming over the whole free-space diagram. A pose is six
numbers, tip and tool axis in their tolerances, and two poses are as far apart as the larger of both halves says.
"""

from __future__ import annotations

import numpy as np


def distance_of_poses(a, b):
    """Distances (...) of poses (..., 6)."""
    d = np.asarray(a) - np.asarray(b)
    return np.maximum(np.linalg.norm(d[..., :3], axis=-1), np.linalg.norm(d[..., 3:], axis=-1))


def free_intervals(points, line, radius):
    """(n, m - 1, 2) shares of each way of a line (m, 6) that are within the radius of each point (n, 6); nan: none."""
    a, d = line[None, :-1], np.diff(line, axis=0)[None]
    low, high = np.zeros((len(points), len(line) - 1)), np.ones((len(points), len(line) - 1))
    for half in (slice(0, 3), slice(3, 6)):
        # |a + u d - p|^2 = radius^2, solved as it stands
        square = (d[..., half] ** 2).sum(-1) + 0.0 * low
        slope = 2.0 * (d[..., half] * (a - points[:, None])[..., half]).sum(-1)
        rest = ((a - points[:, None])[..., half] ** 2).sum(-1) - radius**2
        under = slope**2 - 4.0 * square * rest
        with np.errstate(all="ignore"):
            root = np.sqrt(under)
            first, second = (-slope - root) / (2.0 * square), (-slope + root) / (2.0 * square)
        still = square == 0.0
        first = np.where(still, np.where(rest <= 0.0, 0.0, np.nan), first)
        second = np.where(still, np.where(rest <= 0.0, 1.0, np.nan), second)
        low, high = np.maximum(low, first), np.minimum(high, second)
    none = ~(low <= high)
    return np.where(none[..., None], np.nan, np.stack((low, high), axis=-1))


def within_in_order(p, q, radius) -> bool:
    """Whether two walkers can go along p (n, 6) and q (m, 6), never back, and stay within the radius."""
    if distance_of_poses(p[0], q[0]) > radius or distance_of_poses(p[-1], q[-1]) > radius:
        return False
    left = free_intervals(p, q, radius).tolist()  # at point i of p, along q
    floor = free_intervals(q, p, radius).tolist()  # at point j of q, along p
    n, m = len(p) - 1, len(q) - 1
    nan = float("nan")
    # what can be reached: all of a border from some share on
    reached_left = [[nan] * m for _ in range(n + 1)]
    reached_floor = [[nan] * n for _ in range(m + 1)]
    for j in range(m):
        if left[0][j][0] == 0.0 and (j == 0 or (reached_left[0][j - 1] == 0.0 and left[0][j - 1][1] == 1.0)):
            reached_left[0][j] = 0.0
    for i in range(n):
        if floor[0][i][0] == 0.0 and (i == 0 or (reached_floor[0][i - 1] == 0.0 and floor[0][i - 1][1] == 1.0)):
            reached_floor[0][i] = 0.0
    for i in range(n):
        for j in range(m):
            from_left, from_floor = reached_left[i][j], reached_floor[j][i]
            low, high = left[i + 1][j]
            if from_floor == from_floor:
                reached_left[i + 1][j] = low
            elif from_left == from_left and max(low, from_left) <= high:
                reached_left[i + 1][j] = max(low, from_left)
            low, high = floor[j + 1][i]
            if from_left == from_left:
                reached_floor[j + 1][i] = low
            elif from_floor == from_floor and max(low, from_floor) <= high:
                reached_floor[j + 1][i] = max(low, from_floor)
    ends = (reached_left[n][m - 1], left[n][m - 1][1]), (reached_floor[m][n - 1], floor[m][n - 1][1])
    return any(low == low and high >= 1.0 - 1e-12 for low, high in ends)


def in_order_distance(p, q, accuracy: float = 1e-6) -> float:
    """The distance itself, by bisection."""
    low, high = 0.0, float(distance_of_poses(p[:, None], q[None]).max())
    if within_in_order(p, q, low):
        return 0.0
    while high - low > accuracy * high:
        middle = 0.5 * (low + high)
        low, high = (low, middle) if within_in_order(p, q, middle) else (middle, high)
    return high
