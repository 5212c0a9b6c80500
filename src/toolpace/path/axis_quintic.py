"""Joint paths from quintic intervals through reference points with given derivatives (Wu et al. 2009).

Source: Wu, Li, Liu, Perez, ACC 2009, Eq. (7a) and (7b). Continuous to the second derivative at the points; the third
jumps there.

    P_1 ---- interval 1 ---- P_2 ---- interval 2 ---- P_3 ...      u runs from 0 to 1 in each interval
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from toolpace.common.arrays import Floats
from toolpace.common.errors import PathError, UsageError
from toolpace.machine.machine import Machine
from toolpace.path.axis_path import AxisPath
from toolpace.path.axis_run import AxisRun
from toolpace.path.path import Path
from toolpace.path.run import PathJet, PathRun, second_derivative_bounds


def _polynomials(s: Floats, jets: Floats) -> Floats:
    """(n, 6, c) intervals through points at s (n + 1,) with jets (3, n + 1, c)."""
    from toolpace.kernels.motion.quintic import coefficients

    if jets.ndim != 3 or jets.shape[:2] != (3, len(s)):
        raise PathError(f"quintic path: {len(s)} points, but value and two derivatives of shape {jets.shape}")
    if len(s) < 2 or not (np.diff(s) > 0.0).all():
        raise PathError("quintic path: the parameter must increase from point to point; give at least two points")
    if not (np.isfinite(jets).all() and np.isfinite(s).all()):
        bad = int(np.flatnonzero(~np.isfinite(jets).all(axis=(0, 2)))[0])
        raise PathError(f"quintic path: point {bad + 1} is not finite; give finite coordinates and derivatives")
    out: Floats = coefficients(s, *np.ascontiguousarray(jets))
    return out


@dataclass(frozen=True, kw_only=True, eq=False, repr=False)
class QuinticRun(PathRun):
    """Tip and rotary joints as quintics between the points at `breaks`."""

    polynomials: Floats
    """(n, 6, 5) C0 to C5 of x_w, y_w, z_w and both rotary joints, in u from 0 to 1."""

    def evaluate(self, s: Floats) -> PathJet:
        """Position and derivatives at s (n,)."""
        from toolpace.kernels.motion.quintic import evaluate

        jets = evaluate(self.breaks, self.polynomials, np.ascontiguousarray(s, dtype=float))
        return PathJet(jets[:, :, :3], None, jets[:, :, 3:])

    def second_derivative_bounds(self) -> Floats:
        """(n,) most |P''| of the tip in each interval, by its control points; by s, where the intervals are in u."""
        most: Floats = second_derivative_bounds(self.polynomials[:, :, :3], np.ones(len(self.polynomials)))
        return most / np.diff(self.breaks) ** 2


def quintic_path(s: npt.ArrayLike, tip: npt.ArrayLike, rotary: npt.ArrayLike, feed: float = np.inf) -> Path:
    """A path of quintic intervals, one block each.

    s (n,) parameter of the points; tip (3, n, 3) [m] and rotary (3, n, 2) [rad]: value, first and second derivative
    by s. PathError where they do not fit together.
    """
    points = np.array(s, dtype=float)
    jets = np.concatenate([np.asarray(tip, dtype=float), np.asarray(rotary, dtype=float)], axis=2)
    if not feed > 0.0:
        raise PathError(f"quintic path: the feed is {feed:g} m/s; give a positive feed, or inf for none")
    n = len(points) - 1
    run = QuinticRun(
        breaks=points, polynomials=_polynomials(points, jets), block_start=points.copy(),
        block=np.arange(1, n + 1, dtype=np.int64), feed=np.full(n, float(feed)), least_time=np.zeros(n),
    )  # fmt: skip
    return Path((run,))


def quintic_through(path: Path, machine: Machine, intervals: int = 31) -> Path:
    """A path rebuilt of quintic intervals through points at equal steps of its parameter, run by run.

    The points have the coordinates x_w, y_w, z_w and the rotary joints' of the paper, and their exact derivatives.
    """
    if intervals < 1:
        raise UsageError(f"quintic path: {intervals} intervals; give at least one")
    runs: list[PathRun] = []
    for run, axis_run in zip(path.runs, AxisPath.follow(path, machine).runs):
        s = np.linspace(run.s0, run.s1, intervals + 1)
        rotary = axis_run.evaluate(s)[:3][:, :, machine.rotary]
        jets = np.concatenate([run.evaluate(s).tip[:3], rotary], axis=2)
        runs.append(
            QuinticRun(
                breaks=s,
                polynomials=_polynomials(s, jets),
                block_start=run.block_start.copy(),
                block=run.block.copy(),
                feed=run.feed.copy(),
                least_time=run.least_time.copy(),
                dwell=run.dwell,
                tool_length=run.tool_length,
            )
        )
    return Path(tuple(runs))


class QuinticAxisRun(AxisRun):
    """Any joints as quintics between points."""

    def __init__(self, s: Floats, jets: Floats, speed_cap: float) -> None:
        self.points, self.polynomials, self.cap = s, _polynomials(s, jets), speed_cap
        self.s0, self.s1, self.breaks, self.hints = float(s[0]), float(s[-1]), s[1:-1], s

    def evaluate(self, s: Floats) -> Floats:
        from toolpace.kernels.motion.quintic import evaluate

        jets: Floats = evaluate(self.points, self.polynomials, np.ascontiguousarray(s, dtype=float))
        return jets

    def speed_cap(self, s: Floats) -> Floats:
        return np.full(len(s), self.cap)


def quintic_axis_path(
    s: npt.ArrayLike, q: npt.ArrayLike, joints: Sequence[str] | None = None, speed_cap: float = np.inf
) -> AxisPath:
    """An axis path of quintic intervals: s (n,), q (3, n, m) joints with first and second derivatives by s.

    `speed_cap` limits ds/dt.
    """
    jets = np.asarray(q, dtype=float)
    run = QuinticAxisRun(np.array(s, dtype=float), jets, float(speed_cap))
    names = tuple(joints) if joints else tuple(f"q{i + 1}" for i in range(jets.shape[2]))
    if len(names) != jets.shape[2]:
        raise UsageError(f"quintic path: {len(names)} joint names for {jets.shape[2]} joints")
    return AxisPath((run,), names)
