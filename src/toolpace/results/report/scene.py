"""The tip's path in space with the tool axis as line segments, decimated."""

from __future__ import annotations

import numpy as np

from toolpace.common.arrays import Floats, Ints
from toolpace.motion.setpoints import SetPoints
from toolpace.results.report.series import encoded, tip_speed

MOST = 24_000
"""Points of the tip's way: a browser turns so many in space without a jerk, and chords of them look like the curve."""
WHISKERS = 500
"""Tool axes drawn: more would hide the way of the tip."""


def stations(setpoints: SetPoints, most: int = MOST) -> Ints:
    """Set-points to draw: as many in equal steps of time as in equal steps of length, so that neither slow
    corners nor fast moves turn into polygons."""
    n = len(setpoints)
    if n <= most:
        return np.arange(n)
    length = np.concatenate(([0.0], np.cumsum(setpoints.tip_steps)))
    measure = np.arange(n) / (n - 1) + length / max(float(length[-1]), 1e-30)
    at = np.searchsorted(measure, np.linspace(0.0, measure[-1], most))
    found: Ints = np.unique(np.clip(at, 0, n - 1))
    return found


def scene_data(setpoints: SetPoints, at: Ints, limiting: Ints, cap: Floats | None) -> dict[str, object]:
    """Data of the picture: tip [mm], speed [mm/min], what binds, block, and the whiskers, at the set-points
    `at`."""
    tip = setpoints.tip[at] * 1e3
    speed = tip_speed(setpoints)[at] * 60e3
    # Rapids would take the whole range of colours; it belongs to the cut.
    cutting = np.isfinite(cap[at]) if cap is not None else np.ones(len(at), dtype=bool)
    top = float(speed[cutting].max()) if cutting.any() else float(speed.max())
    size = float(np.sqrt(((tip.max(axis=0) - tip.min(axis=0)) ** 2).sum()))
    moved = np.concatenate(([0.0], np.cumsum(np.sqrt(((tip[1:] - tip[:-1]) ** 2).sum(axis=1)))))
    turned = np.concatenate(([0.0], np.cumsum(np.sqrt((np.diff(setpoints.axis[at], axis=0) ** 2).sum(axis=1)))))
    measure = moved / max(moved[-1], 1e-12) + 0.5 * turned / max(turned[-1], 1e-12)
    some = np.unique(np.clip(np.searchsorted(measure, np.linspace(0.0, measure[-1], WHISKERS)), 0, len(at) - 1))
    whiskers = np.full((len(some), 3, 3), np.nan)
    whiskers[:, 0] = tip[some]
    whiskers[:, 1] = tip[some] + setpoints.axis[at[some]] * max(0.07 * size, 1.0)
    return {
        "x": encoded(tip[:, 0].astype("<f4")),
        "y": encoded(tip[:, 1].astype("<f4")),
        "z": encoded(tip[:, 2].astype("<f4")),
        "speed": encoded(speed.astype("<f4")),
        "top": max(top, 1e-9),
        "limiting": encoded(limiting.astype("<i2")),
        "block": encoded(setpoints.block[at].astype("<i4")),
        "t": encoded(setpoints.t[at].astype("<f4")),
        "whiskers": [encoded(whiskers[:, :, k].ravel().astype("<f4")) for k in range(3)],
    }
