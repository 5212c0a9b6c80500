"""Rows that a follower sends to the server of its page: figures of one set-point in 64 bits each."""

from __future__ import annotations

import struct
from typing import NamedTuple

KINDS = ("velocity", "acceleration", "jerk")
HEAD = struct.Struct("<3dq")
"""Time on the follower's clock [s], time of the path [s], pace, and status."""
DERIVATIVES = 4
"""Positions and three derivatives."""


class Row(NamedTuple):
    """A set-point."""

    t: float
    path_time: float
    pace: float
    status: int
    motion: tuple[tuple[float, ...], ...]
    """(4, m) joints and derivatives by time, path and correction together [m or rad]."""
    correction: tuple[tuple[float, ...], ...]
    """(4, m) what of it is correction."""
    deflection: tuple[float, ...]
    """(3,) what was measured [m]; nan where nothing was."""


class RowForm:
    """How rows of a number of joints are written."""

    def __init__(self, joints: int) -> None:
        self.joints = joints
        self._figures = struct.Struct(f"<{2 * DERIVATIVES * joints + 3}d")
        self.size = HEAD.size + self._figures.size
        """Bytes of a row: fewer than a pipe takes at once, whole or not at all (POSIX: 512)."""

    def unpack(self, data: bytes) -> Row:
        """The row of `size` bytes."""
        m, whole = self.joints, self._figures.unpack_from(data, HEAD.size)
        parts = [whole[k * m : (k + 1) * m] for k in range(2 * DERIVATIVES)]
        t, path_time, pace, status = HEAD.unpack_from(data)
        return Row(t, path_time, pace, status, tuple(parts[:DERIVATIVES]), tuple(parts[DERIVATIVES:]), whole[-3:])
