"""The report of a plan: one HTML page that opens without a network."""

from __future__ import annotations

import importlib
import os
from typing import TYPE_CHECKING

from toolpace.common.errors import UsageError
from toolpace.common.files import whole_file
from toolpace.motion.setpoints import SetPointSource

if TYPE_CHECKING:
    from toolpace.cutting.simulation.simulate import CutSimulation
    from toolpace.judge import Verification
    from toolpace.motion.trajectory import Trajectory
    from toolpace.programs.reading.coordinates.setup import SetUp
    from toolpace.programs.toolpath import ToolPath
    from toolpace.results.report.charts import Curves
    from toolpace.results.report.key_figures import PlanFigures

__all__ = ["follow_report", "limit_shares", "report", "write_report"]


def __getattr__(name: str) -> object:
    """What speaks of followed runs is loaded when it is asked for."""
    if name in ("follow_report", "limit_shares"):
        return getattr(importlib.import_module("toolpace.results.report.followed"), name)
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")


def report(
    trajectory: Trajectory,
    path: str | os.PathLike[str],
    toolpath: ToolPath | None = None,
    verification: Verification | None = None,
    dt: float = 1e-3,
) -> None:
    """Write the report of a trajectory, sampled every `dt` [s], as one HTML file, whole or not at all.

    With the tool path its feeds are shown beside the tip's speed; with a verification, its verdict. The file
    holds all it needs (half a MB of it is three.js) and at most 40 000 points of each curve: of a longer
    motion, the least and the largest value of each stretch, so that no peak is lost.
    """
    from toolpace.programs.toolpath import check_toolpath

    if not hasattr(trajectory, "sample"):
        raise UsageError(f"report: {type(trajectory).__name__} in place of a trajectory; give what plan returns")
    if toolpath is not None:
        check_toolpath(toolpath, "report")
    if verification is not None and not hasattr(verification, "checks"):
        raise UsageError(f"report: {type(verification).__name__} in place of a verification; give what verify returns")
    write_report(path, trajectory, trajectory.sample(dt), toolpath, verification)


def write_report(
    path: str | os.PathLike[str],
    trajectory: Trajectory,
    setpoints: SetPointSource,
    toolpath: ToolPath | None = None,
    verification: Verification | None = None,
    figures: PlanFigures | None = None,
    curves: Curves | None = None,
    program: bytes | None = None,
    setup: SetUp | None = None,
    cut: CutSimulation | None = None,
) -> None:
    """Write the report from set-points that were sampled already; `figures` are those of plan.json, where there is
    one, `curves` those of the set-points, where they have been gathered, `program` is what its file holds, and the
    stock of `setup` is cut along the motion, as in `cut` where that was simulated."""
    from toolpace.results.report.page import report_page
    from toolpace.results.workpiece.view import view_of_plan

    workpiece = None if setup is None else view_of_plan(trajectory, toolpath, setup, cut)

    with whole_file(path) as temporary:
        page = report_page(trajectory, setpoints, toolpath, verification, figures, curves, program, workpiece)
        temporary.write_text(page, encoding="utf-8")
