"""Which side of a break is meant: a function is never asked at a break itself, but a few roundings beside it.

A break is told as a number, and so is where a function changes over; the two may differ by their last digits. At such
a place the function would answer for the wrong side.
"""

from __future__ import annotations

import numpy as np

from toolpace.common.arrays import Floats

ROUNDINGS = 8.0
"""How far aside it is asked, and how far the function's own break may be from what is told, in roundings of s."""


class Sides:
    """Breaks of a run from s0 to s1; those that lie within rounding of each other are one."""

    def __init__(self, breaks: Floats, s0: float, s1: float) -> None:
        """Take the breaks (k,) in order."""
        self.width = ROUNDINGS * float(np.spacing(max(abs(s0), abs(s1))))
        inside = breaks[(breaks > s0) & (breaks < s1)]
        new = np.diff(inside, prepend=-np.inf) > 3.0 * self.width
        self.first, self.last = inside[new], inside[np.append(new[1:], True)] if len(inside) else inside
        # what is an end of the run but for rounding has one side only
        at_start, at_end = self.first <= s0 + 2.0 * self.width, self.last >= s1 - 2.0 * self.width
        self.only_right, self.only_left = at_start, at_end & ~at_start
        self.breaks: Floats = self.first[~at_start & ~at_end]
        """(j,) the breaks inside the run, each told once."""

    def aside(self, s: Floats) -> Floats:
        """(n,) where to ask for the path at s (n,): what is at a break, or above it, belongs to its right side."""
        if len(self.first) == 0:
            return s
        after = np.searchsorted(self.first, s, side="right") - 1
        k = np.maximum(after, 0)
        right = (after >= 0) & (s < self.last[k] + self.width)
        out = np.where(right, np.where(self.only_left[k], self.first[k] - self.width, self.last[k] + self.width), s)
        k = np.minimum(after + 1, len(self.first) - 1)
        left = (after + 1 < len(self.first)) & (s > self.first[k] - self.width) & ~right
        aside: Floats = np.where(
            left, np.where(self.only_right[k], self.last[k] + self.width, self.first[k] - self.width), out
        )
        return aside
