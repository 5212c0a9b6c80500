"""The model `linuxcnc`: interpreter and trajectory planner of LinuxCNC 2.9, cycle by cycle.

Source: LinuxCNC's documents ("Trajectory Control" and section TRAJ of the ini file), and what its source does
(src/emc/task/emccanon.cc, src/emc/tp); held against its own runs in benchmarks/results/linuxcnc_times.md.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING

import numpy as np

from toolpace.common.arrays import Floats
from toolpace.common.errors import UsageError
from toolpace.controls.timing.linuxcnc_blocks import Canon, Waits
from toolpace.programs.commanded import Commanded

if TYPE_CHECKING:
    from toolpace.kernels.linuxcnc.blocks import Blocks
    from toolpace.machine.machine import Machine


MOST_CYCLES = 2e7
"""In which speeds change: about two seconds of work, for six hours of ramps. Of accelerations so small that there would
be more the cycles are longer: a block's end is then known to a cycle of these, of which the motion has so many."""


@dataclass(frozen=True)
class LinuxCNC:
    """Settings of the controller, by the names of its ini file."""

    cycle: float = 1e-3
    """SERVO_PERIOD [s]."""
    path_velocity: float = 1e9
    """MAX_LINEAR_VELOCITY of TRAJ [mm/s]."""
    most_override: float = 1.0
    """MAX_FEED_OVERRIDE: corners are planned for feeds so much higher."""
    kink_ratio: float = 0.1
    """ARC_BLEND_KINK_RATIO."""
    depth: int = 50
    """ARC_BLEND_OPTIMIZATION_DEPTH."""
    gap_cycles: int = 4
    """ARC_BLEND_GAP_CYCLES."""
    ramp_frequency: float = 100.0
    """ARC_BLEND_RAMP_FREQ [Hz]."""
    waits: Waits = field(default_factory=Waits)


def linuxcnc_times(moves: Commanded, machine: Machine, settings: LinuxCNC | None = None) -> Floats:
    """Time of each move (n,) [s], dwells left out: from the end of the one before, overlaps included.

    Raises UsageError for a block whose end the planner would not get to.
    """
    from toolpace.kernels.linuxcnc.blocks import Control
    from toolpace.kernels.linuxcnc.program import cycles_of

    settings = settings or LinuxCNC()
    canon = Canon(moves, machine, settings.waits)
    if not len(canon.blocks.figures):
        return np.zeros(len(moves))
    cycle = settings.cycle * max(1.0, _ramped(canon.blocks) / (MOST_CYCLES * settings.cycle))
    control = Control(
        cycle, canon.velocity[:3].copy(), canon.acceleration[:3].copy(), settings.path_velocity,
        settings.most_override, settings.kink_ratio, settings.depth, settings.gap_cycles, settings.ramp_frequency,
    )  # fmt: skip
    ended = cycles_of(canon.blocks, control)
    if np.any(ended < 0):
        row = canon.rows.of[canon.ends[int(np.argmax(ended < 0))]]
        raise UsageError(
            f"{moves.source}, line {moves.line[row]}: LinuxCNC would not get to the end of this block; check its F"
        )
    return canon.times(ended.astype(float) * cycle)


def _ramped(blocks: Blocks) -> float:
    """How long blocks need at most to speed up and slow down, each from rest to rest [s]."""
    from toolpace.kernels.linuxcnc.blocks import OF_ACCELERATION, OF_LENGTH, OF_TOP

    length, top, acceleration = (blocks.figures[:, column] for column in (OF_LENGTH, OF_TOP, OF_ACCELERATION))
    return float(2.0 * np.minimum(np.sqrt(length / acceleration), top / acceleration).sum())
