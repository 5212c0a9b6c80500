"""The lower bound of the continuous problem for a whole plan, independent of any mesh."""

from __future__ import annotations

from dataclasses import replace

from toolpace.common.workers import Workers
from toolpace.motion.laws import SplineLaw
from toolpace.motion.trajectory import Trajectory
from toolpace.planning.bound.continuous import FEWEST, continuous_bound

CHEAP = 40_000
"""Cells of all runs together up to which this bound is cheap: a second or two of the machine's time."""


def is_cheap(trajectory: Trajectory) -> bool:
    """Whether the bound takes little beside reading, fitting and judging a program."""
    laws = trajectory.laws
    return all(isinstance(law, SplineLaw) for law in laws) and cells(trajectory) <= CHEAP


def cells(trajectory: Trajectory) -> int:
    """Cells of the meshes on which the bound is worked out."""
    return sum(max(FEWEST, len(law.nodes)) for law in trajectory.laws if isinstance(law, SplineLaw))


def with_continuous_bound(trajectory: Trajectory, workers: Workers | None = None) -> Trajectory:
    """The same plan with its bound of the continuous problem; 0 where one of its runs has none."""
    axis_path, limits = trajectory.axis_path, trajectory.limits
    pairs = [(run, law) for run, law in zip(axis_path.runs, trajectory.laws) if isinstance(law, SplineLaw)]
    found = (workers or Workers()).each(lambda k: continuous_bound(pairs[k][0], limits, pairs[k][1]), range(len(pairs)))
    known = len(pairs) == len(trajectory.laws) and all(seconds > 0.0 for seconds in found)
    dwells = axis_path.first_dwell + sum(run.dwell for run in axis_path.runs)
    return replace(trajectory, continuous_bound=sum(found) + dwells if known else 0.0)
