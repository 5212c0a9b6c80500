"""A run's path at the places of its meshes: one that is cut keeps its nodes, and they are not asked at again."""

from __future__ import annotations

import threading

import numpy as np

from toolpace.arrays import Floats
from toolpace.axispath.run import AxisRun


class KnownPath:
    """Path and cap of a run, asked once at each place and remembered: for runs that are solved in one piece."""

    def __init__(self, run: AxisRun) -> None:
        self._run, self._lock = run, threading.Lock()
        self._place = np.empty(0)
        """(n,) where it is known, ascending."""
        self._path, self._cap = np.empty((0, 4, 0)), np.empty(0)
        """(n, 4, joints) and (n,) there."""

    def with_cap(self, s: Floats) -> tuple[Floats, Floats]:
        """Path (4, n, joints) and cap (n,) on ds/dt at s (n,), as AxisRun.with_cap tells them."""
        with self._lock:
            known = np.append(self._place, np.nan)[np.searchsorted(self._place, s)] == s
        fresh = np.unique(s[~known])
        if len(fresh):
            self._learn(fresh, *self._run.with_cap(fresh))
        with self._lock:
            at = np.searchsorted(self._place, s)
            return np.ascontiguousarray(self._path[at].transpose(1, 0, 2)), self._cap[at]

    def _learn(self, fresh: Floats, path: Floats, cap: Floats) -> None:
        """Remember the path (4, n, joints) and the cap (n,) at places (n,), ascending; two threads may learn one."""
        with self._lock:
            if not len(self._place):
                self._place, self._path, self._cap = fresh, path.transpose(1, 0, 2), np.asarray(cap)
                return
            new = ~np.isin(fresh, self._place)
            before = np.searchsorted(self._place, fresh[new])
            self._place = np.insert(self._place, before, fresh[new])
            self._path = np.insert(self._path, before, path[:, new].transpose(1, 0, 2), axis=0)
            self._cap = np.insert(self._cap, before, np.asarray(cap)[new])
