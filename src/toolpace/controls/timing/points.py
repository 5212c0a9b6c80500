"""Points of cutter-location data and tables as moves: straight, in tool-centre-point mode, as a post would write."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from toolpace.programs.commanded import BLENDED, Commanded
from toolpace.programs.toolpath import ToolPath

if TYPE_CHECKING:
    from toolpace.machine.machine import Machine

STILL = 1e-12
"""Way of the tip [m] below which it stands."""


def moves_of_points(toolpath: ToolPath, machine: Machine) -> Commanded:
    """A move to each point. Raises ReachError where the machine cannot follow the tool axes."""
    rotary = machine.choose_rotary(toolpath)
    words = np.hstack([toolpath.tip, rotary])
    way = np.diff(words, axis=0, prepend=words[:1])
    way[:, :3] = toolpath.tip - toolpath.way_start
    length = np.linalg.norm(way[:, :3], axis=1)
    length[length < STILL] = 0.0
    direction = way[:, :3] / np.where(length > 0.0, length, np.inf)[:, None]
    count = len(words)
    return Commanded(
        words=words,
        way=way,
        rotary_joints=tuple(machine.joints[i] for i in machine.rotary),
        tip_mode=np.ones(count, dtype=bool),
        tool_length=toolpath.tool_length,
        rapid=toolpath.rapid,
        speed=toolpath.feed,
        turn=np.full(count, np.inf),
        time=toolpath.least_time,
        length=length,
        begin=direction,
        end=direction.copy(),
        radius=np.full(count, np.inf),
        centre=np.full((count, 3), np.nan),
        normal=np.zeros((count, 3)),
        sweep=np.zeros(count),
        line=toolpath.block,
        stop=toolpath.stop,
        joining=np.full(count, BLENDED),
        tolerance=np.full(count, np.inf),
        cam_tolerance=np.full(count, np.nan),
        dwell=toolpath.dwell,
        operation=toolpath.operation,
        operations=toolpath.operations,
        blocks=toolpath.blocks,
        source=toolpath.source,
    )
