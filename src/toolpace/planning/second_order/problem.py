"""A run with its velocity, feed and acceleration limits on a mesh, for the second-order kernel."""

from __future__ import annotations

import numpy as np

from toolpace.common.arrays import Floats
from toolpace.kernels.planners import reachability
from toolpace.machine.limits import Limits
from toolpace.path.axis_run import AxisRun

BOTH_ENDS = np.array([0.0, 1.0])
"""Limits held at both ends of each cell: TOPP-RA's second scheme, and the rows of COPP's second-order planner."""
FIVE = np.linspace(0.0, 1.0, 5)
"""Limits held inside the cells too."""
MOST_OVER_STEADY = 1e12
"""Where nothing limits, z is held below this multiple of what limits allow elsewhere at steady speed."""
COLLAPSED = 1e-3
"""Share of z at the start of a cell below which it must not fall at its end, inside a run."""
MOST_CALMED = 20
CHUNK = 100_000
"""Points of a path that are evaluated at a time, to keep memory low."""
SHORTEST = 1e-9
"""Time in which nothing crosses a run [s]: what is faster has no limit."""


class Cells:
    """The rows of a run: at `place` (p,) of each cell, both sides of a break of the path apart."""

    def __init__(self, run: AxisRun, limits: Limits, nodes: Floats, place: Floats = BOTH_ENDS) -> None:
        self.nodes, self.place = nodes, place
        n = len(nodes) - 1
        broken = np.flatnonzero(np.isin(nodes, run.breaks))
        inner = nodes[:-1, None] + np.diff(nodes)[:, None] * place[1:-1]
        self.s = np.concatenate([nodes, np.nextafter(nodes[broken], -np.inf), inner.ravel()])
        """(points,) where limits are rows: the nodes, the left sides of breaks, the places inside."""
        self.at = np.empty((n, len(place)), dtype=np.int64)
        """(n, p) which of the points each place is."""
        self.at[:, 0], self.at[:, -1] = np.arange(n), np.arange(1, n + 1)
        self.at[broken - 1, -1] = n + 1 + np.arange(len(broken))
        self.at[:, 1:-1] = n + 1 + len(broken) + np.arange(inner.size).reshape(inner.shape)
        self.q1, self.q2 = np.empty((2, len(self.s), len(limits)))
        self.cap = np.empty(len(self.s))
        for first in range(0, len(self.s), CHUNK):
            part = slice(first, first + CHUNK)
            q = run.evaluate(self.s[part])
            self.q1[part], self.q2[part] = q[1] / limits.acceleration, q[2] / limits.acceleration
            with np.errstate(divide="ignore"):
                by_velocity = (limits.velocity / np.abs(q[1])).min(axis=1)
            self.cap[part] = np.minimum(by_velocity, run.speed_cap(self.s[part])) ** 2
        self.steady = np.minimum(self.cap, 1.0 / np.maximum(np.abs(self.q2).max(axis=1), 1e-300))
        """(points,) most z at steady speed."""
        limited = self.steady[self.steady < 1e300]
        self.ceiling = min(((run.s1 - run.s0) / SHORTEST) ** 2, MOST_OVER_STEADY * float(limited.max(initial=np.inf)))
        """z that is enough where no limit holds the motion, since no joint moves that has one."""
        self.tight = np.ones((n, 2))
        """(n, 2) factors by which the speed and acceleration limits of the cells are lowered."""
        self.calm = np.zeros(n, dtype=np.bool_)
        """(n,) cells with zero inertia inside, which are passed no faster than at steady speed."""

    @property
    def unlimited(self) -> bool:
        """Whether nothing at all limits the motion."""
        return not (np.isfinite(self.cap).any() or self.q1.any() or self.q2.any())

    def top(self, z0: float, z1: float) -> Floats:
        """(n + 1,) most z at the nodes; what is given at the ends is allowed there."""
        at_ends = self.cap[self.at[:, [0, -1]]] / self.tight[:, :1] ** 2
        top = np.full(len(self.nodes), self.ceiling)
        top[:-1] = np.minimum(top[:-1], at_ends[:, 0])
        top[1:] = np.minimum(top[1:], at_ends[:, 1])
        calm = np.flatnonzero(self.calm)
        steady = self.steady[self.at[calm]].min(axis=1) / self.tight[calm].max(axis=1) ** 2
        np.minimum.at(top, calm, steady)
        np.minimum.at(top, calm + 1, steady)
        top[[0, -1]] = np.maximum(top[[0, -1]], [z0, z1])
        return top

    def arrays(self, top: Floats) -> reachability.Rows:
        """The rows as the kernel takes them, with caps `top` (n + 1,) of the nodes."""
        return reachability.Rows(np.diff(self.nodes), self.at, self.place, self.tight, self.q1, self.q2, self.cap, top)

    def solve(self, z0: float, z1: float) -> tuple[Floats, int, int]:
        """The highest z (n + 1,) from z0 to z1, how it went, and at which node it failed (see the kernel).

        Where a joint's q' changes sign in a cell (zero inertia), a fast start of the cell may leave no speed at its
        end. Such cells are passed at steady speed then: with x and y below 1 / |q''| its rows hold whatever they are.
        """
        for _ in range(MOST_CALMED):
            top = self.top(z0, z1)
            z, status, node = reachability.solve(self.arrays(top), z0, z1)
            fallen = (z[1:-1] <= COLLAPSED * np.minimum(z[:-2], top[1:-1])) & ~self.calm[:-1]
            if status != reachability.FEASIBLE or not fallen.any():
                break
            self.calm[:-1] |= fallen
        return z, status, node

    def rows(self, k: int) -> Floats:
        """(p, joints, 2) coefficients of z at both ends of the cell k: its acceleration rows, |row . (x, y)| <= 1."""
        f = self.place[:, None]
        q1, q2 = (value[self.at[k]] * self.tight[k, 1] for value in (self.q1, self.q2))
        slope = q1 / (2.0 * (self.nodes[k + 1] - self.nodes[k]))
        return np.stack([q2 * (1.0 - f) - slope, q2 * f + slope], axis=-1)
