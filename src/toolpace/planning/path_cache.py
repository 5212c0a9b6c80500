"""A joint run that remembers its evaluations at mesh nodes."""

from __future__ import annotations

import threading

import numpy as np

from toolpace.common.arrays import Floats
from toolpace.path.axis_run import AxisRun


class CachedPath:
    """Path and cap of a run, asked once at each place and remembered: for runs that are solved in one piece."""

    def __init__(self, run: AxisRun) -> None:
        self._run, self._lock = run, threading.Lock()
        self._place = np.empty(0)
        """(n,) where it is known, ascending."""
        self._path, self._cap = np.empty((4, 0, 0)), np.empty(0)
        """(4, n, joints) and (n,) there."""

    def with_cap(self, s: Floats) -> tuple[Floats, Floats]:
        """Path (4, n, joints) and cap (n,) on ds/dt at s (n,), as AxisRun.with_cap tells them."""
        with self._lock:
            known = np.append(self._place, np.nan)[np.searchsorted(self._place, s)] == s
        if not known.all():
            fresh = np.unique(s[~known])
            self._learn(fresh, *self._run.with_cap(fresh))
        with self._lock:
            at = np.searchsorted(self._place, s)
            return self._path.take(at, axis=1), self._cap.take(at)

    def _learn(self, fresh: Floats, path: Floats, cap: Floats) -> None:
        """Remember the path (4, n, joints) and the cap (n,) at places (n,), ascending; two threads may learn one."""
        with self._lock:
            if not len(self._place):
                self._place, self._path, self._cap = fresh, np.ascontiguousarray(path), np.asarray(cap)
                return
            before = np.searchsorted(self._place, fresh)
            new = np.append(self._place, np.nan)[before] != fresh
            order = np.argsort(np.concatenate([self._place, fresh[new]]), kind="stable")
            self._place = np.concatenate([self._place, fresh[new]])[order]
            self._path = np.concatenate([self._path, path[:, new]], axis=1).take(order, axis=1)
            self._cap = np.concatenate([self._cap, np.asarray(cap)[new]])[order]
