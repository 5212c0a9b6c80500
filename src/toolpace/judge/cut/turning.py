"""What a cutter takes over a turn in a section of the material: it is turned through, tooth by tooth, in time.

Each piece of each tooth cuts, while it is in an arc of its band, as thick a chip as the surface has moved outwards
since the teeth before it passed (Kline and DeVor 1983, with runout and uneven pitch). Forces are linear in the chip
(Altintas, Manufacturing Automation, 2012). The tool bends as `beam.py` has it.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np

from toolpace.common.arrays import Floats, Ints
from toolpace.judge.cut.beam import ToolBeam
from toolpace.judge.cut.sections import Section, ToolMotion
from toolpace.machine.cutting_tool import Coefficients
from toolpace.programs.tool_figures import ToolFigures

if TYPE_CHECKING:
    from toolpace.kernels.judge.turning import EdgePieces, Teeth, Turn

STEPS = 720
"""Of a turn, at least: as many for each tooth."""
ALONG_ARC = 64
"""Places of an arc at which it is looked at how fast the surface moves outwards."""
LAG = math.radians(0.5)
"""Most lag of the helix over a piece of the edge [rad]."""
NEAR_SURFACE = math.radians(4.0)
"""How near its end in an arc is to where the chip is nothing, for the edge to leave a surface there [rad]."""
RAMP = math.sin(math.radians(3.0))
"""Sine of the slope downwards from which the flat of the end cuts with the whole force of its edge; below it the force
falls with the square of the slope, as the end rubs where a plane is rounded by a micrometre (docs/design/forces.md)."""
PIECES = 4
"""Of a band, at least."""


@dataclass(frozen=True)
class Cutting:
    """A tool at work."""

    tool: ToolFigures
    coefficients: Coefficients | None
    """None: forces are not asked for."""
    turns: float
    """Per second [1/s]."""

    @property
    def sense(self) -> float:
        """1 where it turns clockwise, seen from the spindle, else -1."""
        return 1.0 if self.tool.clockwise else -1.0

    @property
    def slope(self) -> float:
        """Lag of the edge behind its tip, over the height [rad/m]."""
        return 2.0 * math.tan(self.tool.helix) / self.tool.diameter

    @cached_property
    def pitch(self) -> Floats:
        """(teeth,) angles from each tooth to the next [rad]."""
        teeth = self.tool.teeth or 1
        return np.array(self.tool.pitch) if self.tool.pitch else np.full(teeth, 2.0 * math.pi / teeth)

    @property
    def steps(self) -> int:
        """Of a turn, as many for each tooth."""
        return len(self.pitch) * math.ceil(STEPS / len(self.pitch))

    @property
    def alike(self) -> bool:
        """Whether all teeth cut the same."""
        return not self.tool.pitch and self.tool.runout == 0.0

    def teeth(self) -> Teeth:
        """Those that are turned through: one, where all cut the same."""
        from toolpace.kernels.judge.turning import Teeth

        count, runout = len(self.pitch), self.tool.runout
        own = np.arange(1 if self.alike else count)[:, None]
        # of those that run true the one before has left the surface
        others = np.arange(1, 2 if runout == 0.0 else count + 1)
        gone = np.cumsum(self.pitch[(own + others - 1) % count], axis=1) / (2.0 * math.pi * self.turns)
        out = runout * np.stack([np.cos(self.offset), np.sin(self.offset)], axis=1)
        k = self.coefficients or Coefficients(0.0, 0.0)
        force = [
            [k.tangential, k.tangential_edge], [k.radial, k.radial_edge], [k.axial, k.axial_edge],
        ]  # fmt: skip
        ahead = out[own] - out[(own + others) % count]
        return Teeth(self.offset[own[:, 0]], gone, ahead, self.sense, np.array(force))

    @cached_property
    def offset(self) -> Floats:
        """(teeth,) angle of each tooth from the first [rad]."""
        return self.sense * np.concatenate([[0.0], np.cumsum(self.pitch)[:-1]])


def loads_of(
    section: Section, cutting: Cutting, motion: ToolMotion, beam: ToolBeam | None = None, give: Floats | None = None
) -> dict[str, float]:
    """The largest loads over a turn, in SI, by the names of limits; what nothing tells is left out.

    give: (3,) for how much deflection the path is compensated [m]; what is left of it counts as compensated. None: what
    would be left were the mean of the least and the most compensated.
    """
    tool = cutting.tool
    teeth, engaged = len(cutting.pitch), bool(section.arcs)
    per_tooth = float(np.linalg.norm(motion.velocity)) / (teeth * cutting.turns)
    radius = tool.corner_radius or 0.5 * tool.diameter
    found = {
        "feed_per_tooth": per_tooth if engaged else 0.0,
        "feed_marks": (per_tooth * teeth) ** 2 / (8.0 * radius) if engaged else 0.0,
    }
    edge = _Edge(section, motion, cutting)
    fastest, found["removal_rate"] = edge.thickest()
    found["chip"] = fastest / (teeth * cutting.turns)
    if not engaged:
        return found
    turned = edge.turned(beam)
    found |= {"area": float(turned.area.max()), "edge": float(turned.edge.max())}
    if cutting.coefficients is None:
        return found
    found |= {
        "force": float(np.linalg.norm(turned.force, axis=0).max()),
        "torque": float(np.abs(turned.torque).max()),
        "power": abs(float(turned.torque.mean())) * 2.0 * math.pi * cutting.turns,
    }
    if beam is not None:
        moment = float(np.linalg.norm(turned.moment, axis=0).max())
        found["moment"] = moment
        found["stress"] = moment / (math.pi * beam.holder_diameter**3 / 32.0)
        found["deflection"] = float(np.linalg.norm(turned.tip, axis=0).max())
        left, normal = edge.left(turned)
        found["surface_deflection"] = float(np.abs(left).max(initial=0.0))
        found["surface_mean"] = 0.5 * float(left.max() + left.min()) if len(left) else 0.0
        off = left - found["surface_mean"] if give is None else left + normal @ give
        found["compensated_deflection"] = float(np.abs(off).max(initial=0.0))
    return found


class _Turned:
    """What is taken at the steps of a turn, of all teeth."""

    def __init__(self, one: Turn, teeth: int, lines: Floats, arm: Floats) -> None:
        """Take that of one of so many teeth that are alike, deflections per force (1 + bands, p) and how far the
        pieces (p,) are from the holder."""
        self._across, self._lines, self._teeth = one.across, lines, teeth
        axial, torque, self.area, self.edge = self._of_all(one.along.T)
        self.torque = torque
        """(steps,) [N m]; and the area of the chips [m2] and the edge in material [m]."""
        self.force = np.stack([*self._of_all(one.across.sum(axis=2)), axial])
        """(3, steps) along feed, left and axis [N]."""
        self.moment = self._of_all(np.einsum("csp,p->cs", one.across, arm))
        """(2, steps) at the holder, by forces along feed and left [N m]."""
        self.tip = self._of_all(np.einsum("csp,p->cs", one.across, lines[0]))
        """(2, steps) deflection of the tip along feed and left [m]."""

    def _of_all(self, one: Floats) -> Floats:
        """(..., steps) the sum over the teeth of what one of them takes."""
        steps = one.shape[-1]
        found: Floats = np.sum([np.roll(one, k * steps // self._teeth, axis=-1) for k in range(self._teeth)], axis=0)
        return found

    def bent(self, band: int, steps: Ints) -> Floats:
        """(n, 2) deflection of a band along feed and left at some steps (n,) [m]."""
        whole = self._across.shape[1]
        of_teeth = (steps[:, None] - np.arange(self._teeth) * whole // self._teeth) % whole
        found: Floats = np.einsum("cntp,p->nc", self._across[:, of_teeth], self._lines[1 + band])
        return found


class _Edge:
    """One edge of the tool in pieces that are in material at some angle."""

    def __init__(self, section: Section, motion: ToolMotion, cutting: Cutting) -> None:
        self.section, self.motion, self.cutting = section, motion, cutting
        self.middle = section.edges.mean(axis=1)
        _, self.height, self.kappa = motion.shape.at(self.middle)
        downwards = -motion.along / max(float(np.linalg.norm(motion.velocity)), 1e-12)
        self.rubs = min(max(downwards, 0.0) / RAMP, 1.0) ** 2
        """Share of the force of the edge that the flat of the end takes."""
        self.band = np.array([band for band, _, _ in section.arcs], dtype=np.int64)
        self.arc = np.array([ends for _, *ends in section.arcs]).reshape(-1, 2)
        """(arcs, 2) entry and exit of each [rad]."""

    def thickest(self) -> tuple[float, float]:
        """The fastest that the surface moves outwards in material [m/s], and the volume that it takes [m3/s]."""
        if not len(self.band):
            return 0.0, 0.0
        angle, length = np.linspace(self.arc[:, 0], self.arc[:, 1], ALONG_ARC, axis=1), self.middle[self.band]
        moves = np.maximum(self.motion.outwards(length, angle), 0.0)
        width, radius = np.diff(self.section.edges, axis=1)[self.band, 0], self.motion.shape.at(length)[0]
        return float(moves.max()), float((width * radius * np.trapezoid(moves, angle, axis=1)).sum())

    def pieces(self) -> tuple[EdgePieces, Floats]:
        """Those of all arcs, along which the helix lags by no more than LAG, and their heights (p,) [m]."""
        from toolpace.kernels.judge.turning import EdgePieces

        edges, shape = self.section.edges[self.band], self.motion.shape
        high = np.diff(shape.at(edges.ravel())[1].reshape(-1, 2), axis=1)[:, 0]
        count = np.maximum(np.ceil(abs(self.cutting.slope) * high / LAG).astype(np.int64), PIECES)
        arc = np.repeat(np.arange(len(count)), count)
        within = np.arange(len(arc)) - np.repeat(np.cumsum(count) - count, count)
        width = ((edges[:, 1] - edges[:, 0]) / count)[arc]
        middle = edges[arc, 0] + (within + 0.5) * width
        radius, height, kappa = shape.at(middle)
        normal = np.stack([np.sin(kappa), -np.cos(kappa)], axis=1)
        of_edge = np.where(self.kappa[self.band] == 0.0, self.rubs, 1.0)[arc]
        entry, immersion = self.arc[arc, 0], self.arc[arc, 1] - self.arc[arc, 0]
        outwards, lag = self.motion.outward_terms(middle), self.cutting.slope * height
        return EdgePieces(entry, immersion, outwards, lag, width, radius, normal, of_edge), height

    def turned(self, beam: ToolBeam | None) -> _Turned:
        """All over a turn."""
        from toolpace.kernels.judge.turning import turned

        pieces, height = self.pieces()
        heights = np.concatenate([[0.0], self.height])
        lines = np.zeros((len(heights), len(height))) if beam is None else beam.compliance(heights, height)
        arm = np.zeros_like(height) if beam is None else beam.length - height
        one = turned(pieces, self.cutting.teeth(), self.cutting.steps)
        return _Turned(one, len(self.cutting.pitch) if self.cutting.alike else 1, lines, arm)

    def left(self, turned: _Turned) -> tuple[Floats, Floats]:
        """(k,) what deflection leaves on the surface at the places where the edge makes it, above zero too much [m],
        and (k, 3) the normal there, from the tool outwards."""
        found = list(self._left(turned))
        band, angle, left = np.array(found).reshape(-1, 3).T
        kappa = self.kappa[band.astype(np.int64)][:, None]
        return left, np.sin(kappa) * self.motion.direction(angle) - np.cos(kappa) * self.motion.axis

    def _left(self, turned: _Turned) -> Iterator[tuple[int, float, float]]:
        """Band, angle and what is left [m] of each."""
        cutting, steps = self.cutting, len(turned.torque)
        cosine, sine, whole = self.motion.outward_terms(self.middle).T
        size = np.hypot(cosine, sine)
        for j, (entry, leave) in zip(self.band.tolist(), self.arc.tolist()):
            across = math.sin(self.kappa[j])
            if across <= 0.0 or size[j] <= abs(whole[j]):
                continue
            middle, half = math.atan2(sine[j], cosine[j]), math.acos(-whole[j] / size[j])
            for end in (entry, leave):
                # where the surface does not move outwards the edge leaves it
                off = [(middle + side * half - end + math.pi) % (2.0 * math.pi) - math.pi for side in (-1.0, 1.0)]
                nearest = min(off, key=abs)
                if abs(nearest) > NEAR_SURFACE:
                    continue
                angle = min(max(end + nearest, entry), leave)
                # the steps at which the edges of this height are there
                step = cutting.sense * (angle + cutting.slope * self.height[j] - cutting.offset) / (2.0 * math.pi)
                low = np.floor(step * steps).astype(np.int64)
                share = (step * steps - low)[:, None]
                bent = (1.0 - share) * turned.bent(j, low) + share * turned.bent(j, low + 1)
                # of several teeth the one that reaches furthest leaves it
                yield j, angle, float((-across * (bent @ [math.sin(angle), math.cos(angle)])).min())
