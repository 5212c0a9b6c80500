"""The projection of a deflection on the path, by the potential field of Eq. (8) to (10).

Source: Wu, Li, Liu, Perez, ACC 2009, section II.D. The target slides along the path as its attraction to the
deflection pulls it, until no force along the path is left.

             o deflection
            /
    -------x-----------> path          x: what is left of the force is across the path
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from toolpace.arrays import Floats
from toolpace.description import one_line
from toolpace.equality import ByValue
from toolpace.errors import UsageError
from toolpace.path.path import Path
from toolpace.path.run import PathRun

SAMPLES = 400
"""Points of a run, beside its breaks, from which the nearest ones are taken as starts."""
STARTS = 4
"""Nearest valleys of the distance that are descended into; of two as near the lower one is not known before."""
MOST_STEPS = 500
"""Of one descent. Each is Gauss-Newton's, and near the path a few of them reach the last digits."""
ROUNDING = 1.0 + 1e-14
"""Rise of the potential that is rounding: its fall cannot be seen any more where the last digits of s are won."""
CONVERGED = 1e-14
"""Step at which the descent ends, relative to the length of the run in s."""


@dataclass(frozen=True, eq=False, repr=False)
class Projection(ByValue):
    """The point of a path that attracts a deflection."""

    s: float
    """Parameter on the path."""
    run: int
    """Index of the run."""
    tip: Floats
    """(3,) [m]."""
    distance: float
    """From the deflection [m]."""
    steps: int
    """Steps of the descent."""

    def __repr__(self) -> str:
        return one_line(self, f"s {self.s:.9g} of run {self.run}", f"{self.distance * 1e3:.6g} mm away")


def potential(
    target: npt.ArrayLike,
    deflection: npt.ArrayLike,
    *,
    alpha: float = 1.0,
    m: float = 2.0,
    velocity: tuple[npt.ArrayLike, npt.ArrayLike] | None = None,
    alpha_velocity: float = 0.0,
    n: float = 2.0,
) -> float:
    """The attractive potential, Eq. (8); as it stands Eq. (10): velocities at both the same, alpha 1, m 2.

    `target` and `deflection` (3,) [m], `velocity` those of both [m/s].
    """
    value: float = alpha * float(np.linalg.norm(np.subtract(target, deflection))) ** m
    if velocity is not None:
        value += alpha_velocity * float(np.linalg.norm(np.subtract(*velocity))) ** n
    return value


def force(target: npt.ArrayLike, deflection: npt.ArrayLike, *, alpha: float = 1.0, m: float = 2.0) -> Floats:
    """(3,) the negative gradient of the potential by the position of the target, Eq. (9)."""
    apart = np.subtract(target, deflection, dtype=float)
    distance = float(np.linalg.norm(apart))
    if distance == 0.0:
        return np.zeros(3)
    pull: Floats = -alpha * m * distance ** (m - 2.0) * apart
    return pull


def descend(
    curve: Callable[[float], tuple[Floats, Floats]], deflection: Floats, low: float, high: float, start: float
) -> tuple[float, int]:
    """Follow the force along a curve, s -> (tip (3,), derivative (3,)), within [low, high]: s and steps.

    Each step is the force along the path over the stiffness of the field there, halved until the potential falls.
    """
    s = start
    tip, along = curve(s)
    height = potential(tip, deflection)
    for step in range(MOST_STEPS):
        stiffness = 2.0 * float(along @ along)
        if stiffness == 0.0:
            return s, step
        move = float(force(tip, deflection) @ along) / stiffness
        while True:
            place = min(max(s + move, low), high)
            tip_there, along_there = curve(place)
            there = potential(tip_there, deflection)
            if there <= height * ROUNDING or abs(place - s) <= CONVERGED * (high - low):
                break
            move *= 0.5
        done = abs(place - s) <= CONVERGED * (high - low)
        if there <= height * ROUNDING:
            s, tip, along, height = place, tip_there, along_there, there
        if done:
            return s, step + 1
    return s, MOST_STEPS


def project(path: Path, deflection: npt.ArrayLike, *, interval: tuple[float, float] | None = None) -> Projection:
    """The point of a path, or of the `interval` (from s, to s) of one of its runs, nearest to a deflection (3,) [m].

    The paper looks on the interval on which the tool was; with u clipped to [0, 1] its ends count too. The whole path
    is the default. Raises UsageError for a deflection that is not finite or an interval that is not on the path.
    """
    point = np.asarray(deflection, dtype=float)
    if point.shape != (3,) or not np.isfinite(point).all():
        raise UsageError(f"deflection: {deflection!r} is no point; give three finite coordinates in metres")
    best: Projection | None = None
    for index, run in enumerate(path.runs):
        low, high = (run.s0, run.s1) if interval is None else interval
        if interval is not None and not (run.s0 - 1e-12 <= low < high <= run.s1 + 1e-12):
            continue
        low, high = max(low, run.s0), min(high, run.s1)

        def curve(s: float, run: PathRun = run) -> tuple[Floats, Floats]:
            jet = run.evaluate(np.array([s])).tip
            return jet[0, 0], jet[1, 0]

        grid = np.linspace(low, high, SAMPLES)
        grid = np.union1d(grid, run.breaks[(run.breaks > low) & (run.breaks < high)])
        distance = np.linalg.norm(run.evaluate(grid).tip[0] - point, axis=1)
        padded = np.concatenate([[np.inf], distance, [np.inf]])
        valleys = np.flatnonzero((distance <= padded[:-2]) & (distance <= padded[2:]))
        for k in valleys[np.argsort(distance[valleys])][:STARTS]:
            left, right = grid[max(k - 1, 0)], grid[min(k + 1, len(grid) - 1)]
            s, steps = descend(curve, point, float(left), float(right), float(grid[k]))
            tip = curve(s)[0]
            found = Projection(s, index, tip, float(np.linalg.norm(tip - point)), steps)
            if best is None or found.distance < best.distance:
                best = found
    if best is None:
        raise UsageError(f"deflection: the path has no interval from s = {interval}; give one inside a run")
    return best
