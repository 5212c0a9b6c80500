"""What a cutter takes over a turn in a section of the material: it is turned through, tooth by tooth, in time.

Each piece of each tooth cuts, while it is in an arc of its band, as thick a chip as the surface has moved outwards
since the teeth before it passed (Kline and DeVor 1983, with runout and uneven pitch). Forces are linear in the chip
(Altintas, Manufacturing Automation, 2012). The tool bends as a cantilever, whose lines are summed here in steps.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from toolpace.common.arrays import Floats, Ints
from toolpace.judge.cut.sections import Section, ToolMotion
from toolpace.machine.cutting_tool import Coefficients
from toolpace.programs.tool_figures import ToolFigures

STEPS = 720
"""Of a turn, at least: as many for each tooth."""
ALONG_ARC = 64
"""Places of an arc at which it is looked at how fast the surface moves outwards."""
LAG = math.radians(0.5)
"""Most lag of the helix over a piece of the edge [rad]."""
NEAR_SURFACE = math.radians(4.0)
"""How near its end in an arc is to where the chip is nothing, for the edge to leave a surface there [rad]."""
FLUTES = 0.8
"""Diameter of the bar that bends as flutes do, over theirs (Kops and Vo 1990)."""
MODULI = {"carbide": 580e9, "hss": 207e9, "steel": 207e9, "ceramic": 310e9, "cermet": 450e9}
"""Young's modulus of the material of a tool [Pa]."""
BEAM_STEPS = 2000
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

    @cached_property
    def offset(self) -> Floats:
        """(teeth,) angle of each tooth from the first [rad]."""
        return self.sense * np.concatenate([[0.0], np.cumsum(self.pitch)[:-1]])


def loads_of(section: Section, cutting: Cutting, motion: ToolMotion) -> dict[str, float]:
    """The largest loads over a turn, in SI, by the names of limits; what nothing tells is left out."""
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
    beam = None if tool.stick_out is None else _Beam(tool, edge.height)
    turned = edge.turned(beam)
    found |= {"area": float(turned.area.max()), "edge": float(turned.edge.max())}
    if cutting.coefficients is None:
        return found
    size = np.linalg.norm(turned.force, axis=1)
    found |= {
        "force": float(size.max()),
        "torque": float(np.abs(turned.torque).max()),
        "power": abs(float(turned.torque.mean())) * 2.0 * math.pi * cutting.turns,
    }
    if beam is not None:
        moment = float(np.linalg.norm(turned.moment, axis=1).max())
        found["moment"] = moment
        found["stress"] = moment / (math.pi * beam.holder_diameter**3 / 32.0)
        found["deflection"] = float(np.linalg.norm(turned.bent[:, 0], axis=1).max())
        left = edge.left(turned)
        found["surface_deflection"] = float(np.abs(left).max(initial=0.0))
        found["compensated_deflection"] = 0.5 * float(np.ptp(left)) if len(left) else 0.0
        found["surface_mean"] = 0.5 * float(left.max() + left.min()) if len(left) else 0.0
    return found


class _Turned:
    """What adds up over the steps of a turn."""

    def __init__(self, steps: int, heights: int) -> None:
        self.force = np.zeros((steps, 3))
        """Along feed, left and axis [N]."""
        self.torque = np.zeros(steps)
        """[N m]"""
        self.moment = np.zeros((steps, 2))
        """At the holder, by forces along feed and left [N m]."""
        self.area = np.zeros(steps)
        """Of the chips of all teeth [m2]."""
        self.edge = np.zeros(steps)
        """In material, as width of the chips [m]."""
        self.bent = np.zeros((steps, 1 + heights, 2))
        """Along feed and left [m]; of the tip first, then of the bands."""

    def of_all(self, teeth: int) -> _Turned:
        """That of so many teeth, all alike, from that of one."""
        found = _Turned(len(self.torque), self.bent.shape[1] - 1)
        for name, one in vars(self).items():
            rolled = [np.roll(one, k * len(one) // teeth, axis=0) for k in range(teeth)]
            setattr(found, name, np.sum(rolled, axis=0))
        return found


@dataclass(frozen=True)
class _Pieces:
    """p pieces of one edge within a band."""

    middle: Floats
    """(p,) lengths of the meridian [m]."""
    width: Floats
    """(p,) along it [m]."""
    radius: Floats
    height: Floats
    sine: Floats
    """(p,) across the axis, of the surface's normal."""
    cosine: Floats
    """(p,) up along the axis."""


class _Edge:
    """One edge of the tool in pieces that are in material at some angle."""

    def __init__(self, section: Section, motion: ToolMotion, cutting: Cutting) -> None:
        self.section, self.motion, self.cutting = section, motion, cutting
        self.middle = section.edges.mean(axis=1)
        _, self.height, self.kappa = motion.shape.at(self.middle)
        downwards = -motion.along / max(float(np.linalg.norm(motion.velocity)), 1e-12)
        self.rubs = min(max(downwards, 0.0) / RAMP, 1.0) ** 2
        """Share of the force of the edge that the flat of the end takes."""

    def thickest(self) -> tuple[float, float]:
        """The fastest that the surface moves outwards in material [m/s], and the volume that it takes [m3/s]."""
        if not self.section.arcs:
            return 0.0, 0.0
        band, entry, leave = (np.array(each) for each in zip(*self.section.arcs))
        angle = np.linspace(entry, leave, ALONG_ARC, axis=1)
        length = np.repeat(self.middle[band], ALONG_ARC)
        moves = np.maximum(self.motion.outwards(length, angle.ravel()), 0.0).reshape(angle.shape)
        width, radius = np.diff(self.section.edges, axis=1)[band, 0], self.motion.shape.at(self.middle[band])[0]
        return float(moves.max()), float((width * radius * np.trapezoid(moves, angle, axis=1)).sum())

    def pieces(self, band: int) -> _Pieces:
        """Those of a band."""
        low, high = self.section.edges[band]
        _, ends, _ = self.motion.shape.at(self.section.edges[band])
        lag = abs(self.cutting.slope) * float(ends[1] - ends[0])
        rim = np.linspace(low, high, max(math.ceil(lag / LAG), PIECES) + 1)
        middle = 0.5 * (rim[1:] + rim[:-1])
        radius, height, kappa = self.motion.shape.at(middle)
        return _Pieces(middle, np.diff(rim), radius, height, np.sin(kappa), -np.cos(kappa))

    def turned(self, beam: _Beam | None) -> _Turned:
        """All over a turn."""
        teeth = len(self.cutting.pitch)
        found = _Turned(self.cutting.steps, len(self.height))
        for j, entry, leave in self.section.arcs:
            pieces = self.pieces(j)
            of_edge = self.rubs if self.kappa[j] == 0.0 else 1.0
            for tooth in range(1 if self.cutting.alike else teeth):
                self._add(found, pieces, (entry, leave), tooth, of_edge, beam)
        return found.of_all(teeth) if self.cutting.alike else found

    def _add(
        self, found: _Turned, pieces: _Pieces, arc: tuple[float, float], tooth: int, of_edge: float, beam: _Beam | None
    ) -> None:
        """Add what the pieces of a tooth take in an arc; of_edge: share of the force of the edge that counts."""
        cutting, k, steps = self.cutting, self.cutting.coefficients or Coefficients(0.0, 0.0), len(found.torque)
        theta = cutting.sense * 2.0 * math.pi * np.arange(steps) / steps
        phi = theta[:, None] + cutting.offset[tooth] - cutting.slope * pieces.height
        at, piece = np.nonzero((phi - arc[0]) % (2.0 * math.pi) < arc[1] - arc[0])
        phi = phi[at, piece]
        chip = self._chip(pieces, piece, phi, tooth)
        cut = chip > 0.0
        at, piece, phi, h = at[cut], piece[cut], phi[cut], chip[cut]
        b, s, c = pieces.width[piece], pieces.sine[piece], pieces.cosine[piece]
        tangential, radial, axial = (
            (per_chip * h + of_edge * per_edge) * b
            for per_chip, per_edge in (
                (k.tangential, k.tangential_edge), (k.radial, k.radial_edge), (k.axial, k.axial_edge),
            )
        )  # fmt: skip
        # the radial force pushes the edge away from material, the axial one up along the meridian
        inwards = radial * s - axial * c
        parts = (
            -inwards * np.sin(phi) - cutting.sense * tangential * np.cos(phi),
            -inwards * np.cos(phi) + cutting.sense * tangential * np.sin(phi),
            -radial * c - axial * s,
        )
        for column, part in enumerate(parts):
            found.force[:, column] += np.bincount(at, part, minlength=steps)
        found.torque += np.bincount(at, tangential * pieces.radius[piece], minlength=steps)
        found.area += np.bincount(at, h * b, minlength=steps)
        found.edge += np.bincount(at, of_edge * b, minlength=steps)
        if beam is None:
            return
        arm, lines = beam.length - pieces.height[piece], beam.lines(pieces.height)[:, piece]
        for column in range(2):
            found.moment[:, column] += np.bincount(at, parts[column] * arm, minlength=steps)
            for w in range(len(lines)):
                found.bent[:, w, column] += np.bincount(at, parts[column] * lines[w], minlength=steps)

    def _chip(self, pieces: _Pieces, piece: Ints, phi: Floats, tooth: int) -> Floats:
        """(n,) thickness of the chip of a tooth [m]: what the surface gained since each of the others passed."""
        cutting = self.cutting
        outwards = self.motion.outwards(pieces.middle[piece], phi)
        count, runout, lag = len(cutting.pitch), cutting.tool.runout, cutting.slope * pieces.height[piece]
        own = runout * np.cos(-cutting.offset[tooth] + lag)
        chip, gone = np.full(len(phi), np.inf), 0.0
        for m in range(1, count + 1):
            gone += float(cutting.pitch[(tooth + m - 1) % count]) / (2.0 * math.pi * cutting.turns)
            other = runout * np.cos(-cutting.offset[(tooth + m) % count] + lag)
            chip = np.minimum(chip, outwards * gone + (own - other) * pieces.sine[piece])
            if runout == 0.0:
                break
        return chip

    def left(self, turned: _Turned) -> Floats:
        """(k,) what deflection leaves on the surface at the places where the edge makes it, above zero too much [m]."""
        return np.array(list(self._left(turned)))

    def _left(self, turned: _Turned) -> Iterator[float]:
        cutting = self.cutting
        for j, entry, leave in self.section.arcs:
            sine = math.sin(self.kappa[j])
            steps = len(turned.torque)
            for end in (entry, leave) if sine > 0.0 else ():
                place = self._without_chip(self.middle[j], end)
                if place is None or abs(place - end) > NEAR_SURFACE:
                    continue
                angle, off = min(max(place, entry), leave), []
                for offset in cutting.offset.tolist():
                    # the step at which the edge of this height is there
                    step = cutting.sense * (angle + cutting.slope * self.height[j] - offset) / (2.0 * math.pi) * steps
                    low = math.floor(step)
                    ends = turned.bent[low % steps, 1 + j], turned.bent[(low + 1) % steps, 1 + j]
                    bent = ends[0] + (step - low) * (ends[1] - ends[0])
                    off.append(-sine * float(bent[0] * math.sin(angle) + bent[1] * math.cos(angle)))
                # of several teeth the one that reaches furthest leaves it
                yield min(off)

    def _without_chip(self, length: float, end: float) -> float | None:
        """The angle nearest to an end at which the surface does not move outwards; None where there is none near."""
        angle = end + np.linspace(-2.0 * NEAR_SURFACE, 2.0 * NEAR_SURFACE, 81)
        moves = self.motion.outwards(np.full(81, length), angle)
        change = np.flatnonzero(moves[1:] * moves[:-1] <= 0.0)
        if not len(change):
            return None
        k = int(change[np.abs(angle[change] - end).argmin()])
        span = float(moves[k] - moves[k + 1])
        return float(angle[k] + (angle[k + 1] - angle[k]) * (moves[k] / span if span else 0.0))


class _Beam:
    """A tool as a cantilever from its holder."""

    def __init__(self, tool: ToolFigures, heights: Floats) -> None:
        assert tool.stick_out is not None
        self.length = tool.stick_out
        self.at = np.concatenate([[0.0], heights])
        flutes = min(tool.flute_length or tool.stick_out, tool.stick_out)
        cone = math.tan(tool.taper) if tool.kind == "taper" else 0.0
        edges = np.linspace(0.0, self.length, BEAM_STEPS + 1)
        self.x, step = 0.5 * (edges[1:] + edges[:-1]), np.diff(edges)
        diameter = np.where(
            self.x < flutes, FLUTES * (tool.diameter + 2.0 * self.x * cone), tool.shank_diameter or tool.diameter
        )
        begin = flutes
        for part in tool.shank:
            inside = (self.x >= begin) & (self.x < begin + part.length)
            share = (self.x[inside] - begin) / part.length
            diameter[inside] = part.lower_diameter + share * (part.upper_diameter - part.lower_diameter)
            begin += part.length
            diameter[self.x >= begin] = part.upper_diameter
        self.holder_diameter = float(diameter[-1])
        modulus = next((value for name, value in MODULI.items() if name in tool.material.lower()), MODULI["carbide"])
        self.flexibility = step / (modulus * math.pi * diameter**4 / 64.0)

    def lines(self, force: Floats) -> Floats:
        """(heights, m) deflection at the tip and at the heights per force at heights (m,) [m/N]."""
        beyond = np.maximum(self.x - force[:, None], 0.0)
        there = np.maximum(self.x - self.at[:, None], 0.0)
        return np.asarray((there * self.flexibility) @ beyond.T)
