"""What a cutter takes over a turn in a section of the material: it is turned through, tooth by tooth, in time.

Each piece of each tooth cuts, while it is in an arc of its slice, as thick a chip as the surface has moved outwards
since the teeth before it passed (Kline and DeVor 1983, with runout and uneven pitch). Forces are linear in the chip
(Altintas, Manufacturing Automation, 2012). The tool bends as a cantilever, whose lines are summed here in steps.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from toolpace.common.arrays import Floats
from toolpace.judge.cut.sections import Section, Shape, across
from toolpace.machine.cutting_tool import Coefficients
from toolpace.programs.tool_figures import ToolFigures

STEPS = 720
"""Of a turn."""
LAG = math.radians(0.5)
"""Most lag of the helix over a piece of the edge [rad]."""
NEAR_SURFACE = math.radians(4.0)
"""How near its end in an arc is to where the chip is nothing, for the edge to leave a surface there [rad]."""
FLUTES = 0.8
"""Diameter of the bar that bends as flutes do, over theirs (Kops and Vo 1990)."""
MODULI = {"carbide": 580e9, "hss": 207e9, "steel": 207e9, "ceramic": 310e9, "cermet": 450e9}
"""Young's modulus of the material of a tool [Pa]."""
BEAM_STEPS = 2000


@dataclass(frozen=True)
class Cutting:
    """A tool at work."""

    tool: ToolFigures
    shape: Shape
    coefficients: Coefficients | None
    """None: forces are not asked for."""
    turns: float
    """Per second [1/s]."""


def loads_of(section: Section, cutting: Cutting, velocity: Floats, axis: Floats, turning: Floats) -> dict[str, float]:
    """The largest loads over a turn, in SI, by the names of limits; what nothing tells is left out.

    velocity (3,) of the tip [m/s], turning (3,) the angular velocity of the axis [rad/s].
    """
    tool, shape = cutting.tool, cutting.shape
    teeth = tool.teeth or 1
    speed = float(np.linalg.norm(velocity))
    per_tooth = speed / (teeth * cutting.turns)
    radius = tool.corner_radius or 0.5 * tool.diameter
    engaged = bool(section.arcs)
    found = {
        "feed_per_tooth": per_tooth if engaged else 0.0,
        "feed_marks": (per_tooth * teeth) ** 2 / (8.0 * radius) if engaged else 0.0,
    }
    edge = _Edge(section, tool, shape, velocity, axis, turning)
    found["chip"], found["removal_rate"] = edge.chip / (teeth * cutting.turns), edge.rate
    if not engaged:
        return found
    beam = None if tool.stick_out is None else _Beam(tool, edge.height)
    turned = edge.turned(cutting, beam)
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


@dataclass(frozen=True)
class _Turned:
    force: Floats
    """(steps, 3) along feed, left and axis [N]."""
    torque: Floats
    """(steps,) [N m]"""
    moment: Floats
    """(steps, 2) at the holder, by forces along feed and left [N m]."""
    area: Floats
    """(steps,) of the chips of all teeth [m2]."""
    edge: Floats
    """(steps,) in material, as width of the chips [m]."""
    bent: Floats
    """(steps, heights, 2) along feed and left [m]; of the tip first, then of the slices."""


class _Edge:
    """One edge of the tool in pieces that are in material at some angle."""

    def __init__(
        self, section: Section, tool: ToolFigures, shape: Shape, velocity: Floats, axis: Floats, turning: Floats
    ) -> None:
        self.section, self.tool, self.shape = section, tool, shape
        self.slope = 2.0 * math.tan(tool.helix) / tool.diameter
        self.height = section.height
        self.feed, self.side = across(velocity, axis)
        self.velocity, self.axis, self.turning = velocity, axis, turning
        self.chip, self.rate = self._thickest()

    def outwards(self, height: Floats, angle: Floats) -> Floats:
        """(n,) how fast the surface moves outwards at heights and angles (n,) [m/s]."""
        sine, cosine = self.shape.normal(height)
        direction = np.cos(angle)[:, None] * self.side + np.sin(angle)[:, None] * self.feed
        arm = height[:, None] * self.axis + self.shape.radius(height)[:, None] * direction
        moves = self.velocity + np.cross(self.turning, arm)
        normal = sine[:, None] * direction + cosine[:, None] * self.axis
        return np.asarray(np.einsum("nc,nc->n", moves, normal))

    def _thickest(self) -> tuple[float, float]:
        """The fastest that the surface moves outwards in material [m/s], and the volume that it takes [m3/s]."""
        most = rate = 0.0
        for j, entry, leave in self.section.arcs:
            angle = np.linspace(entry, leave, 200)
            height = np.full(200, self.height[j])
            moves = np.maximum(self.outwards(height, angle), 0.0)
            most = max(most, float(moves.max()))
            sine, _ = self.shape.normal(height[:1])
            area = self.section.slice_height / float(sine[0]) * float(self.shape.radius(height[:1])[0])
            rate += area * float(np.trapezoid(moves, angle))
        return most, rate

    def turned(self, cutting: Cutting, beam: _Beam | None) -> _Turned:
        """All over a turn."""
        tool, k = self.tool, cutting.coefficients or Coefficients(0.0, 0.0)
        teeth, sense = tool.teeth or 1, 1.0 if tool.clockwise else -1.0
        pitch = np.array(tool.pitch) if tool.pitch else np.full(teeth, 2.0 * math.pi / teeth)
        offset = sense * np.concatenate([[0.0], np.cumsum(pitch)[:-1]])
        theta = sense * 2.0 * math.pi * np.arange(STEPS) / STEPS
        force, torque = np.zeros((STEPS, 3)), np.zeros(STEPS)
        area, edge = np.zeros(STEPS), np.zeros(STEPS)
        moment = np.zeros((STEPS, 2))
        bent = np.zeros((STEPS, 1 + len(self.height), 2))
        high = self.section.slice_height
        pieces = max(math.ceil(abs(self.slope) * high / LAG), 8)
        for j, entry, leave in self.section.arcs:
            rim = self.height[j] - 0.5 * high + high * np.arange(pieces + 1) / pieces
            middle, r = 0.5 * (rim[1:] + rim[:-1]), self.shape.radius(0.5 * (rim[1:] + rim[:-1]))
            sine, cosine = self.shape.normal(middle)
            length = np.diff(rim) / sine
            for tooth in range(teeth):
                phi = theta[:, None] + offset[tooth] - self.slope * middle
                at, piece = np.nonzero((phi - entry) % (2.0 * math.pi) < leave - entry)
                phi = phi[at, piece]
                chip = self._chip(middle[piece], phi, sine[piece], tooth, pitch, offset, cutting)
                cut = chip > 0.0
                at, piece, phi, h = at[cut], piece[cut], phi[cut], chip[cut]
                b, s, c = length[piece], sine[piece], cosine[piece]
                tangential = (k.tangential * h + k.tangential_edge) * b
                radial, axial = (k.radial * h + k.radial_edge) * b, (k.axial * h + k.axial_edge) * b
                # the radial force pushes the edge away from material, the axial one up along the meridian
                inwards = radial * s - axial * c
                parts = (
                    -inwards * np.sin(phi) - sense * tangential * np.cos(phi),
                    -inwards * np.cos(phi) + sense * tangential * np.sin(phi),
                    -radial * c - axial * s,
                )
                for column, part in enumerate(parts):
                    force[:, column] += np.bincount(at, part, minlength=STEPS)
                torque += np.bincount(at, tangential * r[piece], minlength=STEPS)
                area += np.bincount(at, h * b, minlength=STEPS)
                edge += np.bincount(at, b, minlength=STEPS)
                if beam is not None:
                    arm = beam.length - middle[piece]
                    lines = beam.lines(middle)[:, piece]
                    for column in range(2):
                        moment[:, column] += np.bincount(at, parts[column] * arm, minlength=STEPS)
                        for w in range(len(lines)):
                            bent[:, w, column] += np.bincount(at, parts[column] * lines[w], minlength=STEPS)
        return _Turned(force, torque, moment, area, edge, bent)

    def _chip(
        self, height: Floats, phi: Floats, sine: Floats, tooth: int, pitch: Floats, offset: Floats, cutting: Cutting
    ) -> Floats:
        """(n,) thickness of the chip of a tooth [m]: what the surface gained since each of the others passed."""
        outwards = self.outwards(height, phi)
        count, runout = len(pitch), self.tool.runout
        lag = self.slope * height
        own = runout * np.cos(-offset[tooth] + lag)
        chip, gone = np.full(len(phi), np.inf), 0.0
        for m in range(1, count + 1):
            gone += float(pitch[(tooth + m - 1) % count]) / (2.0 * math.pi * cutting.turns)
            other = runout * np.cos(-offset[(tooth + m) % count] + lag)
            chip = np.minimum(chip, outwards * gone + (own - other) * sine)
            if runout == 0.0:
                break
        return chip

    def left(self, turned: _Turned) -> Floats:
        """(k,) what deflection leaves on the surface at the places where the edge makes it, above zero too much [m]."""
        tool, found = self.tool, []
        teeth, sense = tool.teeth or 1, 1.0 if tool.clockwise else -1.0
        pitch = np.array(tool.pitch) if tool.pitch else np.full(teeth, 2.0 * math.pi / teeth)
        offset = sense * np.concatenate([[0.0], np.cumsum(pitch)[:-1]])
        for j, entry, leave in self.section.arcs:
            height = float(self.height[j])
            sine, _ = self.shape.normal(self.height[j : j + 1])
            for end in (entry, leave):
                place = self._without_chip(height, end)
                if place is None or abs(place - end) > NEAR_SURFACE:
                    continue
                angle = min(max(place, entry), leave)
                off = []
                for tooth in range(teeth):
                    # the step at which the edge of this height is there
                    at = sense * (angle + self.slope * height - offset[tooth]) / (2.0 * math.pi) * STEPS
                    below = math.floor(at)
                    share = at - below
                    bent = (1.0 - share) * turned.bent[below % STEPS, 1 + j] + share * turned.bent[
                        (below + 1) % STEPS, 1 + j
                    ]
                    off.append(-float(sine[0]) * (bent[0] * math.sin(angle) + bent[1] * math.cos(angle)))
                # of several teeth the one that reaches furthest leaves it
                found.append(min(off))
        return np.array(found)

    def _without_chip(self, height: float, end: float) -> float | None:
        """The angle nearest to an end at which the surface does not move outwards; None where there is none near."""
        angle = end + np.linspace(-2.0 * NEAR_SURFACE, 2.0 * NEAR_SURFACE, 81)
        moves = self.outwards(np.full(81, height), angle)
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
