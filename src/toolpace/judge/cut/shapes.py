"""The surface of a tool's cutting part, by the length along its meridian from the axis outwards and up.

The meridian is a row of lines and arcs that go over into each other. Along each the angle kappa between the axis and
the normal of the surface is known (0 below the tip, 90 degrees on a cylinder), and with it radius and height.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from toolpace.common.arrays import Floats, Ints
from toolpace.programs.tool_figures import ToolFigures

RIGHT = 0.5 * math.pi
UNKNOWN_REACH = 10.0
"""Diameters that an edge is long where nothing tells it."""


@dataclass(frozen=True)
class Shape:
    """A meridian of p pieces."""

    begin: Floats
    """(p + 1,) length at which each piece begins, and the end of the last [m]."""
    radius: Floats
    """(p,) at the begin of each [m]."""
    height: Floats
    """(p + 1,) above the tip, likewise; ascending [m]."""
    kappa: Floats
    """(p,) likewise [rad]."""
    curvature: Floats
    """(p,) [1/m]; 0 of a line."""

    @property
    def length(self) -> float:
        """Of the meridian [m]."""
        return float(self.begin[-1])

    @property
    def reach(self) -> float:
        """How far up the edge goes [m]."""
        return float(self.height[-1])

    @property
    def flat(self) -> float:
        """Radius of the flat of the end [m]."""
        return float(self.begin[1]) if self.curvature[0] == 0.0 and self.kappa[0] == 0.0 else 0.0

    @property
    def widest(self) -> float:
        """Largest radius [m]."""
        radius, _, kappa = self.at(self.begin)
        bulge = [
            float(r + (1.0 - math.sin(k)) / c)
            for r, k, c, last in zip(self.radius, self.kappa, self.curvature, kappa[1:])
            if c > 0.0 and k < RIGHT < last
        ]
        return max(float(radius.max()), *bulge, 0.0)

    def at(self, length: Floats) -> tuple[Floats, Floats, Floats]:
        """Radius, height (n,) [m] and kappa (n,) [rad] at lengths (n,) of the meridian."""
        k: Ints = np.clip(np.searchsorted(self.begin, length, side="right") - 1, 0, len(self.radius) - 1)
        on, curvature, first = length - self.begin[k], self.curvature[k], self.kappa[k]
        kappa = first + curvature * on
        arc = np.where(curvature > 0.0, curvature, 1.0)
        across = np.where(curvature > 0.0, (np.sin(kappa) - np.sin(first)) / arc, on * np.cos(first))
        up = np.where(curvature > 0.0, (np.cos(first) - np.cos(kappa)) / arc, on * np.sin(first))
        return self.radius[k] + across, self.height[k] + up, kappa

    def length_at(self, height: Floats) -> Floats:
        """(n,) the meridian's length at heights (n,) within its reach [m]."""
        k = self._piece_at(height)
        up, curvature, first = height - self.height[k], self.curvature[k], self.kappa[k]
        cosine = np.clip(np.cos(first) - curvature * up, -1.0, 1.0)
        arc = np.where(curvature > 0.0, curvature, 1.0)
        on = np.where(curvature > 0.0, (np.arccos(cosine) - first) / arc, up / np.maximum(np.sin(first), 1e-12))
        found: Floats = self.begin[k] + on
        return found

    def _piece_at(self, height: Floats) -> Ints:
        found: Ints = np.searchsorted(self.height, height, side="right") - 1
        return np.clip(found, 0, len(self.radius) - 1)


def shape_of(tool: ToolFigures) -> Shape:
    """The shape of a tool. A lens or a barrel whose large radius is half of its diameter is a ball."""
    half, corner = 0.5 * tool.diameter, min(tool.corner_radius, 0.5 * tool.diameter)
    reach = tool.flute_length or tool.stick_out or UNKNOWN_REACH * tool.diameter
    round_side = math.isfinite(tool.barrel_radius)
    if round_side and tool.barrel_radius <= half:
        pieces = [(0.0, RIGHT, half), (RIGHT, RIGHT, reach)]
    elif tool.kind == "barrel" and round_side:
        pieces = barrel_of(half, corner, tool.barrel_radius)
    elif tool.kind == "lens" and round_side:
        between = math.asin((half - corner) / (tool.barrel_radius - corner))
        pieces = [(0.0, between, tool.barrel_radius), (between, RIGHT, corner), (RIGHT, RIGHT, reach)]
    elif tool.kind in ("drill", "chamfer") and tool.point_angle > 0.0:
        side = RIGHT - 0.5 * tool.point_angle
        pieces = [(side, side, half / math.cos(side)), (RIGHT, RIGHT, reach)]
    else:
        side = RIGHT - tool.taper
        pieces = [(0.0, 0.0, half - corner), (0.0, side, corner), (side, side, reach / math.sin(side))]
    return joined(pieces, reach)


def barrel_of(half: float, corner: float, side: float) -> list[tuple[float, float, float]]:
    """A ball of the corner's radius at the tip, and the arc of the side: both centres and where they touch are on one
    line. The side is as wide as the tool at the height of its centre, and ends as far above that as it begins below."""
    between = math.asin((side - half) / (side - corner))
    return [(0.0, between, corner), (between, math.pi - between, side)]


def joined(pieces: list[tuple[float, float, float]], reach: float) -> Shape:
    """The meridian of pieces up to a height [m]: each its kappa at both ends [rad], and the radius of the arc or the
    length of the line [m]."""
    begin, height, radius, kappa, curvature = [0.0], [0.0], [0.0], [], []
    for first, last, size in pieces:
        if size <= 0.0 or height[-1] >= reach:
            continue
        bow = 0.0 if first == last else 1.0 / size
        up = size * (math.sin(first) if bow == 0.0 else math.cos(first) - math.cos(last))
        length = size if bow == 0.0 else size * (last - first)
        if height[-1] + up > reach:
            left = reach - height[-1]
            length = left / math.sin(first) if bow == 0.0 else size * (math.acos(math.cos(first) - left / size) - first)
            up = left
        across = length * math.cos(first) if bow == 0.0 else size * (math.sin(first + length / size) - math.sin(first))
        kappa.append(first)
        curvature.append(bow)
        begin.append(begin[-1] + length)
        height.append(height[-1] + up)
        radius.append(radius[-1] + across)
    return Shape(np.array(begin), np.array(radius[:-1]), np.array(height), np.array(kappa), np.array(curvature))
