"""The projection of a deflection on a path: the nearest point, by bounds or by the paper's potential field."""

from __future__ import annotations

import warnings

import numpy.typing as npt

from toolpace.common.arrays import number, numbers
from toolpace.common.errors import UsageError, did_you_mean
from toolpace.deflection.projection.branch_and_bound import nearest
from toolpace.deflection.projection.potential import force, nearest_by_field, potential
from toolpace.deflection.projection.stretch import Projection, stretches
from toolpace.path.path import Path

__all__ = ["Projection", "force", "potential", "project"]

METHODS = ("bounds", "potential")
TOLERANCE = 1e-9
"""[m]"""


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
