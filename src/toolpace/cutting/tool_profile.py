"""The solid of revolution of a tool, in convex pieces: cutting part, shank and holder, from its figures."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from toolpace.common.arrays import Floats
from toolpace.common.errors import UsageError
from toolpace.common.value_objects import ByValue, one_line
from toolpace.programs.tool_figures import Frustum, ToolFigures

UNKNOWN_LENGTH = 10.0
"""Diameters that the cutting part is taken to be long where neither flutes nor stick-out are known."""
SHORTEST = 1e-9
"""What is shorter is rounding [m]."""


@dataclass(frozen=True, eq=False, repr=False)
class ToolProfile(ByValue):
    """Convex solids of revolution about the tool axis, heights above the tip [m].

    A solid is an array (pieces, 6) from below: z0, z1, a, b, arc, widest. Between heights z0 and z1 the radius is
    a + b z where `arc` is 0, else that of an arc of this radius about (a, b), on the side away from the axis; `widest`
    is the largest radius of the piece.
    """

    cutting: Floats
    """As far as the edge reaches."""
    shank: tuple[Floats, ...] = ()
    """From the end of the edge to the holder."""
    holder: tuple[Floats, ...] = ()

    def __repr__(self) -> str:
        return one_line(self, f"{2e3 * self.radius:g} mm wide, edge {1e3 * self.length:g} mm long")

    @staticmethod
    def of(figures: ToolFigures) -> ToolProfile:
        """The profile of a tool of any kind. Raises UsageError for arcs that do not meet."""
        reach = figures.flute_length or figures.stick_out or UNKNOWN_LENGTH * figures.diameter
        cutting = _cutting_part(figures, reach)
        shank: list[Floats] = []
        top = float(cutting[-1, 1])
        if figures.shank:
            above = sum(each.length for each in figures.shank) + top
            last = figures.shank[-1].upper_diameter
            shank = _stacked([*figures.shank, Frustum((figures.stick_out or above) - above, last, last)], top)
        elif figures.stick_out is not None and figures.stick_out > top:
            width = figures.shank_diameter or 2.0 * float(cutting[:, 5].max())
            shank = _stacked([Frustum(figures.stick_out - top, width, width)], top)
        holder = _stacked(figures.holder, figures.stick_out) if figures.stick_out is not None else []
        return ToolProfile(cutting, tuple(shank), tuple(holder))

    @property
    def radius(self) -> float:
        """Largest radius of the cutting part [m]."""
        return float(self.cutting[:, 5].max())

    @property
    def length(self) -> float:
        """Height of the end of the edge above the tip [m]."""
        return float(self.cutting[-1, 1])

    @property
    def flat_radius(self) -> float:
        """Radius of the flat of the end [m]; 0: there is none."""
        z0, _, a, b, arc, _ = self.cutting[0]
        if arc == 0.0:
            return float(a + b * z0)
        return float(max(a + math.sqrt(max(arc**2 - (z0 - b) ** 2, 0.0)), 0.0))

    def surface(self, heights: Floats) -> tuple[Floats, Floats, Floats]:
        """Radius [m] at heights (n,), and the outward normal there: across the axis, and along it."""
        k = np.clip(np.searchsorted(self.cutting[:, 1], heights, side="right"), 0, len(self.cutting) - 1)
        _, _, a, b, arc, _ = self.cutting[k].T
        slope = 1.0 / np.hypot(1.0, b)
        along = np.clip((heights - b) / np.where(arc > 0.0, arc, 1.0), -1.0, 1.0)
        across = np.sqrt(1.0 - along**2)
        straight = arc == 0.0
        radius = np.where(straight, a + b * heights, a + arc * across)
        return np.maximum(radius, 0.0), np.where(straight, slope, across), np.where(straight, -b * slope, along)


def line(z0: float, z1: float, r0: float, r1: float) -> list[float]:
    """A cone between two heights, or a cylinder."""
    slope = (r1 - r0) / (z1 - z0)
    return [z0, z1, r0 - slope * z0, slope, 0.0, max(r0, r1)]


def arc(z0: float, z1: float, centre: tuple[float, float], radius: float) -> list[float]:
    """An arc between two heights about a centre: its radius from the axis, and its height."""
    across, height = centre
    nearest = min(max(height, z0), z1) - height
    return [z0, z1, across, height, radius, across + math.sqrt(max(radius**2 - nearest**2, 0.0))]


def _stacked(frustums: Sequence[Frustum], bottom: float) -> list[Floats]:
    found = []
    for each in frustums:
        if each.length > SHORTEST:
            piece = line(bottom, bottom + each.length, 0.5 * each.lower_diameter, 0.5 * each.upper_diameter)
            found.append(np.array([piece]))
            bottom += each.length
    return found


def _cutting_part(figures: ToolFigures, reach: float) -> Floats:
    """Pieces of the cutting part, clipped to the height up to which the edge reaches."""
    radius, kind, taper = 0.5 * figures.diameter, figures.kind, figures.taper
    corner = radius if kind == "ball" else min(figures.corner_radius, radius)
    pieces: list[list[float]]
    if kind == "barrel" and math.isfinite(figures.barrel_radius):
        pieces = _barrel(radius, corner, figures.barrel_radius)
    elif kind == "lens" and math.isfinite(figures.barrel_radius):
        pieces = _lens(radius, corner, figures.barrel_radius, reach)
    elif kind in ("drill", "chamfer") and figures.point_angle > 0.0 and taper == 0.0:
        point = radius / math.tan(0.5 * figures.point_angle)
        pieces = [line(0.0, point, 0.0, radius)] if point > SHORTEST else []
        begin = point if pieces else 0.0
        pieces.append(line(begin, max(reach, begin + SHORTEST), radius, radius))
    else:
        pieces = _rounded_cone(radius, corner, taper if kind in ("taper", "chamfer", "ball", "bull") else 0.0, reach)
    return _clipped(pieces, reach)


def _rounded_cone(radius: float, corner: float, taper: float, reach: float) -> list[list[float]]:
    """A corner whose centre is at `radius` less `corner` from the axis, and the cone that it goes over into."""
    pieces = []
    begin, low = 0.0, radius
    if corner > 0.0:
        begin, low = corner * (1.0 - math.sin(taper)), radius - corner * (1.0 - math.cos(taper))
        pieces.append(arc(0.0, begin, (radius - corner, corner), corner))
    end = max(reach, begin + SHORTEST)
    pieces.append(line(begin, end, low, low + (end - begin) * math.tan(taper)))
    return pieces


def _barrel(radius: float, corner: float, side: float) -> list[list[float]]:
    """A tip of the corner's radius about the axis, and the arc of the side, that it goes over into.

    The side is as wide as the tool at the height of its centre. Raises UsageError where the arcs do not meet.
    """
    if side <= radius or corner >= side:
        raise UsageError(
            f"barrel radius is {1e3 * side:g} mm, half the diameter {1e3 * radius:g} mm; give a larger barrel radius"
        )
    height = corner + math.sqrt((side - corner) ** 2 - (side - radius) ** 2)
    # the centres of both arcs and the point in which they touch are on one line
    begin = height - (height - corner) * side / (side - corner)
    pieces = [arc(0.0, begin, (0.0, corner), corner)] if begin > 0.0 else []
    pieces.append(arc(max(begin, 0.0), 2.0 * height - max(begin, 0.0), (radius - side, height), side))
    return pieces


def _lens(radius: float, corner: float, end: float, reach: float) -> list[list[float]]:
    """An end of a large radius about the axis, the corner that it goes over into, and a straight side."""
    if end <= radius or corner >= end:
        return _rounded_cone(radius, radius, 0.0, reach)
    # the centres of both arcs and the point in which they touch are on one line
    height = end - math.sqrt((end - corner) ** 2 - (radius - corner) ** 2)
    begin = end - (end - height) * end / (end - corner)
    pieces = [arc(0.0, begin, (0.0, end), end)]
    if corner > 0.0:
        pieces.append(arc(begin, height, (radius - corner, height), corner))
    side = height if corner > 0.0 else begin
    pieces.append(line(side, max(reach, side + SHORTEST), radius, radius))
    return pieces


def _clipped(pieces: list[list[float]], reach: float) -> Floats:
    found = []
    for z0, z1, a, b, bow, widest in pieces:
        if z0 < reach - SHORTEST:
            end = min(z1, reach)
            if bow > 0.0:
                found.append(arc(z0, end, (a, b), bow))
            else:
                found.append([z0, end, a, b, 0.0, min(widest, max(a + b * z0, a + b * end))])
    return np.array(found)
