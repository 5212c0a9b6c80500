"""Cuts with a known answer: a box, a tool along it, and which points of its surface are in material.

A scene is turned as a whole, so that no face of it is parallel to a ray.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from toolpace.common.arrays import Floats
from toolpace.cutting.engagement.stations import Stations
from toolpace.cutting.engagement.table import EngagementTable
from toolpace.cutting.stock.dexels import DexelStock
from toolpace.cutting.tool_profile import ToolProfile
from toolpace.programs.tool_figures import ToolFigures

ANGLES = 1440
"""At which the answer is looked at."""


def stations(tip: Floats, axis: object = (0.0, 0.0, 1.0)) -> Stations:
    """Stations of one operation, a second apart."""
    n = len(tip)
    axes = np.array(np.broadcast_to(np.asarray(axis, float), (n, 3)))
    axes /= np.linalg.norm(axes, axis=1)[:, None]
    zeros = np.zeros(n, np.int64)
    return Stations(np.ascontiguousarray(tip), axes, np.arange(n) * 1.0, zeros, zeros, np.zeros(n, np.bool_), zeros)


def rotation(seed: int | None) -> Floats:
    """A rotation matrix (3, 3); none for None."""
    if seed is None:
        return np.eye(3)
    q, r = np.linalg.qr(np.random.default_rng(seed).normal(size=(3, 3)))
    q = q * np.sign(np.diag(r))
    return q if np.linalg.det(q) > 0.0 else -q


def box_mesh(low: object, high: object) -> Floats:
    """The twelve triangles (12, 3, 3) of a box."""
    corner = np.array([low, high], float)
    triangles = []
    for d in range(3):
        u, v = (d + 1) % 3, (d + 2) % 3
        for side in range(2):
            square = np.empty((4, 3))
            square[:, d] = corner[side, d]
            square[:, u] = corner[[0, 1, 1, 0], u]
            square[:, v] = corner[[0, 0, 1, 1], v]
            if side == 0:
                square = square[::-1]
            triangles += [square[[0, 1, 2]], square[[0, 2, 3]]]
    return np.array(triangles)


@dataclass(frozen=True)
class Scene:
    """A box that is cut along a path, and what is in material of the tool's surface at one station."""

    figures: ToolFigures
    tip: Floats
    """(n, 3)"""
    axis: Floats
    """(3,) or (n, 3)"""
    station: int
    engaged: Callable[[Floats], Floats]
    """Of points (k, 3) of the tool's surface at the station: which are in material."""
    low: tuple[float, float, float] = (-0.02, -0.015, -0.006)
    high: tuple[float, float, float] = (0.02, 0.015, 0.0)

    def cut(self, resolution: float, seed: int | None) -> tuple[EngagementTable, ToolProfile, DexelStock]:
        """Cut the scene, turned at random."""
        turn = rotation(seed)
        profile = ToolProfile.of(self.figures)
        stock = DexelStock.mesh(box_mesh(self.low, self.high) @ turn.T, resolution)
        engagement = stock.cut(profile, stations(self.tip @ turn.T, np.asarray(self.axis) @ turn.T))
        return engagement, profile, stock

    def errors(self, engagement: EngagementTable, profile: ToolProfile, least: float = 0.2) -> Floats:
        """By slice (k, 2): immersion angle, and the angle over which the table is wrong; where the surface moves
        outward by more than `least` of the feed, which is where chips are thick. Slices without immersion are left
        out where the table has none."""
        i = self.station
        axis = np.broadcast_to(np.asarray(self.axis, float), (len(self.tip), 3))[i]
        motion = self.tip[i] - self.tip[i - 1]
        motion = motion / np.linalg.norm(motion)
        feed = motion - motion @ axis * axis
        feed = feed / np.linalg.norm(feed) if np.linalg.norm(feed) > 1e-9 else self.across(axis)
        left = np.cross(axis, feed)
        phi = (np.arange(ANGLES) + 0.5) * 2.0 * math.pi / ANGLES
        radial = np.cos(phi)[:, None] * left + np.sin(phi)[:, None] * feed
        arcs = slice(engagement.first_arc[i], engagement.first_arc[i + 1])
        found = []
        for j in range(math.ceil(profile.length / engagement.slice_height - 1e-9)):
            z = (j + 0.5) * engagement.slice_height
            radius, across, along = profile.surface(np.array([z]))
            points = self.tip[i] + z * axis + radius * radial
            outward = (across * radial + along * axis) @ motion
            true = self.engaged(points) & (outward > 0.0)
            table = np.zeros(ANGLES, np.bool_)
            for one, entry, leave in zip(engagement.slice[arcs], engagement.entry[arcs], engagement.exit[arcs]):
                if one == j:
                    table |= ((phi >= entry) & (phi <= leave)) | (phi + 2.0 * math.pi <= leave)
            thick = outward > least
            if true.any() or table.any():
                found.append([true.mean(), ((true != table) & thick).mean()])
        return np.array(found) * 2.0 * math.pi

    def across(self, axis: Floats) -> Floats:
        """What stands in for the feed where the tool moves along its axis."""
        feed = np.array([1.0, 0.0, 0.0]) - axis[0] * axis
        return feed / np.linalg.norm(feed)


def never_cut(profile: ToolProfile, tip: Floats, axis: Floats, points: Floats) -> Floats:
    """Which points (k, 3) are in the tool at none of the poses (n, 3)."""
    free = np.ones(len(points), np.bool_)
    for one, up in zip(tip, axis):
        near = np.flatnonzero(free)
        off = points[near] - one
        z = off @ up
        rho = np.linalg.norm(off - z[:, None] * up, axis=1)
        within = (z > 0.0) & (z < profile.length) & (rho < profile.surface(np.clip(z, 0.0, profile.length))[0] - 1e-9)
        free[near[within]] = False
    return free


def straight(begin: object, end: object, step: float = 1e-4) -> Floats:
    """Points (n, 3) along a straight line, a step apart."""
    a, b = np.asarray(begin, float), np.asarray(end, float)
    count = math.ceil(float(np.linalg.norm(b - a)) / step)
    return a + np.linspace(0.0, 1.0, count + 1)[:, None] * (b - a)
