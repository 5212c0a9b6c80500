"""Cutting forces by summation over pieces of each edge, angle by angle.

The mean is an integral over the angles of immersion, tooth by tooth and height by height; the peak is looked for over a
turn, with an integral along each edge.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field

import numpy as np

from toolpace.common.arrays import Floats
from toolpace.machine.cutting_tool import Cut

ANGLES = 240
"""Places of the integral over the immersion, by Gauss and Legendre."""
NODES = np.polynomial.legendre.leggauss(ANGLES)
HEIGHTS = np.polynomial.legendre.leggauss(12)
"""The same along an edge, over what of it is in the material."""
TURN = 900
"""Angles of a turn at which the peak is looked for."""
SLICE = 0.04
"""Lag of the helix over a slice [rad]."""
CHIPS = 25
"""Feeds per tooth at which the force is worked out; between them it is interpolated."""


@dataclass(frozen=True)
class ForceTable:
    """Forces along the feed, its normal and the tool axis [N], over feeds per tooth up to `most` [m]."""

    cut: Cut
    kind: str
    most: float
    chips: Floats = field(init=False)
    forces: Floats = field(init=False)

    def __post_init__(self) -> None:
        chips = max(self.most, 1e-9) * np.linspace(1e-7, 1.0, CHIPS)
        one = self.mean if self.kind == "mean" else self.peak
        object.__setattr__(self, "chips", chips)
        object.__setattr__(self, "forces", np.array([one(float(chip)) for chip in chips]))

    def at(self, chip: Floats) -> Floats:
        """(n, 3) forces at feeds per tooth (n,); none without a feed."""
        found = np.column_stack([np.interp(chip, self.chips, column) for column in self.forces.T])
        found[~(chip > 0.0)] = 0.0
        return found

    @property
    def angles(self) -> tuple[float, float]:
        """Between which the material is; from the normal on the left, over the front, to the right."""
        how = self.cut.engagement
        if how.milling == "slot":
            return 0.0, math.pi
        radius = 0.5 * self.cut.cutter.diameter
        wide = math.pi / 2 - math.asin((radius - how.radial_depth) / radius)
        return (0.0, wide) if how.milling == "up" else (math.pi - wide, math.pi)

    def mean(self, chip: float) -> Floats:
        """(3,) mean over a turn."""
        start, end = self.angles
        nodes, weights = NODES
        phi = 0.5 * (end - start) * nodes + 0.5 * (end + start)
        share = 0.5 * (end - start) * weights / (2.0 * math.pi)
        # without runout all heights are alike
        count = math.floor(abs(self.lag(self.depth)) / SLICE) + 1 if self.cut.cutter.runout > 0.0 else 1
        z = self.depth * (np.arange(count) + 0.5) / count
        total = np.zeros(3)
        for tooth in range(self.cut.cutter.teeth):
            per_depth = self.edge(tooth, phi[:, None], z[None, :], chip).mean(axis=1)
            total += share @ per_depth
        return total * self.depth

    def peak(self, chip: float) -> Floats:
        """(3,) along the mean, as large as the force is at most across the tool."""
        total = np.zeros((TURN, 3))
        for tooth in range(self.cut.cutter.teeth):
            ahead = 2.0 * math.pi * (np.arange(TURN) / TURN + tooth / self.cut.cutter.teeth)
            # an edge may be in the material with its tip some turns ahead
            for turns in range(math.ceil(abs(self.lag(self.depth)) / (2.0 * math.pi)) + 1):
                sense = 1.0 if self.cut.cutter.helix >= 0.0 else -1.0
                total += self.along_edge(tooth, ahead % (2.0 * math.pi) + sense * 2.0 * math.pi * turns, chip)
        mean = self.mean(chip)
        largest = math.sqrt(float((total[:, :2] ** 2).sum(axis=1).max()))
        return mean * (largest / math.hypot(mean[0], mean[1]))

    def along_edge(self, tooth: int, phi: Floats, chip: float) -> Floats:
        """(n, 3) force of an edge whose tip is at angles phi (n,), summed up over what of it is in the material."""
        start, end = self.angles
        slope = self.lag(1.0)
        if slope == 0.0:
            low = np.zeros(len(phi))
            high = np.where((phi >= start) & (phi <= end), self.depth, 0.0)
        else:
            ends = np.sort([(phi - end) / slope, (phi - start) / slope], axis=0)
            low, high = np.clip(ends, 0.0, self.depth)
        nodes, weights = HEIGHTS
        z = 0.5 * (high - low)[:, None] * nodes + 0.5 * (high + low)[:, None]
        force = self.edge(tooth, phi[:, None] - slope * z, z, chip)
        summed: Floats = np.einsum("nzc,z->nc", force, weights) * (0.5 * (high - low))[:, None]
        return summed

    @property
    def depth(self) -> float:
        """Of the cut along the axis [m]."""
        return self.cut.engagement.axial_depth

    def lag(self, z: float) -> float:
        """By how much an edge lags behind its tip at a height [rad]."""
        return 2.0 * math.tan(self.cut.cutter.helix) / self.cut.cutter.diameter * z

    def edge(self, tooth: int, phi: Floats, z: Floats, chip: float) -> Floats:
        """(..., 3) force per depth [N/m] of an edge at angles phi and heights z, in the material."""
        k = self.cut.coefficients
        thick = self.thickness(tooth, phi, z, chip)
        here = thick > 0.0
        forward = np.stack([np.cos(phi), -np.sin(phi)], axis=-1)
        outward = np.stack([np.sin(phi), np.cos(phi)], axis=-1)
        back = here * (k.tangential * thick + k.tangential_edge)
        inward = here * (k.radial * thick + k.radial_edge)
        down = here * (k.axial * thick + k.axial_edge)
        across = -back[..., None] * forward - inward[..., None] * outward
        if not self.cut.clockwise:
            across = across * np.array([1.0, -1.0])
        return np.concatenate([across, -down[..., None]], axis=-1)

    def thickness(self, tooth: int, phi: Floats, z: Floats, chip: float) -> Floats:
        """What is left of the chip by the teeth that passed before: by the one of them that reached furthest."""
        cutter = self.cut.cutter
        lag = self.lag(1.0) * z
        surfaces = []
        for before in range(1, cutter.teeth + 1):
            other = tooth + before
            surfaces.append(self.reach(other, lag) - before * chip * np.sin(phi))
        left: Floats = self.reach(tooth, lag) - np.max(np.broadcast_arrays(*surfaces), axis=0)
        return left

    def reach(self, tooth: int, lag: Floats) -> Floats:
        """By how much an edge is further out than without runout [m]."""
        cutter = self.cut.cutter
        where = 2.0 * math.pi * (tooth % cutter.teeth) / cutter.teeth - lag
        out: Floats = cutter.runout * np.cos(where - cutter.runout_angle)
        return out
