"""A check that the tip keeps to its side of the program."""

from __future__ import annotations

import numpy as np

from toolpace.common.arrays import Floats, Ints
from toolpace.judge.matching.alignment import Alignment
from toolpace.judge.rows import MotionRow
from toolpace.judge.verification import Check
from toolpace.motion.setpoints import SetPoints


def side_check(
    points: SetPoints,
    motion: MotionRow,
    there: Alignment,
    line: Floats,
    owner: Ints,
    outward: Floats,
    unit: float,
    granted: float,
) -> Check:
    """How deep the tip gets below the planes through its places on the program, upright on the normals `outward` (n, 3)
    of the program's points.

    A pose of the motion may belong to several places within tolerance: that on which it is the furthest out counts.
    `line` (m, 6) is the program in tolerances of which the tip's is `unit` [m], with the point `owner` (m,) that each
    pose is or leads to; `granted` [m] is what may be below.
    """
    normals = along_line(outward, owner)
    pose = np.repeat(np.arange(len(there.place)), np.diff(there.begin))
    above = [_above(motion.poses, line, normals, np.arange(len(there.place)), there.place)]
    low, high = (_above(motion.poses, line, normals, pose, each[: len(pose)]) for each in (there.low, there.high))
    above.append(np.maximum.reduceat(np.maximum(low, high), there.begin[:-1]))
    depth = -unit * np.maximum(*above) - unit * motion.allowance
    k = int(np.argmax(depth))
    deepest = max(float(depth[k]), 0.0)
    block = int(points.block[motion.first[k]])
    return Check(
        "tip, on the wrong side", deepest, granted, "m", deepest <= granted, float(motion.early[k]), block,
        noise=float(motion.allowance[k]) * unit,
    )  # fmt: skip


def along_line(outward: Floats, owner: Ints) -> Floats:
    """(m, 3) unit vectors at the poses of a program's line, from those at its points (n, 3)."""
    begins = np.flatnonzero(np.diff(owner, prepend=-1) > 0)
    count = np.diff(np.append(begins, len(owner)))
    share = (np.arange(len(owner)) - np.repeat(begins, count) + 1.0) / np.repeat(count, count)
    before = outward[np.maximum(owner - 1, 0)]
    return _unit(before + share[:, None] * (outward[owner] - before))


def _above(poses: Floats, line: Floats, normals: Floats, pose: Ints, place: Floats) -> Floats:
    """(k,) how far poses lie above places of the line, along the normals there [tolerances]."""
    here = np.clip(np.floor(place).astype(np.int64), 0, len(line) - 2)
    share = (place - here)[:, None]
    tip = line[here, :3] + share * (line[here + 1, :3] - line[here, :3])
    normal = _unit(normals[here] + share * (normals[here + 1] - normals[here]))
    return np.asarray(np.einsum("ka,ka->k", poses[pose, :3] - tip, normal))


def _unit(vectors: Floats) -> Floats:
    length = np.linalg.norm(vectors, axis=1)[:, None]
    return np.asarray(vectors / np.where(length > 0.0, length, 1.0))
