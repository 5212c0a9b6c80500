"""A new trajectory from the instant at which the tool is found off its path.

replan: a trajectory, a time, a deflection
  the joints at which the tool was found, and how far they are off the commanded motion
  where to rejoin the path: the projection of the deflection on it, a given place, or wherever it is best
  the detour that costs least time
  the law of the detour and of the rest of its run
  the runs behind it, as they were
"""

from __future__ import annotations

import time as clock
from typing import TYPE_CHECKING

import numpy as np
import numpy.typing as npt

from toolpace.axispath.axispath import AxisPath
from toolpace.deflect.commanded import CommandedMotion, moment
from toolpace.deflect.detour import DetourRun
from toolpace.deflect.direct import direct_law
from toolpace.deflect.feasibility import Feasibility
from toolpace.deflect.pose import deflected_pose, offset_in_words
from toolpace.deflect.rejoin import rejoin_time
from toolpace.deflect.search import shortest_detour
from toolpace.deflect.timing import timing_of
from toolpace.errors import InfeasibleError, UsageError
from toolpace.machine.machine import Machine
from toolpace.planning.planner import Planner
from toolpace.trajectory import Trajectory

if TYPE_CHECKING:
    from toolpace.planning.genetic.planner import Genetic
    from toolpace.planning.optimal.planner import Optimal


def replan(
    trajectory: Trajectory,
    time: float,
    deflection: npt.ArrayLike,
    machine: Machine | None = None,
    *,
    axis: npt.ArrayLike | None = None,
    planner: str | Optimal | Genetic | Planner = "optimal",
    rejoin: str | float = "fastest",
    interval: tuple[float, float] | None = None,
    **options: object,
) -> Trajectory:
    """The motion from `time` [s] on, at which the tip is found at `deflection` (3,) [m] and the tool axis at `axis`.

    Without a machine `deflection` holds the joints (m,). The position is what was measured; velocities and
    accelerations of the joints go on as commanded, and everything from then on keeps to every limit. The tool rejoins
    the path where the whole takes least time ("fastest"), at the parameter `rejoin`, or, as in the paper, at the
    "projection" of the deflection on the path or on the `interval` (from s, to s) of it; from there it stays on it.

    `planner` is an object, or in short the name of one with its `options`, as for `plan`: "optimal" times detour and
    rest of the run anew, and so does a planner of one's own; "genetic" (the paper's) the detour and the way on to the
    next reference point; "direct" keeps to the motion from which both start. The feed holds for the tip on the detour;
    where the deflection itself has made the commanded joint velocities a faster tip, the excess fades. Raises
    UsageError for arguments that make no sense, and InfeasibleError, with the figures, where no way back within limits
    and travel exists.
    """
    began = clock.perf_counter()
    timing = timing_of(planner, options)
    check_replannable(trajectory, time)
    machine = machine or trajectory.axis_path.machine

    index, local = moment(trajectory, time)
    commanded = CommandedMotion.of(trajectory, index)
    pose = deflected_pose(trajectory, time, deflection, machine, axis=axis)
    offset = pose - commanded.motion(np.array([local]))[0, 0]
    feasibility = Feasibility(commanded, trajectory.limits, machine, local, offset)

    target = rejoin_time(commanded, deflection, rejoin, interval)
    detour = shortest_detour(feasibility, target)
    if detour is None and feasibility.relax():
        detour = shortest_detour(feasibility, target)
    if detour is None:
        raise InfeasibleError(
            f"deflection at {time:.6g} s: no way back to the path within limits and travel; the joints are off by"
            f" {offset_in_words(offset, trajectory.joints, machine)}, and the nearest detour takes"
            f" {feasibility.nearest:.6g} of {feasibility.nearest_of}"
        )

    run = DetourRun(detour, machine, feasibility.excess)
    law = direct_law(run)
    if not run.ends_here:
        law = timing.law(run, trajectory.limits, law)

    following = index if run.ends_here and run.join <= commanded.run.s0 else index + 1
    path = AxisPath((run, *trajectory.axis_path.runs[following:]), trajectory.joints, machine)
    laws = (law, *trajectory.laws[following:])
    return Trajectory(path, trajectory.limits, laws, planner=timing.name, solve_seconds=clock.perf_counter() - began)


def check_replannable(trajectory: Trajectory, time: float) -> None:
    """Raise UsageError where the trajectory has no such time, or no way back from it could keep to jerk limits."""
    if not 0.0 <= time <= trajectory.duration:
        raise UsageError(f"replan: time {time:g} s is not within the trajectory's {trajectory.duration:.6g} s")
    if any(law.jumps.size for law in trajectory.laws):
        raise UsageError(
            f"replan: accelerations jump in a plan of planner {trajectory.planner}, so no way back from it can keep to"
            " jerk limits; plan with planner optimal"
        )
