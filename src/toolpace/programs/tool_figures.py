"""The figures of a cutting tool's shape: cutting part, shank and holder, as a set-up sheet or a program tells them."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass, field
from typing import Literal, get_args

from toolpace.common.errors import UsageError
from toolpace.common.units import DEGREE, LONGEST_TOOL, WIDEST_TOOL
from toolpace.programs.spindle_figures import SpeedCurve

ToolKind = Literal["flat", "bull", "ball", "taper", "barrel", "lens", "drill", "chamfer", "face"]
KINDS: tuple[ToolKind, ...] = get_args(ToolKind)
MOST_TEETH = 100
"""Of a cutter: more is a slip."""
MOST_RUNOUT = 0.1
"""Over the diameter: more is a slip."""
ROUNDING = 1e-6
"""By how much of itself a figure may differ from one that it has to equal."""
MOST_CUTTING_SPEED = 200.0
"""[m/s]: more is a slip of the unit."""
PITCH_ROUNDING = 0.1 * DEGREE
"""By how much the sum of the pitches may differ from a full turn [rad]: people write them with two decimals."""


@dataclass(frozen=True)
class Frustum:
    """A piece of a shank or a holder: a cone, or a cylinder where both diameters are the same."""

    length: float
    """Along the axis [m]."""
    lower_diameter: float
    """At the end towards the tip [m]."""
    upper_diameter: float
    """[m]"""


@dataclass(frozen=True)
class ToolFigures:
    """A solid of revolution about the tool axis, from the tip upwards; what is not known is None.

    Raises UsageError, with the cure, where figures contradict each other.
    """

    kind: ToolKind
    diameter: float
    """Of the cutting part where it is widest; of `taper` and `chamfer` at the lower end of the cone where `taper` is
    above zero [m]."""
    corner_radius: float = 0.0
    """Of `bull` and `face`; of the tip of `barrel` and `taper`; of `lens` between end and side; of `ball` half of the
    diameter, given or not [m]."""
    taper: float = 0.0
    """Angle between the cone's side and the axis [rad], of `taper`, `chamfer` and tapered balls."""
    point_angle: float = 0.0
    """Full angle of the point of `drill` and `chamfer` [rad]; 0: none, the tip is flat."""
    barrel_radius: float = math.inf
    """Of the arc of the side of `barrel`, or of the end of `lens`, which is about the axis [m]."""
    flute_length: float | None = None
    """How far from the tip the edge reaches [m]; None: to the end of what sticks out."""
    teeth: int | None = None
    pitch: tuple[float, ...] = ()
    """Angles between the teeth [rad], their sum a full turn; empty where they are even."""
    helix: float = 0.0
    """[rad]; above zero where the tool is right-handed."""
    runout: float = 0.0
    """How far the tool's axis is from the spindle's [m]: half of what a dial gauge shows."""
    stick_out: float | None = None
    """From the holder to the tip [m]; None: no holder is known."""
    shank_diameter: float | None = None
    """Above the flutes [m]; None: as the cutting part's."""
    shank: tuple[Frustum, ...] = ()
    """From the end of the flutes upwards, where one diameter does not tell it; the last goes on to the holder."""
    holder: tuple[Frustum, ...] = ()
    """From the end of the stick-out upwards."""
    material: str = ""
    """Of the tool (carbide, HSS)."""
    spindle_speed: float | None = None
    """Turns per second [1/s], where the sheet tells it in place of the program."""
    clockwise: bool = True
    """Seen from the spindle, as M3 turns it."""
    spindle_range: tuple[float, float] | None = None
    """Least and most turns per second that may be chosen for it [1/s]; None: the program's speed stays."""
    cutting_speed: float | None = None
    """Most speed of its edge in what is cut [m/s]."""
    stability: SpeedCurve | None = None
    """Depth along the axis [m] above which it chatters, over spindle speed: a chart that was measured or computed."""
    source: str = field(default="", compare=False)
    """Where the figures are from: the sheet and its table, or the line of the program."""
    assumed: tuple[str, ...] = field(default=(), compare=False)
    """Figures that stand in for what nobody told, a sentence each."""

    def __post_init__(self) -> None:
        if self.kind == "ball":
            half = 0.5 * self.diameter
            if self.corner_radius == 0.0 or abs(self.corner_radius - half) <= ROUNDING * half:
                object.__setattr__(self, "corner_radius", half)
        turn = sum(self.pitch)
        if self.pitch and 1e-9 < abs(turn - math.tau) <= PITCH_ROUNDING:
            object.__setattr__(self, "pitch", tuple(each * math.tau / turn for each in self.pitch))
        if self.pitch and self.teeth is None:
            object.__setattr__(self, "teeth", len(self.pitch))
        for reason in (*_out_of_range(self), *_contradictions(self)):
            raise UsageError(f"{self.source or 'tool'}: {reason}")


def _mm(length: float) -> str:
    return f"{length * 1e3:.6g} mm"


def _out_of_range(tool: ToolFigures) -> Iterator[str]:
    """What no tool has, each with its cure."""
    if tool.kind not in KINDS:
        yield f"kind = {tool.kind!r:.40} is not known; write one of {', '.join(KINDS)}"
    lengths: dict[str, tuple[float | None, float, bool]] = {
        "diameter": (tool.diameter, WIDEST_TOOL, True),
        "flute_length": (tool.flute_length, LONGEST_TOOL, True),
        "stick_out": (tool.stick_out, LONGEST_TOOL, True),
        "shank_diameter": (tool.shank_diameter, WIDEST_TOOL, True),
        "corner_radius": (tool.corner_radius, WIDEST_TOOL, False),
        "runout": (tool.runout, MOST_RUNOUT * tool.diameter, False),
    }
    for name, pieces in (("shank", tool.shank), ("holder", tool.holder)):
        for number, piece in enumerate(pieces, start=1):
            lengths[f"length of piece {number} of {name}"] = (piece.length, LONGEST_TOOL, True)
            lengths[f"lower diameter of piece {number} of {name}"] = (piece.lower_diameter, WIDEST_TOOL, False)
            lengths[f"upper diameter of piece {number} of {name}"] = (piece.upper_diameter, WIDEST_TOOL, False)
    for name, (value, most, positive) in lengths.items():
        if value is not None and not (0.0 < value <= most or (value == 0.0 and not positive)):
            least = "above 0" if positive else "from 0 on"
            yield f"{name} is {_mm(value)}, and must be {least} and at most {_mm(most)}: check its unit"
    quarter = 0.5 * math.pi
    for name, angle, low, high in (
        ("taper", tool.taper, 0.0, quarter),
        ("helix", tool.helix, -quarter, quarter),
        ("point_angle", tool.point_angle, 0.0, math.pi),
    ):
        if not (low <= angle <= high and abs(angle) != quarter) and not (name == "point_angle" and angle == quarter):
            yield (
                f"{name} is {math.degrees(angle):.6g} deg, and must be between {low / DEGREE:g} and "
                f"{high / DEGREE:g} deg: correct it"
            )
    if tool.teeth is not None and not 1 <= tool.teeth <= MOST_TEETH:
        yield f"teeth = {tool.teeth}: write how many, from 1 to {MOST_TEETH}"
    if tool.spindle_speed is not None and not 0.0 < tool.spindle_speed < math.inf:
        yield f"spindle_speed is {tool.spindle_speed * 60.0:g} rpm: give one above zero"
    if tool.spindle_range is not None and not 0.0 < tool.spindle_range[0] <= tool.spindle_range[1] < math.inf:
        low, high = (60.0 * each for each in tool.spindle_range)
        yield f"spindle_range is {low:g} to {high:g} rpm: give the least speed first, both above zero"
    if tool.cutting_speed is not None and not 0.0 < tool.cutting_speed <= MOST_CUTTING_SPEED:
        most = MOST_CUTTING_SPEED * 60.0
        yield f"cutting_speed is {tool.cutting_speed * 60.0:g} m/min: give one above zero, and at most {most:g} m/min"


def _contradictions(tool: ToolFigures) -> Iterator[str]:
    """What cannot be true at once, each with its cure."""
    yield from _of_the_cutting_part(tool)
    yield from _of_the_teeth(tool)
    if tool.stick_out is not None and tool.flute_length is not None and tool.flute_length > tool.stick_out:
        yield (
            f"flute_length of {_mm(tool.flute_length)} is more than the stick_out of {_mm(tool.stick_out)}: "
            "measure both from the tip, and correct one"
        )
    if tool.shank and tool.shank_diameter is not None:
        yield "shank and shank_diameter both tell what is above the flutes: keep one"
    if tool.shank and tool.flute_length is None:
        yield "shank begins where the flutes end: give flute_length"
    if tool.shank and tool.flute_length is not None and tool.stick_out is not None:
        long, room = sum(piece.length for piece in tool.shank), tool.stick_out - tool.flute_length
        if long > room + ROUNDING * tool.stick_out:
            yield (
                f"shank is {_mm(long)} long, and only {_mm(room)} are between flutes and holder: correct it, or "
                "flute_length, or stick_out"
            )
    if tool.holder and tool.stick_out is None:
        yield "holder begins where the tool stops sticking out: give stick_out"
    thick = tool.shank[-1].upper_diameter if tool.shank else tool.shank_diameter
    if thick is not None and tool.holder and thick > tool.holder[0].lower_diameter * (1.0 + ROUNDING):
        yield (
            f"a shank of {_mm(thick)} does not go into a holder that begins with {_mm(tool.holder[0].lower_diameter)}: "
            "correct one"
        )


def _of_the_cutting_part(tool: ToolFigures) -> Iterator[str]:
    kind, half, corner = tool.kind, 0.5 * tool.diameter, tool.corner_radius
    if corner > half * (1.0 + ROUNDING):
        yield (
            f"corner_radius of {_mm(corner)} is more than half of the diameter of {_mm(tool.diameter)}: correct one "
            "(was the radius meant as the diameter?)"
        )
    if kind == "ball" and abs(corner - half) > ROUNDING * half:
        yield (
            f"corner_radius of {_mm(corner)} is not that of a ball of {_mm(tool.diameter)}, which is {_mm(half)}: "
            'remove it, or write kind = "bull"'
        )
    if kind == "bull" and corner == 0.0:
        yield 'a bull-nose mill has a corner radius: give corner_radius, or write kind = "flat"'
    if kind in ("flat", "drill", "chamfer") and corner > 0.0:
        yield f'corner_radius of {_mm(corner)} on kind = "{kind}": remove it, or write kind = "bull"'
    if tool.taper > 0.0 and kind not in ("taper", "chamfer", "ball"):
        yield f'taper on kind = "{kind}": remove it, or write kind = "taper"'
    if kind == "taper" and tool.taper == 0.0:
        yield 'a tapered mill has an angle between its side and its axis: give taper, or write kind = "flat"'
    if tool.point_angle > 0.0 and kind not in ("drill", "chamfer"):
        yield f'point_angle on kind = "{kind}": remove it, or write kind = "drill" or "chamfer"'
    if kind == "chamfer" and (tool.taper > 0.0) == (tool.point_angle > 0.0):
        yield (
            "a chamfer mill has one of point_angle (full angle of its point; diameter is the widest) and taper (angle "
            "between its side and its axis; diameter is that of its flat end): give one of both"
        )
    if math.isfinite(tool.barrel_radius) != (kind in ("barrel", "lens")):
        part = {"barrel": "the side of a barrel mill", "lens": "the end of a lens mill"}.get(kind)
        yield (
            f'{part} is an arc: give barrel_radius, or write kind = "flat"'
            if part is not None
            else f'barrel_radius on kind = "{kind}": remove it, or write kind = "barrel" or "lens"'
        )
    elif kind in ("barrel", "lens") and tool.barrel_radius < half:
        yield (
            f"barrel_radius of {_mm(tool.barrel_radius)} is less than half of the diameter of {_mm(tool.diameter)}: "
            "correct one"
        )


def _of_the_teeth(tool: ToolFigures) -> Iterator[str]:
    if not tool.pitch:
        return
    if len(tool.pitch) != tool.teeth:
        yield f"pitch has {len(tool.pitch)} angles, and teeth = {tool.teeth}: give one angle a tooth, or none"
    if min(tool.pitch) <= 0.0 or not abs(sum(tool.pitch) - math.tau) <= PITCH_ROUNDING:
        yield (
            f"the angles of pitch come to {math.degrees(sum(tool.pitch)):.6g} deg: give one above zero for each tooth, "
            "360 in all"
        )
