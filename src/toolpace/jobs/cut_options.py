"""By what the cut of a program sets the speed of its plan."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from toolpace.common.arrays import Floats

if TYPE_CHECKING:
    from toolpace.controls.timing.figures import ControlFigures
    from toolpace.cutting.feeds.limited_plan import CutLimitedPlan
    from toolpace.cutting.feeds.rules import FeedRules
    from toolpace.machine.machine import Machine
    from toolpace.programs.reading import ReadOptions
    from toolpace.programs.tolerances import Tolerances
    from toolpace.programs.toolpath import ToolPath


@dataclass(frozen=True)
class CutOptions:
    """What is asked of a plan within its cut."""

    rules: FeedRules
    resolution: float | None = None
    """Size of a cell of the stock [m]; None: the finest that `memory` has room for."""
    memory: float = 1e9
    """Most that the stock takes [bytes]."""

    def plan(
        self,
        toolpath: ToolPath,
        machine: Machine,
        options: ReadOptions,
        tolerances: tuple[float | Tolerances, float | Tolerances],
        effort: str,
        planner: str,
        progress: Callable[[float], None],
    ) -> CutLimitedPlan:
        """The plan of a program; the feeds teach at the speeds that its control reaches. Raises ToolpaceError."""
        from toolpace.controls.timing.program_time import figures_for
        from toolpace.cutting.feeds.limited_plan import plan_within_cut

        learns = self.rules.way == "learned"
        reached = speeds_reached(toolpath, machine, figures_for(options, None)) if learns else None
        return plan_within_cut(
            toolpath, machine, options.setup, self.rules, *tolerances, effort=effort, planner=planner,
            resolution=self.resolution, memory=self.memory, reached=reached, progress=progress,
        )  # fmt: skip


def speeds_reached(toolpath: ToolPath, machine: Machine, figures: ControlFigures) -> Floats:
    """(n,) mean speed of the tip on the way to each point by the model of the control [m/s]; 0 where it stands."""
    from toolpace.controls.timing.program_time import moves_of_points, time_of_moves

    times = time_of_moves(moves_of_points(toolpath, machine), machine, figures).times - toolpath.dwell
    speeds: Floats = np.divide(toolpath.way_length, times, out=np.zeros(len(times)), where=times > 0.0)
    return np.minimum(speeds, np.where(np.isfinite(toolpath.feed), toolpath.feed, speeds))
