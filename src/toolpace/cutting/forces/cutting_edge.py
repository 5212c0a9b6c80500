"""The cutting edge of a tool as points along its meridian: radius, normal of the surface, and lag behind the tip.

The helix has a constant lead: at the height z the edge lags by z tan(helix) / R, R half of the diameter, on cylinders,
balls and cones alike (Lee and Altintas 1996, and Engin and Altintas 2001 for constant lead).
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from toolpace.common.arrays import Floats, Ints
from toolpace.cutting.tool_profile import ToolProfile
from toolpace.programs.tool_figures import ToolFigures

BEND = math.radians(2.0)
"""Most turning of the surface's normal over a piece [rad]. Two points a piece integrate it to 1e-9; but where the chip
begins within a piece (a ball that goes up), a point is in the chip or not. At 6 degrees that cost 1.7 percent."""
END = 8
"""Pieces of the flat end."""
GAUSS = 0.5 / math.sqrt(3.0)
"""How far the two points of Gauss and Legendre are from the middle of a piece, over its length."""


@dataclass(frozen=True)
class CuttingEdge:
    """The points of one edge, p of them, ordered by slice; the flat end of the tool is the last slice."""

    first: Ints
    """(slices + 2,) points of slice j are first[j] to first[j + 1]."""
    height: Floats
    """(p,) above the tip [m]."""
    radius: Floats
    """(p,) [m]"""
    kappa: Floats
    """(p,) angle between the axis and the normal of the surface [rad]: 0 of the flat end, 90 degrees on a cylinder."""
    lag: Floats
    """(p,) angle by which it is behind the tip of the edge [rad]; below zero where the tool is left-handed."""
    span: Floats
    """(p,) difference of the lag between both ends of its piece [rad]."""
    width: Floats
    """(p,) length of its piece of the meridian [m]."""

    @classmethod
    def of(cls, tool: ToolFigures, slice_height: float, slices: int, most_lag: float) -> CuttingEdge:
        """The edge of a tool in slices of a height [m], from the tip up to where it ends. Raises UsageError.

        most_lag: of the helix over a piece [rad].
        """
        profile = ToolProfile.of(tool)
        slope = 2.0 * math.tan(tool.helix) / tool.diameter
        rows = [np.zeros((5, 0))]
        first = [0]
        for j in range(slices):
            for part in profile.cutting:
                low, high = max(j * slice_height, part[0]), min((j + 1) * slice_height, part[1])
                if high > low:
                    rows.append(_points(part, low, high, slope, most_lag))
            first.append(sum(row.shape[1] for row in rows))
        if profile.flat_radius > 0.0:
            length = profile.flat_radius / END
            radius = length * (np.arange(END) + 0.5)
            rows.append(np.stack([0.0 * radius, radius, 0.0 * radius, 0.0 * radius, np.full(END, length)]))
        first.append(sum(row.shape[1] for row in rows))
        height, radius, kappa, span, width = np.concatenate(rows, axis=1)
        return cls(np.array(first), height, radius, kappa, slope * height, span, width)


def _points(part: Floats, low: float, high: float, slope: float, most_lag: float) -> Floats:
    """Height, radius, kappa, span of the lag and width (5, p) of points between two heights of a part of a profile.

    part: (6,) see `ToolProfile`.
    """
    a, b, bow = part[2], part[3], part[4]
    lag = abs(slope) * (high - low)
    if bow == 0.0:
        pieces = max(math.ceil(lag / most_lag), 1)
        edges = np.linspace(low, high, pieces + 1)
        height = 0.5 * (edges[1:] + edges[:-1])
        width = np.full(pieces, (high - low) / pieces * math.hypot(1.0, b))
        kappa = np.full(pieces, math.atan2(1.0, b))
        return np.stack([height, a + b * height, kappa, np.full(pieces, lag / pieces), width])
    ends = np.arccos(np.clip((b - np.array([low, high])) / bow, -1.0, 1.0))
    pieces = max(math.ceil(lag / most_lag), math.ceil((ends[1] - ends[0]) / BEND), 1)
    edges = np.linspace(ends[0], ends[1], pieces + 1)
    turned = np.diff(edges)[:, None]
    kappa = (0.5 * (edges[1:] + edges[:-1])[:, None] + GAUSS * turned * np.array([-1.0, 1.0])).ravel()
    half = np.repeat(0.5 * turned, 2)
    return np.stack(
        [b - bow * np.cos(kappa), a + bow * np.sin(kappa), kappa, abs(slope) * bow * np.sin(kappa) * half, bow * half]
    )
