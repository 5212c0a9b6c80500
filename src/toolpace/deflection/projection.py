"""The projection of a deflection on a path: the nearest point, by bounds or by the paper's potential field.

Source: Wu, Li, Liu, Perez, ACC 2009, section II.D. The target slides along the path as its attraction to the
deflection pulls it, until no force along the path is left.

             o deflection
            /
    -------x-----------> path          x: what is left of the force is across the path
"""

from __future__ import annotations

import warnings
from collections.abc import Callable

import numpy as np
import numpy.typing as npt

from toolpace.common.arrays import Floats, number, numbers
from toolpace.common.errors import UsageError, did_you_mean
from toolpace.deflection.nearest_point import CONVERGED, ROUNDING, Projection, Stretch, nearest, stretches
from toolpace.path.path import Path

__all__ = ["Projection", "force", "potential", "project"]

SAMPLES = 400
"""Points of a run, beside its breaks, from which the nearest ones are taken as starts."""
STARTS = 4
"""Nearest valleys of the distance that are descended into; of two as near the lower one is not known before."""
MOST_STEPS = 500
"""Of one descent. Each is Gauss-Newton's, and near the path a few of them reach the last digits."""
METHODS = ("bounds", "potential")
TOLERANCE = 1e-9
"""By which another point of the path may be nearer [m]."""


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
    alpha, m, n = number(alpha, "potential: alpha"), number(m, "potential: m"), number(n, "potential: n")
    value: float = alpha * float(np.linalg.norm(_apart(target, deflection, "potential"))) ** m
    if velocity is not None:
        if len(velocity) != 2:
            raise UsageError(f"potential: velocity has {len(velocity)} parts; give that of the target and the other")
        alpha_velocity = number(alpha_velocity, "potential: alpha_velocity")
        value += alpha_velocity * float(np.linalg.norm(_apart(*velocity, "potential: velocity of"))) ** n
    return value


def force(target: npt.ArrayLike, deflection: npt.ArrayLike, *, alpha: float = 1.0, m: float = 2.0) -> Floats:
    """(3,) the negative gradient of the potential by the position of the target, Eq. (9)."""
    alpha, m = number(alpha, "force: alpha"), number(m, "force: m")
    apart = _apart(target, deflection, "force")
    distance = float(np.linalg.norm(apart))
    if distance == 0.0:
        return np.zeros(3)
    pull: Floats = -alpha * m * distance ** (m - 2.0) * apart
    return pull


def _apart(target: npt.ArrayLike, deflection: npt.ArrayLike, caller: str) -> Floats:
    """(3,) the way from a deflection to a target."""
    return numbers(target, f"{caller}: target", (3,)) - numbers(deflection, f"{caller}: deflection", (3,))


def descend(
    curve: Callable[[float], tuple[Floats, Floats]], deflection: Floats, low: float, high: float, start: float
) -> tuple[float, int]:
    """Follow the force along a curve, s -> (tip (3,), derivative (3,)), within [low, high]: s and steps.

    Each step is the force along the path over the stiffness of the field there, halved until the potential falls: the
    iteration of Gauss and Newton, which shrinks the error by the factor distance times curvature. Raises UsageError
    where that is so near to one that the most steps do not bring the target to rest.
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
    raise UsageError(
        f"deflection: the potential field has not come to rest after {MOST_STEPS} steps, at s = {s:.9g}, for the path"
        " bends about the deflection; take the method 'bounds'"
    )


def nearest_by_field(stretches: list[Stretch], point: Floats) -> Projection:
    """The lowest place to which the field draws targets from the nearest samples of each stretch.

    A valley narrower than the samples is missed. Raises UsageError where a target is not at rest after the most steps.
    """
    best: Projection | None = None
    for stretch in stretches:
        grid = np.linspace(stretch.low, stretch.high, SAMPLES)
        breaks = stretch.run.breaks
        grid = np.union1d(grid, breaks[(breaks > stretch.low) & (breaks < stretch.high)])
        distance = np.linalg.norm(stretch.tip(grid)[0] - point, axis=1)
        padded = np.concatenate([[np.inf], distance, [np.inf]])
        valleys = np.flatnonzero((distance <= padded[:-2]) & (distance <= padded[2:]))

        def curve(s: float, stretch: Stretch = stretch) -> tuple[Floats, Floats]:
            jet = stretch.tip(np.array([s]))
            return jet[0, 0], jet[1, 0]

        for k in valleys[np.argsort(distance[valleys])][:STARTS]:
            left, right = grid[max(k - 1, 0)], grid[min(k + 1, len(grid) - 1)]
            s, steps = descend(curve, point, float(left), float(right), float(grid[k]))
            tip = curve(s)[0]
            found = Projection(s, stretch.index, tip, float(np.linalg.norm(tip - point)), steps, np.inf, False)
            if best is None or found.distance < best.distance:
                best = found
    assert best is not None
    return best


def project(
    path: Path,
    tip: npt.ArrayLike | None = None,
    *,
    deflection: npt.ArrayLike | None = None,
    interval: tuple[float, float] | None = None,
    method: str = "bounds",
    tolerance: float = TOLERANCE,
) -> Projection:
    """The point of a path, or of the `interval` (from s, to s) of one of its runs, nearest to a `tip` (3,) [m].

    The paper looks on the interval on which the tool was; with u clipped to [0, 1] its ends count too. The whole path
    is the default.

    By "bounds" no point is missed: none of the path is nearer by more than the `tolerance` [m], and the result says by
    how much at most (`within`). That is proven for fitted paths, B-splines, quintic intervals and arcs, whose second
    derivatives are bounded by their control points; of a path given as a function only samples tell (`proven`). By
    "potential", the paper's way, a target is drawn along the path from the nearest of 400 samples, which finds a valley
    only where the samples do. Time grows in proportion to the pieces of the path.

    `deflection` is the former name of `tip`. Raises UsageError for a position that is not finite, an interval that lies
    on no run or on several, and a potential field that does not come to rest, and PathError for a path whose
    derivatives are not finite.
    """
    if deflection is not None and tip is None:
        warnings.warn("project: deflection= is called tip= now", DeprecationWarning, stacklevel=2)
        tip = deflection
    point = numbers(tip, "project: tip", (3,), unit="m")
    if method not in METHODS:
        raise UsageError(f"deflection: unknown method '{method}'; {did_you_mean(method, METHODS)}")
    tolerance = number(tolerance, "deflection: tolerance", least=0.0, above=True, unit="m")
    parts = stretches(path, interval)
    return nearest_by_field(parts, point) if method == "potential" else nearest(parts, point, tolerance)
