"""The blocks of a stream, tool by tool."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from toolpace.common.arrays import Floats
from toolpace.controls.export.motion import PlannedMotion
from toolpace.controls.export.rows import Rows
from toolpace.controls.export.tool_changes import tool_changes, tool_lengths

SAME = 1e-9
"""Relative difference of times that are one."""


@dataclass(frozen=True, eq=False)
class Section:
    """What is done with one tool, from rest to rest."""

    tool: str
    """That is put in before; empty for the first, and where its name is not known."""
    length: float
    """Of the tool [m]."""
    q: Floats
    """(k + 1, m) joint positions [m, rad]: where the machine stands, then the end of each block."""

    def words(self, motion: PlannedMotion, tip: bool) -> Floats:
        """(k + 1, m) what blocks say [mm, deg]: joints, or X, Y, Z of the tip in their place."""
        positions: Floats = self.q * motion.shop_units[1]
        if tip:
            columns = [motion.joints.index(axis) for axis in "XYZ"]
            positions[:, columns] = motion.machine.forward(self.q, np.full(len(self.q), self.length))[0] * 1e3
        return positions

    def joints(self, motion: PlannedMotion, words: Floats, tip: bool) -> Floats:
        """(n, m) joint positions [mm, deg] of such words."""
        if not tip:
            return words
        machine = motion.machine
        places = words[:, [motion.joints.index(axis) for axis in "XYZ"]] * 1e-3
        q = machine.joints_at(places, np.radians(words[:, machine.rotary]), np.full(len(words), self.length))
        found: Floats = q * motion.shop_units[1]
        return found

    def sag(self, motion: PlannedMotion, words: Floats, tip: bool) -> Floats:
        """(n - 1, m) how far joints are beside the straight line [mm, deg] in the middle between words (n, m)."""
        if not tip:
            return np.zeros((0, words.shape[1]))
        ends = self.joints(motion, words, tip)
        middle = self.joints(motion, 0.5 * (words[:-1] + words[1:]), tip)
        beside: Floats = middle - 0.5 * (ends[:-1] + ends[1:])
        return beside


def sections_of(motion: PlannedMotion, rows: Rows) -> list[Section]:
    """Rows of a plan, cut where it changes its tool."""
    points = rows.points
    lengths = tool_lengths(motion, points)
    found, tool, base, first = [], "", points.q[0], 1
    for change in tool_changes(motion):
        end = max(int(np.searchsorted(points.t, change.time * (1.0 - SAME))), first)
        on_row = end < len(points) and points.t[end] <= change.time * (1.0 + SAME)
        behind = end + on_row
        if behind > first:
            q = np.concatenate([base[None], points.q[first:behind], *([] if on_row else [change.q[None]])])
            found.append(Section(tool, float(lengths[(first + behind) // 2]), q))
        tool, base, first = change.tool, points.q[end] if on_row else change.q, behind
    if first < len(points):
        q = np.concatenate([base[None], points.q[first:]])
        found.append(Section(tool, float(lengths[(first + len(points)) // 2]), q))
    return found
