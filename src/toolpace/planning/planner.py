"""From a path and a machine to a trajectory: the entry of all planners."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, Any

from toolpace.errors import UsageError

if TYPE_CHECKING:
    from toolpace.axispath.axispath import AxisPath
    from toolpace.machine.limits import Limits
    from toolpace.machine.machine import Machine
    from toolpace.path.path import Path
    from toolpace.trajectory import Trajectory

PLANNERS = ("optimal", "genetic", "second-order")


def plan(
    path: Path | AxisPath,
    machine: Machine | Limits,
    *,
    planner: str = "optimal",
    mesh: int | None = None,
    progress: Callable[[float], None] | None = None,
    **options: Any,
) -> Trajectory:
    """The fastest motion along a path within the limits of a machine.

    A Path needs a Machine; an AxisPath takes a Machine or bare Limits. `mesh` fixes the number of mesh cells of
    each run (default: as many as the motion asks for). `progress` is called with the share done.

    Options of the planner `optimal`: `start` and `end` (EndState, of the first and last run), `guard` (hold the
    limits between nodes, default true), `bound` (report a lower bound of the duration, default true); of
    `genetic`: see `planning/genetic`; of `second-order`, which holds no jerk limit: `start` and `end` (speeds
    only) and `guard`. Raises InfeasibleError where no such motion exists.
    """
    from toolpace.axispath.axispath import AxisPath
    from toolpace.machine.limits import Limits
    from toolpace.machine.machine import Machine

    if isinstance(path, AxisPath):
        axis_path = path
    elif isinstance(machine, Machine):
        axis_path = AxisPath.follow(path, machine)
    else:
        raise UsageError("plan: a path of tool tip and axis needs a machine; bare limits go with an AxisPath")
    limits = machine if isinstance(machine, Limits) else machine.limits
    if len(limits) != len(axis_path.joints):
        raise UsageError(f"plan: limits for {len(limits)} joints, path of {len(axis_path.joints)} joints")
    if not axis_path.runs:
        raise UsageError("plan: the path has no motion")
    if mesh is not None and mesh < 8:
        raise UsageError(f"plan: a mesh of {mesh} cells is too coarse; give at least 8")
    if planner == "optimal":
        from toolpace.planning.optimal.planner import plan_optimal

        return plan_optimal(axis_path, limits, cells=mesh, progress=progress, **options)
    if planner == "genetic":
        from toolpace.planning.genetic.planner import plan_genetic

        return plan_genetic(axis_path, limits, progress=progress, **options)
    if planner == "second-order":
        from toolpace.planning.second_order.planner import plan_second_order

        return plan_second_order(axis_path, limits, cells=mesh, progress=progress, **options)
    raise UsageError(f"plan: unknown planner '{planner}'; known are {', '.join(PLANNERS)}")
