"""The simultaneous change of path and speed law of a planned run, window by window.

of a run, its path and the motion along it:
  knots: those of the path, and more where the motion takes long from one to the next
  the fastest change of path and pace within limits and tolerances, window by window between fixed ends,
  then of windows over their seams
  the path with its part of the change; where it strays from the tube between the places, the tube is held there too
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from itertools import pairwise
from math import comb, factorial

import numpy as np

from toolpace.common.arrays import Bools, Floats
from toolpace.common.workers import Progress, Workers, side_by_side
from toolpace.machine.machine import Machine
from toolpace.motion.laws import TimeLaw
from toolpace.motion.trajectory import Trajectory
from toolpace.path.fit.polyline import PlaceTolerances, Polyline, polylines
from toolpace.path.fit.spline import Comparison, spline_values
from toolpace.path.fit.tolerance_tube import LIMIT, largest_of_cells
from toolpace.path.follow_run import FollowRun
from toolpace.path.path import Path
from toolpace.path.run import SplineRun
from toolpace.planning.path_and_pace.interior_point import fastest
from toolpace.planning.path_and_pace.segment import SLOT, EffortSettings, FittedRun, Stretch, slots_of
from toolpace.programs.toolpath import ToolPath

FEWEST, MOST = 16, 200_000
"""Cells of a run below and above which it stays as it is: one that takes that long is slow by its feeds."""
WINDOW, SEAM = 500, 120
"""Slots of a window, and on either side of a seam that move again."""
FIXED_AT_END = 3
"""Slots at an end of a run that stay: there position, velocity and acceleration are given."""
NARROWER = 0.97
"""Share of the tube that is left where it was left between its places, each time."""
REPAIRS = 3
"""Times that the tube is held in more places."""
STILL = 1e-6
"""Turn of a joint on the way to a point of the program below which it stands still [tolerances]."""
AT_FEED = 0.999
"""Share of the cap on its speed from which a motion is one at feed: there no change makes it faster."""
COARSER = 0.03
"""Time from knot to knot there, as a share of that to the nearest place where it is slower. With knots everywhere the
change of a pass of 700 s took 14 s in place of 3, and the plan of its path 10 in place of 3, for 2e-4 of the time."""


def refitted(
    toolpath: ToolPath,
    machine: Machine,
    path: Path,
    motion: Trajectory,
    tolerances: PlaceTolerances,
    ramp: float,
    care: EffortSettings,
    progress: Callable[[float], None] | None = None,
) -> Path:
    """The path changed so that its motion gets faster, within tolerances that count in those that it was fitted in.

    `motion` is one along the path that holds its limits, `ramp` the time in which an acceleration builds up [s]. Runs
    for which nothing is found stay as they are.
    """
    lines = polylines(toolpath, tolerances, machine)
    scale = np.repeat([tolerances.tip, tolerances.axis], [3, 2])
    in_joints = toolpath.rotary is not None

    def one(k: int, workers: Workers, part: Progress) -> tuple[SplineRun, float, float]:
        run, axis_run = path.runs[k], motion.axis_path.runs[k]
        assert isinstance(run, SplineRun)
        assert isinstance(axis_run, FollowRun)
        rapid = toolpath.rapid[lines[k].entry]
        unchanged = run, path.tip_deviation, path.axis_deviation
        if motion.laws[k].duration > MOST * care.longest * ramp:
            return unchanged
        fitted = fitted_run(run, axis_run, motion.laws[k], lines[k], rapid, scale, ramp, care)
        check = Comparison(lines[k], tolerances.axis, machine, in_joints)
        changed = changed_run(fitted, check, workers, part)
        return unchanged if changed is None else changed

    done = side_by_side(one, [len(run.breaks) for run in path.runs], progress)
    tip, axis = max(each[1] for each in done), max(each[2] for each in done)
    return replace(path, runs=tuple(each[0] for each in done), tip_deviation=tip, axis_deviation=axis)


def fitted_run(
    run: SplineRun, joints: FollowRun, law: TimeLaw, line: Polyline, rapid: Bools, scale: Floats, ramp: float,
    care: EffortSettings,
) -> FittedRun:  # fmt: skip
    """A run with knots that its motion passes soon enough after each other; `rapid`: which ways of the line are."""
    times = law.times_at(run.breaks)
    times[0], times[-1] = 0.0, law.duration
    parts = np.maximum(np.ceil(np.diff(times) / (care.longest * ramp)), 1).astype(np.int64)
    cell = np.repeat(np.arange(len(parts)), parts)
    share = (np.arange(len(cell)) - np.repeat(np.cumsum(parts) - parts, parts)) / parts[cell]
    finer = np.append(times[cell] + share * np.diff(times)[cell], times[-1])
    breaks, own = law.at(finer)[0], np.append(share == 0.0, True)
    breaks[own] = run.breaks
    wanted = own | where_it_matters(finer, law.at(finer)[1] < AT_FEED * joints.speed_cap(breaks))
    breaks, finer = breaks[wanted], finer[wanted]
    still = standing_still(line, rapid, (breaks - run.s0) / scale[0])
    return FittedRun(run, joints, law, line, joints.machine, scale, breaks, finer, run.s0, still, care)


def where_it_matters(times: Floats, slower: Bools) -> Bools:
    """Which knots (k,) passed at these times [s] are needed where a motion is at feed but for those marked `slower`:
    these and the first after each, and of the others the fewer the further away they are."""
    at = np.concatenate([[-np.inf], times[slower], [np.inf]])
    after = np.searchsorted(at, times)
    away = np.minimum(at[np.minimum(after, len(at) - 1)] - times, times - at[after - 1])
    step = np.diff(times, append=2.0 * times[-1] - times[-2])
    # where it is at feed all along nothing is near
    measure = np.cumsum(step / np.maximum(step, COARSER * np.minimum(away, times[-1])))
    return np.asarray(np.diff(np.floor(measure), prepend=-1.0) > 0.0)


def changed_run(
    fitted: FittedRun, check: Comparison, workers: Workers, progress: Progress
) -> tuple[SplineRun, float, float] | None:
    """A run with its change, and its deviations of tip [m] and tool axis [rad]; None where nothing is found."""
    if len(fitted.breaks) <= FEWEST:
        return None
    also = fitted.begin + fitted.scale[0] * fitted.line.s
    x = np.zeros((slots_of(fitted.breaks), SLOT))
    stages = [where_time_is_lost(fitted, stage) for stage in windows(len(x), fitted.care.seams)]
    for repair in range(REPAIRS):
        part = progress.part(1.0 - 0.5**repair, 1.0 - 0.5 ** (repair + 1))
        change(fitted, x, stages, also, NARROWER**repair, workers, part)
        run = with_change(fitted, x)
        units = fitted.scale[0] ** np.arange(6.0)[:, None] / fitted.scale
        breaks = (run.breaks - fitted.begin) / fitted.scale[0]
        samples = np.union1d(breaks, fitted.line.s)
        at, tip, axis = check.closely(run.coefficients * units, breaks, samples)
        if max(tip.max(), axis.max()) <= LIMIT:
            tip = check.strays(breaks, run.coefficients * units, at, tip)
            wide = np.stack([tip, axis], axis=1) * fitted.line.room_at(at) * fitted.scale[[0, 4]]
            off = [largest_of_cells(breaks, at, each) for each in wide.T]
            return replace(run, tip_off=off[0], axis_off=off[1]), float(off[0].max()), float(off[1].max())
        astray = fitted.begin + fitted.scale[0] * at[~(np.maximum(tip, axis) <= LIMIT)]
        also = np.union1d(also, astray)
        stages = [about(stage, fitted, astray) for stage in stages]
    return None


def where_time_is_lost(fitted: FittedRun, stage: list[tuple[int, int]]) -> list[tuple[int, int]]:
    """The fewest windows that hold a share of the time which the motion loses below the speed that the caps and the
    velocity limits of the joints allow: where it is at that speed, no change makes it faster."""
    if not stage or fitted.care.covered == 1.0:
        return stage
    joints, cap = fitted.joints.with_cap(fitted.breaks)
    velocity = np.asarray(fitted.machine.limits.velocity)
    with np.errstate(divide="ignore"):
        allowed = np.minimum(cap, (velocity / np.abs(joints[1])).min(axis=1))
    slower = np.maximum(1.0 - fitted.law.at(fitted.times)[1] / allowed, 0.0)
    lost = np.append(0.0, np.cumsum(0.5 * (slower[1:] + slower[:-1]) * np.diff(fitted.times)))
    low, high = np.transpose(stage)
    cells = len(lost) - 1
    of_window = lost[np.minimum(high, cells)] - lost[np.maximum(low - SLOT + 1, 0)]
    order = np.argsort(-of_window, kind="stable")
    count = int(np.searchsorted(np.cumsum(of_window[order]), fitted.care.covered * of_window.sum())) + 1
    return [stage[k] for k in sorted(order[:count])]


def about(stage: list[tuple[int, int]], fitted: FittedRun, places: Floats) -> list[tuple[int, int]]:
    """Those of the windows that have a slot of the cells at these parameters."""
    first = np.searchsorted(fitted.breaks, places, side="right") - 1
    return [(low, high) for low, high in stage if np.any((first < high) & (first + SLOT > low))]


def change(
    fitted: FittedRun,
    x: Floats,
    stages: list[list[tuple[int, int]]],
    also: Floats,
    share: float,
    workers: Workers,
    progress: Progress,
) -> None:
    """Make the coefficients x (slots, 6) of the change the fastest, window by window, in place, within a `share` of the
    usual tube, which is held at the parameters `also` too."""
    count = len(x)

    def solve(part: tuple[int, int]) -> None:
        low, high = part
        stretch = Stretch(fitted, max(low - SLOT + 1, 0), min(high, count - SLOT + 1), also)
        moves = np.arange(count)[stretch.slots]
        free = (moves >= low) & (moves < high)
        found = fastest(stretch, x[stretch.slots], free, share)
        if found is not None:
            x[low:high] = found[free]

    for stage, part in zip(stages, progress.split([len(stage) for stage in stages])):
        workers.each(solve, stage, part)


def windows(count: int, seams_too: bool) -> list[list[tuple[int, int]]]:
    """Ranges of slots that move, stage by stage; those of a stage have no cell in common.

    `seams_too`: the last stage is that of the seams of the first.
    """
    low, high = FIXED_AT_END, count - FIXED_AT_END
    seams = np.linspace(low, high, max(1, round((high - low) / WINDOW)) + 1).astype(int)
    first = [(int(a), int(b) - (SLOT - 1 if b < high else 0)) for a, b in pairwise(seams)]
    return [first, [(int(a) - SEAM, int(a) + SEAM) for a in seams[1:-1]]] if seams_too else [first]


def with_change(fitted: FittedRun, x: Floats) -> SplineRun:
    """The run with the path's part of the change, with the knots of the run and those of cells that it moves."""
    run = fitted.run
    moved = np.convolve(np.any(x[:, :5] != 0.0, axis=1), np.ones(SLOT), "valid") > 0.5
    wanted = np.append(True, moved) | np.append(moved, True) | np.isin(fitted.breaks, run.breaks)
    breaks = fitted.breaks[wanted]
    cell = np.clip(np.searchsorted(run.breaks, breaks[:-1], side="right") - 1, 0, len(run.breaks) - 2)
    old, ahead = run.coefficients[cell], (breaks[:-1] - run.breaks[cell])[:, None]
    padded = np.concatenate([np.repeat(breaks[0], 5), fitted.breaks, np.repeat(breaks[-1], 5)])
    change = x[:, :5] * fitted.scale
    taylor = [
        sum(comb(i, k) * old[:, i] * ahead ** (i - k) for i in range(k, 6))
        + spline_values(padded, change, 5, breaks[:-1], k) / factorial(k)
        for k in range(6)
    ]
    return replace(run, breaks=breaks, coefficients=np.stack(taylor, axis=1), tip_off=np.zeros(0), axis_off=np.zeros(0))


def standing_still(line: Polyline, rapid: Bools, breaks: Floats) -> Bools:
    """(slots, 2) whether a rotary joint stays as it is in a slot: no cut of the run turns it, nor anything in all cells
    of the slot. `rapid` (k,) says which ways of the run are rapids, `breaks` (cells + 1,) are in tolerances."""
    turns = np.abs(np.diff(line.turn, axis=0)) > STILL
    # a run of nothing but rapids may be a program that tells no feeds
    cuts = ~rapid if not rapid.all() else np.ones_like(rapid)
    only_positioned = ~np.any(turns & cuts[:, None], axis=0)
    turned = np.concatenate([np.zeros((1, 2), dtype=np.int64), np.cumsum(turns, axis=0)])
    slot, last = np.arange(slots_of(breaks)), len(breaks) - 1
    low, high = breaks[np.clip(slot - SLOT + 1, 0, last)], breaks[np.clip(slot + 1, 0, last)]
    before = np.clip(np.searchsorted(line.s, low, side="right") - 1, 0, len(turns))
    after = np.clip(np.searchsorted(line.s, high, side="left"), 0, len(turns))
    return np.asarray(only_positioned & (turned[after] == turned[before]))
