"""The fit of a whole tool path: polyline, first spline, smoothing inside the tube, and a check between the samples."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from toolpace.arrays import Floats, Ints
from toolpace.errors import PathError, UsageError
from toolpace.path.fit.deviation import PARTS, Check
from toolpace.path.fit.first_spline import inside_spline
from toolpace.path.fit.knots import first_breaks, refined_at
from toolpace.path.fit.polyline import Machine, Polyline, polylines
from toolpace.path.fit.samples import sample
from toolpace.path.fit.smooth import tighten
from toolpace.path.run import SplineRun
from toolpace.toolpath import ToolPath

SLOW = 0.3
"""A third derivative [1/m^2] that no axis feels at any speed of machining; nothing is smoothed below it."""
LIMIT = 0.995
"""Share of the tolerance within which the curve must be found; the rest is for what lies between the looks."""
LOCAL = 3
"""Repairs that keep the knots."""
REPAIRS = 10
"""Repairs before the first spline is taken as it is."""


def fit_runs(
    toolpath: ToolPath,
    tip_tolerance: float,
    axis_tolerance: float,
    machine: Machine | None,
    progress: Callable[[float], None] | None,
) -> tuple[tuple[SplineRun, ...], float, float, float]:
    """Runs, the largest deviation of tip [m] and tool axis [rad], and the time to wait before the first run [s]."""
    for name, value in (("tip_tolerance", tip_tolerance), ("axis_tolerance", axis_tolerance)):
        if not (np.isfinite(value) and value > 0.0):
            raise UsageError(f"{name} is {value:g}: give a positive tolerance")
    if len(toolpath) < 2:
        raise PathError(f"{toolpath.source or 'tool path'}: nothing moves: fewer than two points")
    runs = []
    tip_worst = axis_worst = start = 0.0
    lines = polylines(toolpath, tip_tolerance, axis_tolerance, machine)
    total = sum(len(line.s) for line in lines)
    done = part = 0
    told = 0.0

    def report(share: float) -> None:
        # a repair smooths once more: what was told is not taken back
        nonlocal told
        told = max(told, (done + share * part) / total)
        if progress is not None:
            progress(told)

    for line in lines:
        part = len(line.s)
        try:
            run, tip_off, axis_off = fit_run(line, toolpath, tip_tolerance, axis_tolerance, machine, start, report)
        except PathError as error:
            place = f"{toolpath.source or 'tool path'}:{toolpath.block[line.entry[0]]}-{toolpath.block[line.entry[-1]]}"
            raise PathError(f"{place}: {error}; widen the tolerance") from None
        runs.append(run)
        start = run.s1
        tip_worst, axis_worst = max(tip_worst, tip_off), max(axis_worst, axis_off)
        done += part
    report(0.0)
    return tuple(runs), tip_worst * tip_tolerance, axis_worst * axis_tolerance, lines[0].wait


def fit_run(
    line: Polyline,
    toolpath: ToolPath,
    tip_tolerance: float,
    axis_tolerance: float,
    machine: Machine | None,
    start: float,
    report: Callable[[float], None],
) -> tuple[SplineRun, float, float]:
    """One run that starts at parameter `start` [m], and its deviations in tolerances."""
    weight = turn_weight(line, tip_tolerance, axis_tolerance, machine)
    least_third = SLOW * tip_tolerance**2
    check = Check(line, axis_tolerance, machine, machine is not None and toolpath.rotary is not None)
    begin = inside_spline(line, first_breaks(line.s), weight, axis_tolerance, machine, check.between)
    spline, data = begin[0].copy(), begin[1]
    narrow: list[tuple[Floats, Floats]] = []
    where: Floats | None = None
    for repair in range(REPAIRS + 1):
        if repair < REPAIRS:
            radius = narrowed(data.s, narrow)
            tighten(spline, data, weight, least_third, radius, where, report)
            if not (np.isfinite(spline.tip).all() and np.isfinite(spline.turn).all()):
                spline, data = begin
        else:
            spline, data = begin
        polynomials = spline.pieces()
        at, tip_off, axis_off = check.closely(polynomials, spline.breaks, data.s)
        off = np.maximum(tip_off, axis_off)
        bad = np.flatnonzero(~(off <= LIMIT))
        if len(bad) == 0:
            run = piecewise(line, toolpath, spline.breaks, polynomials, tip_tolerance, axis_tolerance, start)
            return run, float(np.max(tip_off)), float(np.max(axis_off))
        # it strays between the samples: compare there too, and smooth about these places once more
        where = at[bad]
        s = with_neighbours(data.s, at, bad)
        if repair > 0:
            narrow.append((where, np.clip(0.95 / off[bad], 0.7, 1.0)))
        if repair >= LOCAL:
            spline = spline.over(refined_at(line.s, spline.breaks, where))
            s = np.union1d(s, spline.breaks)
        data = sample(line, spline.breaks, axis_tolerance, machine, s, data)
    raise PathError("the curve cannot be kept inside the tolerance")


def with_neighbours(samples: Floats, at: Floats, bad: Ints) -> Floats:
    """The samples and, of the denser parameters `at`, the bad ones and those around them."""
    around = np.unique(np.clip(bad[:, None] + np.arange(-PARTS, PARTS + 1), 0, len(at) - 1))
    return np.unique(np.concatenate([samples, at[around]]))


def narrowed(s: Floats, narrow: list[tuple[Floats, Floats]]) -> Floats:
    """Radius (m,) of the tube at the samples, narrower where the curve was found outside."""
    radius = np.ones(len(s))
    for at, share in narrow:
        k = np.searchsorted(s, at)
        least = np.ones(len(s))
        for shift in (-2, -1, 0, 1):
            np.fmin.at(least, np.clip(k + shift, 0, len(s) - 1), share)
        radius *= least
    return np.maximum(radius, 0.3)


def turn_weight(line: Polyline, tip_tolerance: float, axis_tolerance: float, machine: Machine | None) -> Floats:
    """Relative weight of the squared roughness of each coordinate of the turn: what the joints feel of it.

    A rotary joint feels itself, and the linear joints feel it times the lever of the tip.
    """
    if machine is None:
        return np.ones(3)
    lever = np.sqrt(np.mean(machine.tip_lever(line.tip * tip_tolerance, line.turn * axis_tolerance) ** 2, axis=0))
    jerk = np.asarray(machine.limits.jerk)
    linear = np.min(jerk[machine.linear])
    squared = 1.0 / jerk[machine.rotary] ** 2 + (lever / linear) ** 2
    if not np.all(np.isfinite(squared)) or np.max(squared) <= 0.0:
        return np.ones(2)
    return np.asarray(np.maximum(squared / np.max(squared), 1e-4))


def piecewise(
    line: Polyline,
    toolpath: ToolPath,
    breaks: Floats,
    polynomials: Floats,
    tip_tolerance: float,
    axis_tolerance: float,
    start: float,
) -> SplineRun:
    """The run in metres and radians; cells of one entry of the tool path become one block."""
    scale = np.concatenate([np.full(3, tip_tolerance), np.full(polynomials.shape[2] - 3, axis_tolerance)])
    order = tip_tolerance ** -np.arange(6.0)
    head = np.flatnonzero(np.concatenate([[True], np.diff(line.entry) != 0]))
    entry = line.entry[head]
    cut = np.concatenate([line.s[head], line.s[-1:]])
    return SplineRun(
        breaks=start + tip_tolerance * breaks,
        coefficients=polynomials * scale * order[:, None],
        block_start=start + tip_tolerance * cut,
        block=toolpath.block[entry],
        feed=toolpath.feed[entry],
        least_time=toolpath.least_time[entry],
        dwell=line.dwell,
    )
