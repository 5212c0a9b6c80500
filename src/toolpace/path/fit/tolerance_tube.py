"""The smoothest curve within the tolerances of a tool path, run by run.

of a run from stop to stop:
  a first spline well inside the tube about the polyline, on as many knots as that takes
  repeat
      smooth it as far as the tube at its samples allows                  (an interior point, window by window)
      look between the samples:  inside the tube everywhere?  done
      where it strays: sample there too; then narrow the tube there; at last put in knots
      where it strays far, that is no place to go on from: smooth the first spline again
  where that does not end, the first spline; where it was smoothed for a pace, as without one
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from toolpace.common.arrays import Floats, Ints
from toolpace.common.errors import PathError
from toolpace.common.workers import Progress, Workers, side_by_side
from toolpace.machine.machine import Machine
from toolpace.path.fit.polyline import PlaceTolerances, Polyline, polylines
from toolpace.path.fit.smoothest_spline import first_breaks, inside_spline, refined_at, tighten
from toolpace.path.fit.speed_weights import SpeedWeights
from toolpace.path.fit.spline import PARTS, Comparison, Samples, Spline, sample
from toolpace.path.run import SplineRun
from toolpace.programs.speed_profile import ways_between
from toolpace.programs.tolerances import Tolerances
from toolpace.programs.toolpath import ToolPath

SLOW = 3.0
"""A third derivative [1/m^2] that no axis feels: at 30 m/min a jerk of 0.4 m/s^3, a hundredth of usual limits. Nothing
is smoothed below it."""
LIMIT = 0.995
"""Share of the tolerance within which the curve must be found; the rest is for what lies between the looks."""
STRAIGHT = 1e-6
"""A run as close to a straight one is one [tolerances]."""
LOCAL = 3
"""Repairs that keep the knots."""
REPAIRS = 10
"""Repairs before the first spline is taken as it is."""
ASTRAY = 1.5
"""Deviation between the samples from which the tube's solver may not find back [tolerances]."""
MORE_SAMPLES, MANY_SAMPLES = 20, 10_000
"""Times the samples of the first spline that are too many, where they are many: it strays everywhere, and each look
finds as many more."""


class FittedRun(NamedTuple):
    """A run and how far it is from its polyline."""

    run: SplineRun
    tip_deviation: float
    """Of the tip [m]."""
    axis_deviation: float
    """Of the tool axis [rad]."""


class TubeFit:
    """Fits of one tool path within the same tolerances: what does not depend on their weights is made once.

    A run without weights, and a straight one, is fitted once.
    """

    def __init__(
        self,
        toolpath: ToolPath,
        tip_tolerance: float | Tolerances,
        axis_tolerance: float | Tolerances,
        machine: Machine | None,
    ) -> None:
        from toolpace.kernels.ahead_of_time import ensure_warm

        if len(toolpath) < 2:
            raise PathError(f"{toolpath.source or 'tool path'}: nothing moves: fewer than two points")
        self.toolpath = toolpath
        self.tolerances = PlaceTolerances.of(toolpath, tip_tolerance, axis_tolerance)
        ensure_warm()
        self.lines = polylines(toolpath, self.tolerances, machine)
        self.machines: Sequence[Machine | None] = [None] * len(self.lines)
        if machine is not None:
            self.machines = machine.with_tools(line.tool_length for line in self.lines)
        self._firsts: dict[int, Spline] = {}
        self._smoothest: dict[int, FittedRun] = {}

    def runs(
        self, progress: Callable[[float], None] | None, speed_weights: Sequence[SpeedWeights | None] | None = None
    ) -> tuple[tuple[SplineRun, ...], float, float, float]:
        """Runs, the largest deviation of tip [m] and tool axis [rad], and the time to wait before the first run [s].

        `speed_weights`: of each run, None where it is as smooth as can be. Raises PathError where no curve fits.
        """
        weights = speed_weights if speed_weights is not None else [None] * len(self.lines)

        def one(k: int, workers: Workers, share: Progress) -> FittedRun:
            try:
                return self._run(k, weights[k], workers, share)
            except PathError as error:
                entry = self.lines[k].entry
                block = self.toolpath.block[entry]
                place = f"{self.toolpath.source or 'tool path'}:{block[0]}-{block[-1]}"
                raise PathError(f"{place}: {error}; widen the tolerance") from None

        fitted = side_by_side(one, [len(line.s) for line in self.lines], progress)
        tip = max(run.tip_deviation for run in fitted)
        axis = max(run.axis_deviation for run in fitted)
        return tuple(run.run for run in fitted), tip, axis, self.lines[0].wait

    def _run(self, k: int, speed_weight: SpeedWeights | None, workers: Workers, progress: Progress) -> FittedRun:
        """Run number k with its weights."""
        line, machine, axis_tolerance = self.lines[k], self.machines[k], self.tolerances.axis
        if is_straight(line):
            speed_weight = None
        if speed_weight is None and k in self._smoothest:
            return self._smoothest[k]
        weight = turn_weight(line, self.tolerances.tip, axis_tolerance, machine)
        check = Comparison(line, axis_tolerance, machine, machine is not None and self.toolpath.rotary is not None)
        if k not in self._firsts:
            breaks = first_breaks(line)
            self._firsts[k] = inside_spline(line, breaks, weight, axis_tolerance, machine, check.between, workers)[0]
        first = self._firsts[k]
        samples = sample(line, first.breaks, axis_tolerance, machine)
        start = Start(line, machine, weight, check, first, samples)
        found = fit_run(start, self.toolpath, self.tolerances, workers, progress, speed_weight)
        if found is None and speed_weight is not None:
            return self._run(k, None, workers, progress)
        if found is None:
            raise PathError("the curve cannot be kept inside the tolerance")
        if speed_weight is None:
            self._smoothest[k] = found
        return found


class Start(NamedTuple):
    """What the fit of a run begins with."""

    line: Polyline
    machine: Machine | None
    """With the tool that is in the spindle."""
    weight: Floats
    """Of the roughness of each coordinate of the turn."""
    check: Comparison
    first: Spline
    """Well inside the tube."""
    samples: Samples
    """Of the first spline."""


def fit_run(
    start: Start,
    toolpath: ToolPath,
    tolerances: PlaceTolerances,
    workers: Workers,
    progress: Progress,
    speed_weight: SpeedWeights | None = None,
) -> FittedRun | None:
    """One run; None where no curve is found within the tolerance."""
    line, machine, weight, check, first, samples = start
    tip_tolerance, axis_tolerance = tolerances.tip, tolerances.axis
    least_third = SLOW * tip_tolerance**2
    spline, data = first.copy(), samples
    narrow: list[tuple[Floats, Floats]] = []
    where: Floats | None = None

    def finished(found: Deviations, spline: Spline) -> FittedRun:
        tip = check.strays(spline.breaks, found.polynomials, found.at, found.tip)
        tip, axis = (line.room_at(found.at) * np.stack([tip, found.axis], axis=1)).T
        tip, axis = tip_tolerance * tip, axis_tolerance * axis
        run = piecewise(line, toolpath, spline.breaks, found.polynomials, tolerances)
        tip_off, axis_off = (largest_of_cells(spline.breaks, found.at, off) for off in (tip, axis))
        run = replace(run, tip_off=tip_off, axis_off=axis_off)
        return FittedRun(run, float(np.max(tip)), float(np.max(axis)))

    for repair in range(REPAIRS):
        # how many there will be nobody knows; the first one takes the longest
        part = progress.part(1.0 - 0.5**repair, 1.0 - 0.5 ** (repair + 1))
        rows = speed_weight.rows(spline.breaks, tip_tolerance) if speed_weight is not None else None
        tighten(spline, data, weight, least_third, narrowed(data.s, narrow), where, workers, part, rows)
        if not spline.is_finite:
            spline, data = first.copy(), samples
        found = deviations(check, spline, data)
        if len(found.bad) == 0:
            return finished(found, spline)
        # it strays between the samples: compare there too, in a narrower tube, and smooth about these places once more
        where = found.at[found.bad]
        s = with_neighbours(data.s, found.at, found.bad)
        if repair > 0:
            narrow.append((where, np.clip(0.95 / found.off[found.bad], 0.7, 1.0)))
        breaks = spline.breaks
        if repair >= LOCAL:
            breaks = refined_at(line.s, breaks, where)
            s = np.union1d(s, breaks)
        if len(s) > max(MORE_SAMPLES * len(samples.s), MANY_SAMPLES):
            break
        if not np.max(found.off) <= ASTRAY:
            spline, where = first.over(breaks), None
        elif len(breaks) > len(spline.breaks):
            spline = spline.over(breaks)
        data = sample(line, breaks, axis_tolerance, machine, s, data)
    if speed_weight is not None:
        return None
    found = deviations(check, first, samples)
    return None if len(found.bad) else finished(found, first)


def is_straight(line: Polyline) -> bool:
    """Whether a run goes straight, in tip and turn: nothing is smoother, at any pace."""
    u = (line.s / line.s[-1])[:, None]
    return all(
        np.abs(each - each[0] - u * (each[-1] - each[0])).max() <= STRAIGHT for each in (line.tip, line.turn, line.axis)
    )


class Deviations(NamedTuple):
    """How far a spline is from its polyline, between the samples too."""

    polynomials: Floats
    """The pieces of the spline."""
    at: Floats
    """(k,) parameters at which it was looked."""
    tip: Floats
    """(k,) deviation of the tip [tolerances]."""
    axis: Floats
    """(k,) deviation of the tool axis [tolerances]."""

    @property
    def off(self) -> Floats:
        """(k,) the larger of both."""
        off: Floats = np.maximum(self.tip, self.axis)
        return off

    @property
    def bad(self) -> Ints:
        """Indices of the places outside the tolerance; a nan is outside."""
        return np.flatnonzero(~(self.off <= LIMIT))


def deviations(check: Comparison, spline: Spline, data: Samples) -> Deviations:
    """Look at a spline more closely than its samples do."""
    polynomials = spline.pieces()
    return Deviations(polynomials, *check.closely(polynomials, spline.breaks, data.s))


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
    tolerances: PlaceTolerances,
) -> SplineRun:
    """The run in metres and radians; cells of one entry of the tool path become one block."""
    tip_tolerance, axis_tolerance = tolerances.tip, tolerances.axis
    scale = np.concatenate([np.full(3, tip_tolerance), np.full(polynomials.shape[2] - 3, axis_tolerance)])
    order = tip_tolerance ** -np.arange(6.0)
    head = np.flatnonzero(np.concatenate([[True], np.diff(line.entry) != 0]))
    entry = line.entry[head]
    cut = np.concatenate([line.s[head], line.s[-1:]])
    profile = toolpath.speed_profile
    return SplineRun(
        breaks=tip_tolerance * breaks,
        coefficients=polynomials * scale * order[:, None],
        block_start=tip_tolerance * cut,
        block=toolpath.block[entry],
        feed=toolpath.feed[entry],
        least_time=toolpath.least_time[entry],
        dwell=line.dwell,
        tool_length=line.tool_length,
        entry=entry,
        speed_profile=None if profile is None else profile.along(ways_between(entry), tip_tolerance * cut),
    )


def largest_of_cells(breaks: Floats, at: Floats, off: Floats) -> Floats:
    """(n - 1,) the largest of the deviations (k,) found at parameters (k,) in each cell between breaks (n,)."""
    largest = np.zeros(len(breaks) - 1)
    np.maximum.at(largest, np.clip(np.searchsorted(breaks, at, side="right") - 1, 0, len(largest) - 1), off)
    return largest
