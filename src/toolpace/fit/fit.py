"""The fit of a whole tool path: polyline, first spline, smoothing inside the tube, and a check between the samples."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from toolpace.errors import PathError, UsageError
from toolpace.fit.check import dense, deviations
from toolpace.fit.mesh import inside_spline, knots_of, sample
from toolpace.fit.polyline import Machine, Polyline, polylines
from toolpace.fit.tube import tighten
from toolpace.pathrun import Floats, SplineRun
from toolpace.toolpath import ToolPath

SLOW = 0.3
"""A third derivative [1/m^2] that no axis feels at any speed of machining; nothing is smoothed below it."""
REPAIRS = 4


def fit_runs(
    toolpath: ToolPath,
    tip_tolerance: float,
    axis_tolerance: float,
    machine: Machine | None,
    progress: Callable[[float], None] | None,
) -> tuple[tuple[SplineRun, ...], float, float]:
    """Runs, and the largest deviation of tip [m] and tool axis [rad]."""
    for name, value in (("tip_tolerance", tip_tolerance), ("axis_tolerance", axis_tolerance)):
        if not (np.isfinite(value) and value > 0.0):
            raise UsageError(f"{name} is {value:g}: give a positive tolerance")
    if len(toolpath) < 2:
        raise PathError(f"{toolpath.source or 'tool path'}: nothing moves: fewer than two points")
    runs = []
    tip_worst = axis_worst = start = 0.0
    lines = polylines(toolpath, tip_tolerance, axis_tolerance, machine)
    total = sum(len(line.s) for line in lines)
    done = 0
    for line in lines:
        try:
            run, tip_off, axis_off = fit_run(line, toolpath, tip_tolerance, axis_tolerance, machine, start)
        except PathError as error:
            place = f"{toolpath.source or 'tool path'}:{toolpath.block[line.entry[0]]}-{toolpath.block[line.entry[-1]]}"
            raise PathError(f"{place}: {error}; widen the tolerance") from None
        runs.append(run)
        start = run.s1
        tip_worst, axis_worst = max(tip_worst, tip_off), max(axis_worst, axis_off)
        done += len(line.s)
        if progress is not None:
            progress(done / total)
    return tuple(runs), tip_worst * tip_tolerance, axis_worst * axis_tolerance


def fit_run(
    line: Polyline,
    toolpath: ToolPath,
    tip_tolerance: float,
    axis_tolerance: float,
    machine: Machine | None,
    start: float,
) -> tuple[SplineRun, float, float]:
    """One run that starts at parameter `start` [m], and its deviations in tolerances."""
    from toolpace.kernels.spline import jets, pieces

    weight = turn_weight(line, tip_tolerance, axis_tolerance, machine)
    extra = np.zeros(0)
    breaks, data, tip, turn = inside_spline(line, weight, axis_tolerance, machine, extra)
    first_tip, first_turn = tip.copy(), turn.copy()
    radius = (np.ones(len(data.s)), np.ones(len(data.s)))
    joints_given = machine is not None and toolpath.rotary is not None
    for repair in range(REPAIRS + 1):
        tighten(breaks, data, tip, turn, weight, SLOW * tip_tolerance**2, radius)
        polynomials = pieces(knots_of(breaks), np.concatenate([tip, turn], axis=1))
        at = dense(data.s)
        curve = jets(breaks, polynomials, at)[0]
        tip_off, axis_off = deviations(line, at, curve[:, :3], curve[:, 3:], axis_tolerance, machine, joints_given)
        bad = np.maximum(tip_off, axis_off) > 1.0
        if not np.any(bad):
            break
        if repair == REPAIRS:
            raise PathError("the curve cannot be kept inside the tolerance")
        # compare at the places of the trouble too, and start over there from the first spline
        tip[:], turn[:] = first_tip, first_turn
        old, old_radius = data.s, radius
        extra = np.concatenate([extra, at[bad]])
        data = sample(line, breaks, extra, axis_tolerance, machine)
        near = np.clip(np.searchsorted(old, data.s), 0, len(old) - 1)
        radius = (old_radius[0][near].copy(), old_radius[1][near].copy())
        for off, limit in ((tip_off, radius[0]), (axis_off, radius[1])):
            for j in np.flatnonzero(off > 1.0):
                k = np.searchsorted(data.s, at[j])
                limit[max(0, k - 2) : k + 3] *= 0.97 / off[j]
    return piecewise(line, toolpath, breaks, polynomials, tip_tolerance, axis_tolerance, start), float(
        np.max(tip_off)
    ), float(np.max(axis_off))


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
