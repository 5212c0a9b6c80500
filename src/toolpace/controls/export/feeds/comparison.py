"""A check that a program with other feeds is the same path, block for block."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from toolpace.common.arrays import Bools, Floats
from toolpace.controls.export.feeds.block_times import Passes, pose
from toolpace.controls.export.feeds.job import Job
from toolpace.controls.export.feeds.rewriting import Rewritten
from toolpace.programs.toolpath import ToolPath

CUT_TIP, CUT_AXIS = 1e-6, 1e-5
"""How far places at which a block is cut may lie beside its way as it was read [m], [rad]."""


def in_old_blocks(toolpath: ToolPath, new: Rewritten) -> ToolPath:
    """The path of a program that was written anew, its blocks named as they were before."""
    return replace(toolpath, block=new.back[toolpath.block])


def strays(job: Job, new: Rewritten, again: ToolPath) -> Bools:
    """(k,) passes whose way is another than before; all of them where it has other blocks."""
    old, again = job.toolpath, in_old_blocks(again, new)
    was, now = job.passes, Passes.of(again)
    if len(now.block) != len(was.block) or (now.block != was.block).any():
        return np.ones(len(was.block), dtype=np.bool_)
    found = np.zeros(len(was.block), dtype=np.bool_)
    for k, (a, b, c, d) in enumerate(zip(was.first, was.last, now.first, now.last)):
        before, behind = slice(a - 1, b + 1), slice(c - 1, d + 1)
        ends = old.stop[b] == again.stop[d] and old.dwell[b] == again.dwell[d] and was.rapid[k] == now.rapid[k]
        if b - a == d - c and (old.tip[before] == again.tip[behind]).all():
            same = bool((old.axis[before] == again.axis[behind]).all())
        else:
            tip, axis = off_the_way(old.tip[before], old.axis[before], again.tip[behind], again.axis[behind])
            same = tip <= CUT_TIP and axis <= CUT_AXIS
        found[k] = not (same and ends)
    return found


def off_the_way(tip: Floats, axis: Floats, tips: Floats, axes: Floats) -> tuple[float, float]:
    """How far points (n, 3) lie beside the polygon through (k, 3): distance [m] and angle [rad]; both end alike."""
    corners, points = pose(tip, axis), pose(tips, axes)
    step = np.diff(corners, axis=0)
    length = np.maximum((step**2).sum(axis=1), 1e-300)
    far = [float(np.linalg.norm(tips[-1] - tip[-1]))]
    turned = [float(np.linalg.norm(axes[-1] - axis[-1]))]
    for point, here, leaning in zip(points, tips, axes):
        share = np.clip(((point - corners[:-1]) * step).sum(axis=1) / length, 0.0, 1.0)
        near = corners[:-1] + share[:, None] * step
        k = int(((near - point) ** 2).sum(axis=1).argmin())
        far.append(float(np.linalg.norm(tip[k] + share[k] * (tip[k + 1] - tip[k]) - here)))
        turned.append(float(np.linalg.norm(axis[k] + share[k] * (axis[k + 1] - axis[k]) - leaning)))
    return max(far), max(turned)


def largest_change_of_kept(job: Job, new: Rewritten, again: ToolPath) -> float:
    """Largest relative change of the time that the feeds make of blocks that keep theirs."""
    before = job.passes.asked_times(job.toolpath)
    now = Passes.of(in_old_blocks(again, new)).asked_times(again)
    kept = job.rewriting.kept & np.isfinite(before) & (before > 0.0)
    return float(np.abs(now[kept] / before[kept] - 1.0).max(initial=0.0))
