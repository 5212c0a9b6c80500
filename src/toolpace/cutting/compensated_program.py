"""A program compensated for the predicted bending of its tool, with a feed that holds for the bent tip.

plan the program as it is
repeat
    bending of that motion at each place of the program           (prediction)
    within a micrometre of what is compensated?  done
    the program's places, shifted by the opposite; fit and plan   that is one iteration

The bent tip is at P(s) + D(s), P the commanded tip and D the bending that is compensated. It goes |P' + D'| / |P'|
times as fast as the commanded one. Where that is more than 1, the way gets blocks of its own with a feed that is so
much less. D is told at the places of the program, and straight between them.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from toolpace.common.arrays import Floats, Ints
from toolpace.common.errors import PathError, UsageError
from toolpace.common.units import format_length, format_time
from toolpace.common.value_objects import one_line
from toolpace.cutting.prediction import Stations, cut_of_way, parameters, predicted_bending, stations_of
from toolpace.machine.cutting_tool import CuttingTool
from toolpace.machine.machine import Machine, check_machine
from toolpace.motion.trajectory import Trajectory
from toolpace.path.axis_path import AxisPath
from toolpace.path.path import Path
from toolpace.path.run import PathRun
from toolpace.planning.limit_tolerances import PROMISED
from toolpace.planning.planner import Planner, plan
from toolpace.programs.tolerances import Tolerances
from toolpace.programs.toolpath import ToolPath, check_toolpath

CONVERGED = 1e-6
"""Largest difference of the bending from what is compensated [m]; a tenth of the tolerance where that is less."""
RESERVE = 0.2
"""Share of the tip tolerance that is left to what has not converged, and to what two ways to work it out differ by."""
STRAIGHT = 0.05
"""Share of it by which a straight line between two points of the shifted program may miss the shift between them."""
MOST_ITERATIONS = 20
"""Most iterations."""
SETTLED = 2
"""Iterations after which the points that a path is fitted to stay the same."""
GRACE = 1e-4
"""Share of the feed that the bent tip may pass it by, as the limits of plans may be passed between set-points."""
STEP = 0.25 * GRACE
"""Feeds of blocks are less by a whole number of these shares, so that few blocks tell them."""
FED = PROMISED - 1.0 + GRACE
"""Share of the feed by which the bent tip may exceed it: what plans promise, and what the bending may still change."""
COARSE = 8
"""Set-points over the length of a blend, at least."""
STEEPEST = 0.05
"""Most bending over the length of a blend: more, and the blend is a bend of the path."""


@dataclass(frozen=True, eq=False, repr=False)
class BendingCompensation:
    """A path compensated for the bending of the tool, the motion along it, and the bending."""

    tool: CuttingTool
    path: Path
    trajectory: Trajectory
    toolpath: ToolPath
    """The program, as it was, with points put in: n."""
    bending: Floats
    """(n, 3) deflection at each of its points that is compensated [m], in the workpiece frame."""
    rounds: int
    """How often it was planned with a shift."""
    change: float
    """Most difference of the bending of this motion from that [m]."""

    @property
    def largest(self) -> float:
        """The largest bending that is compensated [m]."""
        return float(np.linalg.norm(self.bending, axis=1).max())

    def __repr__(self) -> str:
        return one_line(
            self,
            f"by at most {format_length(self.largest)}",
            f"{self.rounds} rounds",
            f"within {format_length(self.change)}",
            f"{self.trajectory.duration:.6g} s",
        )


def compensate_bending(
    toolpath: ToolPath,
    machine: Machine,
    tool: CuttingTool,
    tip_tolerance: float | Tolerances = 10e-6,
    axis_tolerance: float | Tolerances = 1e-3,
    planner: str | Planner = "optimal",
    progress: Callable[[float], None] | None = None,
) -> BendingCompensation:
    """Plan a program so that its tool, bent by the force of its own motion, is within the tolerances [m], [rad] of it.

    Raises UsageError where nothing cuts, where the tool bends by so much that the blend is too short for it, and where
    an iteration changes the bending by more than a micrometre for ever; ReachError and PathError as `Path.fit` does.
    """
    check_toolpath(toolpath, "compensate_bending")
    if not isinstance(tool, CuttingTool):
        raise UsageError(
            f"compensate_bending: tool is {str(tool)[:40]!r}; give a CuttingTool, as load_tool(path) makes it"
        )
    check_machine(machine, "compensate_bending")
    if tool.from_stock and tool.engaged is None:
        raise UsageError(
            f'{tool.source}: milling = "stock": name a stock and this tool on the set-up sheet (--setup), or write the '
            "engagement; in Python, with_engaged_deflection makes the tool of a simulated cut"
        )
    if Tolerances.of(tip_tolerance, "tip_tolerance").one_sided:
        raise UsageError("a tip that must be on one side of its program and a tool that bends: one at a time")
    cut = cut_of_way(tool, toolpath)
    stations = stations_of(toolpath, machine, cut, tool.blend)
    cut = cut[stations.origin]
    least = Tolerances.of(tip_tolerance, "tip_tolerance").least
    enough = min(CONVERGED, 0.5 * RESERVE * least)
    bending = np.zeros((len(stations.way), 3))
    changes: list[float] = []
    for iteration in range(MOST_ITERATIONS + 1):
        reported = _share(progress, iteration)
        if iteration <= SETTLED:
            kept = stations.needed(bending, STRAIGHT * least)
        shifted = stations.shifted(-bending, kept)
        fitted = Path.fit(shifted, (1.0 - RESERVE) * tip_tolerance, axis_tolerance, machine, _share(reported, 0))
        path = keeping_feed(fitted, stations, kept, bending)
        trajectory = plan(AxisPath.follow(path, machine), machine, planner=planner, progress=_share(reported, 1))
        found = predicted_bending(stations, kept, cut, tool, machine, fitted, trajectory)
        check_small(found, stations, tool)
        changes.append(float(np.linalg.norm(found - bending, axis=1).max()))
        if changes[-1] <= enough and excess_of_feed(fitted, stations, kept, found, trajectory) <= FED:
            return BendingCompensation(tool, path, trajectory, stations.toolpath, bending, iteration, changes[-1])
        # a curve that can be fitted in two ways may change for ever from one to the other: go half of the way
        slow = iteration > SETTLED and changes[-1] > 0.5 * changes[-2]
        bending = 0.5 * (bending + found) if slow else found
    shown = ", ".join(f"{1e6 * change:.3g}" for change in changes[-4:])
    raise PathError(
        f"{tool.source}: the compensation of the bending does not converge: after {MOST_ITERATIONS} iterations it "
        f"still changes by {shown} um, and {1e6 * enough:.3g} um are enough; give a longer blend or a stiffer tool, "
        "or a wider --tip-tolerance"
    )


def refuse_coarse(toolpath: ToolPath, tool: CuttingTool, dt: float) -> None:
    """Raise UsageError where set-points every `dt` [s] are too far apart to tell how bending builds up."""
    cut = cut_of_way(tool, toolpath) >= 0
    fed = toolpath.feed[cut & np.isfinite(toolpath.feed)]
    most = tool.blend / COARSE
    if len(fed) and dt * fed.max() > most:
        raise UsageError(
            f"--dt: at {fed.max() * 60e3:.4g} mm/min set-points are {format_length(dt * float(fed.max()))} apart, and "
            f"bending builds up over {format_length(tool.blend)} (blend of {tool.source}); give at most "
            f"{format_time(most / float(fed.max()))}, or a longer blend"
        )


def check_small(bending: Floats, stations: Stations, tool: CuttingTool) -> None:
    """Raise UsageError where the tool bends by more than its blend can take."""
    size = np.linalg.norm(bending, axis=1)
    k = int(np.argmax(size))
    if size[k] > STEEPEST * tool.blend:
        raise UsageError(
            f"{tool.source}: the tool bends by {format_length(float(size[k]))} in block {stations.toolpath.block[k]}, "
            f"and {STEEPEST:g} of its blend of {format_length(tool.blend)} is the most; check stiffness, coefficients "
            "and depths, or give a longer blend"
        )


def _share(progress: Callable[[float], None] | None, part: int) -> Callable[[float], None] | None:
    """What tells of one of the parts that follow each other, each half of what is left."""
    if progress is None:
        return None
    return lambda share: progress(1.0 - 0.5**part * (1.0 - 0.5 * share))


def keeping_feed(fitted: Path, stations: Stations, kept: Ints, bending: Floats) -> Path:
    """A path that was fitted to the places `kept` (k,), as one of the program's points, one block for each way of it;
    of more blocks where the tip, bent by (n, 3) [m], would pass the feed."""
    return replace(fitted, runs=tuple(_keeping_feed(run, stations, kept, bending) for run in fitted.runs))


def excess_of_feed(fitted: Path, stations: Stations, kept: Ints, bending: Floats, trajectory: Trajectory) -> float:
    """The most by which the tip, bent by (n, 3) [m], passes the feeds of the program, as a share of them."""
    worst = 0.0
    for run, law in zip(fitted.runs, trajectory.laws):
        at, s = _cells(stations, kept, run)
        feed = stations.toolpath.feed[at[1:]]
        pace, slope, drift = law.states_at(s)[1], run.tip_slope(s), _drift(at, s, bending)
        for end in (slice(None, -1), slice(1, None)):
            speed = pace[end] * np.linalg.norm(slope[end] + drift, axis=1)
            worst = max(worst, float(np.max(speed / feed, initial=0.0)) - 1.0)
    return worst


def _keeping_feed(run: PathRun, stations: Stations, kept: Ints, bending: Floats) -> PathRun:
    at, s = _cells(stations, kept, run)
    path, leads = stations.toolpath, stations.origin[at[1:]]
    point = at[1:]
    fed = np.isfinite(path.feed[point]) & (path.least_time[point] == 0.0)
    less = np.where(fed, 1.0 - 1.0 / _faster(run, at, s, bending), 0.0)
    steps = np.ceil(np.maximum(less - STEP, 0.0) / STEP)
    head = np.flatnonzero(np.concatenate([[True], (np.diff(leads) != 0) | (np.diff(steps) != 0)]))
    return replace(
        run,
        block_start=np.append(s[:-1][head], s[-1]),
        block=path.block[point][head],
        feed=path.feed[point][head] * (1.0 - STEP * steps[head]),
        least_time=np.add.reduceat(path.least_time[point], head),
        entry=leads[head],
    )


def _cells(stations: Stations, kept: Ints, run: PathRun) -> tuple[Ints, Floats]:
    """The places (k,) that a run goes along, without those that stand where another does, and its parameters there."""
    at, s = parameters(stations, kept, run)
    # of places that stand together the last has the way that leads on, and the first the one that leads there
    moves = np.concatenate([[True], np.diff(s) > 0.0])
    return at[moves], s[moves]


def _drift(at: Ints, s: Floats, bending: Floats) -> Floats:
    """(k - 1, 3) D' in each cell between places `at` (k,)."""
    drift: Floats = np.diff(bending[at], axis=0) / np.diff(s)[:, None]
    return drift


def _faster(run: PathRun, at: Ints, s: Floats, bending: Floats) -> Floats:
    """(k - 1,) how many times as fast the bent tip is in each cell, at the most; at least 1."""
    drift = _drift(at, s, bending)
    slope = run.tip_slope(s)
    own = np.linalg.norm(slope, axis=1)
    own = np.where(own > 0.0, own, np.inf)
    most = np.ones(len(drift))
    padded = np.concatenate([drift[:1], drift, drift[-1:]])
    for beside in (padded[:-2], drift, padded[2:]):
        for k in (slice(None, -1), slice(1, None)):
            most = np.maximum(most, np.linalg.norm(slope[k] + beside, axis=1) / own[k])
    return most
