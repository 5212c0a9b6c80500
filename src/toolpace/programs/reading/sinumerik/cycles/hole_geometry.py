"""The geometry of hole cycles: strokes and their depths along one hole, and patterns of holes.

The patterns are HOLES1, HOLES2 and CYCLE801. Beside them are the pitch of a thread, and CYCLE90, which mills one.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass

from toolpace.common.units import DEGREE, INCH, MILLIMETRE, MINUTE
from toolpace.programs.reading.arcs import PLANE_AXES, ROUNDING, arc_about, plane_arc
from toolpace.programs.reading.control.control import Control
from toolpace.programs.reading.control.cycles import MOST_PECKS, Place, laid_out, on_circle, on_grid
from toolpace.programs.reading.control.feed import INVERSE
from toolpace.programs.reading.expressions import BlockError
from toolpace.programs.reading.sinumerik.state import State
from toolpace.programs.reading.sinumerik.syntax.values import Unread, Value
from toolpace.programs.reading.sinumerik.word_values import Arguments

TOO_MANY = "CYCLE83 takes more than 10000 strokes, or none: check its depths"
SLACK = 1e-9
"""Share of a stroke that rounding may add to a depth, or take from it."""
COARSE = {
    3: 0.5, 4: 0.7, 5: 0.8, 6: 1.0, 8: 1.25, 10: 1.5, 12: 1.75, 14: 2.0, 16: 2.0, 18: 2.5, 20: 2.5, 22: 2.5, 24: 3.0,
    27: 3.0, 30: 3.5, 33: 3.5, 36: 4.0, 39: 4.0, 42: 4.5, 45: 4.5, 48: 5.0,
}  # fmt: skip
"""Pitch [mm] by nominal diameter [mm]."""
MOST_TURNS = 10_000
"""Turns of a thread that is milled: a bound on what a slip of its pitch may ask for, not a rule of the control."""
MOST = 10_000
"""Holes of a pattern."""
NEARER_END = "HOLES1 begins at the end of its row that is nearer to the tool (Programming Guide Cycles)"


@dataclass(frozen=True)
class Levels:
    """The first five arguments of every cycle of holes: RTP, RFP, SDIS, DP, DPR [m]."""

    back: float
    reference: float
    top: float
    """Reference plane and safety distance: the rapid ends here."""
    bottom: float


class Along:
    """The hole under the tool, with the levels of its cycle."""

    def __init__(self, control: Control, state: State, axis: int, levels: Levels) -> None:
        self.control, self.state, self.axis, self.levels = control, state, axis, levels

    def over(self) -> None:
        """Rapid to the safety distance."""
        self.rapid(self.levels.top)

    def rapid(self, level: float) -> None:
        """Rapid to a level."""
        self.control.straight(self._at(level), 1 << self.axis, rapid=True)

    def feed(self, level: float, speed: float = 0.0) -> None:
        """Go to a level at a speed [m/s]; at the feed of the program where it is zero."""
        if speed == 0.0:
            number = self.state.inverse if self.control.feed.mode == INVERSE else None
            self.control.straight(self._at(level), 1 << self.axis, rapid=False, number=number)
        else:
            with self.control.feed.held(speed):
                self.control.straight(self._at(level), 1 << self.axis, rapid=False)

    def pause(self, seconds: float) -> None:
        """Wait, where there is anything to wait."""
        if seconds:
            self.control.dwell(seconds)

    def _at(self, level: float) -> list[float]:
        words = list(self.control.words)
        words[self.axis] = level
        return words


def strokes_of(whole: float, first: float, less: float) -> list[float]:
    """Depths [m] at which the strokes of CYCLE83 end: each is shorter by `less`, down to that; the last two are equal.

    Where `less` is zero all strokes but the last are as long as the first. The last two are cut alike where what is
    left is no longer than twice `less`: each is then longer than half of it.
    """
    found: list[float] = []
    depth, stroke = 0.0, min(first, whole)
    if stroke <= 0.0 or whole / max(min(stroke, less or stroke), 1e-12) > MOST_PECKS:
        raise BlockError(TOO_MANY)
    while _longer(whole - depth, stroke):
        depth += stroke
        found.append(depth)
        if less:
            stroke = max(stroke - less, less)
            rest = whole - depth
            if _longer(rest, stroke) and not _longer(rest, 2.0 * less):
                stroke = rest / 2.0
    return [*found, whole]


def strokes_by_factor(whole: float, first: float, factor: float, least: float) -> list[float]:
    """Depths [m] at which the strokes of CYCLE83 end where each is `factor` times the last one, but at least `least`.

    Where a stroke would be shorter than `least`, what is left is drilled in strokes of that length.
    """
    found: list[float] = []
    depth, stroke = 0.0, min(first, whole)
    if stroke <= 0.0:
        raise BlockError(TOO_MANY)
    while _longer(whole - depth, stroke):
        depth += stroke
        found.append(depth)
        stroke = max(stroke * factor, min(least, first))
        if len(found) >= MOST_PECKS:
            raise BlockError(f"{TOO_MANY}, or write the least stroke, its argument 14 (_MDEP)")
    return [*found, whole]


def _longer(length: float, other: float) -> bool:
    """Whether a length is longer than another one, rounding aside."""
    return length > other * (1.0 + SLACK)


def stop_distance(whole: float) -> float:
    """How far above the last depth the rapid ends: 0.6 mm to 30 mm of depth, then a fiftieth, at most 7 mm."""
    return 0.6 * MILLIMETRE if whole <= 30.0 * MILLIMETRE else min(whole / 50.0, 7.0 * MILLIMETRE)


def metric_pitch(size: float) -> float:
    """Pitch [m] of the thread M`size`. Raises BlockError."""
    if size not in COARSE:
        raise BlockError(f"M{size:g} is no metric size from M3 to M48: write the pitch PIT in place of MPIT")
    return COARSE[int(size)] * MILLIMETRE


def pitch_of(arguments: Arguments, unit: float, *, size: int, pitch: int, kind: int) -> float:
    """Lead of a thread [m], from the places of its metric size, of the pitch itself, and of what that is told in.

    unit: of lengths [m]. Raises BlockError, Unread.
    """
    by_size = abs(arguments.number(size))
    if not arguments.number(pitch):
        if by_size:
            return metric_pitch(by_size)
        raise BlockError(
            f"{arguments.name} lacks the pitch of its thread: write MPIT or PIT, argument {size + 1} or {pitch + 1}"
        )
    unit_code = arguments.code(kind)
    if unit_code not in (0, 1, 3):
        raise Unread(f"{arguments.name} with a pitch in modules or turns per inch", "write it in mm or inch")
    lead = abs(arguments.number(pitch)) * {0: unit, 1: MILLIMETRE, 3: INCH}[unit_code]
    if by_size and abs(metric_pitch(by_size) - lead) > ROUNDING:
        raise BlockError(f"{arguments.name}: MPIT and PIT tell different pitches (alarm 61001): write one of them")
    return lead


def mill_thread(values: list[Value | None], control: Control, state: State, tool_radius: float | None) -> None:
    """CYCLE90(RTP,RFP,SDIS,DP,DPR,DIATH,KDIAM,PIT,FFR,CDIR,TYPTH,CPA,CPO): over the centre at rapid, down to the
    safety distance, along a circle to the thread, along the helix, along a circle back to the centre, out.

    tool_radius [m]; None or zero: unknown.
    """
    arguments, unit = Arguments("CYCLE90", values, 20), state.unit
    if not tool_radius:
        raise Unread("CYCLE90", "it needs the radius of the tool: put it on the set-up sheet (--setup FILE)")
    if arguments.code(10):
        raise Unread("CYCLE90 on an outer thread (TYPTH=1)", "its approach is not read: let the CAM write it out")
    clockwise = {2: True, 3: False}.get(arguments.code(9))
    pitch, speed = abs(arguments.number(7)) * unit, arguments.number(8) * unit / MINUTE
    radius = arguments.number(5) * unit / 2.0 - tool_radius
    if clockwise is None or pitch <= 0.0 or speed <= 0.0 or radius <= 0.01 * MILLIMETRE:
        raise BlockError("CYCLE90 needs DIATH (above the tool), PIT and FFR above zero, and CDIR 2 or 3: correct them")
    reference = arguments.number(1) * unit
    depth = abs(arguments.number(4)) * unit
    bottom = reference - depth if depth else arguments.number(3) * unit
    top = reference + abs(arguments.number(2)) * unit
    back = max(arguments.number(0) * unit, top)
    if arguments.number(0) * unit < reference:
        control.findings.assumed("where RTP lies below RFP, CYCLE90 goes back to RFP + SDIS (alarm 61101: raise RTP)")
    if bottom >= reference or (top - bottom) / pitch > MOST_TURNS:
        raise BlockError(f"CYCLE90 needs a depth below its reference plane, at most {MOST_TURNS} turns: correct DP")
    if not len(control.moves):
        control.begin_here()
    control.findings.assumed("CYCLE90 comes to the thread and leaves it on half circles from and to its centre")
    plane = state.plane
    first, second, up = ((0, 1, 2), (2, 0, 1), (1, 2, 0))[plane]

    def at(a: float, b: float, height: float) -> list[float]:
        words = list(control.words)
        words[first], words[second], words[up] = a, b, height
        return words

    centre = at(arguments.number(11) * unit, arguments.number(12) * unit, top)
    a, b = centre[first], centre[second]
    control.straight(at(a, b, control.words[up]), 7, rapid=True)
    if control.words[up] < back:
        control.straight(at(a, b, back), 7, rapid=True)
    control.straight(centre, 7, rapid=True)
    thread = at(a + radius, b, top)
    turn = 2.0 * math.pi * (top - bottom) / pitch
    angle = -turn if clockwise else turn
    end = at(a + radius * math.cos(angle), b + radius * math.sin(angle), bottom)
    normal = [0.0, 0.0, 0.0]
    normal[up] = -1.0 if clockwise else 1.0
    with control.feed.held(speed):
        control.arc(thread, 7, plane_arc(centre, thread, _middle(centre, thread), plane, clockwise))
        helix = arc_about(thread, end, centre, normal)
        control.arc(end, 7, helix._replace(sweep=turn))
        middle = at(a, b, bottom)
        control.arc(middle, 7, plane_arc(end, middle, _middle(end, middle), plane, clockwise))
    control.straight(at(a, b, back), 7, rapid=True)


def _middle(a: list[float], b: list[float]) -> list[float]:
    return [(x + y) / 2.0 for x, y in zip(a[:3], b[:3])]


def places(name: str, values: list[Value | None], control: Control, state: State) -> Iterator[list[float]]:
    """Words (3 + rotary) of the holes of a pattern, in their order; each as high as the one before was left."""
    arguments = Arguments(name, values, 16)
    first, second = PLANE_AXES[state.plane]
    here = control.words[first] / state.unit, control.words[second] / state.unit
    if name == "HOLES1":
        points = _row(arguments)
        if math.dist(here, points[-1]) < math.dist(here, points[0]):
            control.findings.assumed(NEARER_END)
            points.reverse()
    elif name == "HOLES2":
        points = _circle(arguments)
        if arguments.number(6):
            control.findings.assumed("HOLES2 goes straight from hole to hole, whatever its argument 7 says")
    else:
        points = _grid(arguments, here)
    for a, b in points:
        words = list(control.words)
        words[first], words[second] = a * state.unit, b * state.unit
        yield words


def _count(arguments: Arguments, place: int) -> int:
    count = arguments.code(place)
    if not 1 <= count <= MOST:
        raise BlockError(f"{arguments.name} needs the number of its holes, from 1 to {MOST}, as argument {place + 1}")
    return count


def _row(arguments: Arguments) -> list[Place]:
    """SPCA, SPCO, STA1, FDIS, DBH, NUM: reference, angle, distance of the first, of the others, number."""
    a, b = arguments.number(0), arguments.number(1)
    angle, first, step = arguments.number(2) * DEGREE, arguments.number(3), arguments.number(4)
    along = [first + step * k for k in range(_count(arguments, 5))]
    return [(a + d * math.cos(angle), b + d * math.sin(angle)) for d in along]


def _circle(arguments: Arguments) -> list[Place]:
    """CPA, CPO, RAD, STA1, INDA, NUM: centre, radius, first angle, step (0: evenly round), number."""
    a, b, radius = arguments.number(0), arguments.number(1), arguments.number(2)
    count = _count(arguments, 5)
    step = (arguments.number(4) or 360.0 / count) * DEGREE
    start = arguments.number(3) * DEGREE
    angles = [start + step * k for k in range(count)]
    return on_circle(a, b, radius, angles)


def _grid(arguments: Arguments, here: Place) -> list[Place]:
    """SPCA, SPCO, STA, DIS1, DIS2, NUM1, NUM2: reference, angle, distances and numbers of columns and rows.

    As Siemens' own cycle: from the corner that is nearer to the tool `here`, along the shorter distance first, there
    and back. Frames and gaps are refused.
    """
    columns, rows = _count(arguments, 5), _count(arguments, 6)
    if columns * rows > MOST:
        raise BlockError(f"CYCLE801 makes {columns * rows} holes, and at most {MOST} are read: correct the numbers")
    if any(arguments.number(place) for place in (7, 9, 10)) or arguments.text(11):
        raise Unread("CYCLE801 with _VARI, _ANG1, _ANG2 or _HIDE", "write the places as blocks of their own")
    angle = arguments.number(2) * DEGREE
    c, s = math.cos(angle), math.sin(angle)
    a, b = arguments.number(0), arguments.number(1)
    u, v = here[0] - a, here[1] - b
    along = _nearer_first(columns, abs(arguments.number(3)), u * c + v * s)
    across = _nearer_first(rows, abs(arguments.number(4)), v * c - u * s)
    if abs(arguments.number(3)) <= abs(arguments.number(4)):
        found = on_grid(along, across)
    else:
        found = [(x, y) for y, x in on_grid(across, along)]
    return laid_out(found, a, b, angle)


def _nearer_first(count: int, step: float, here: float) -> list[float]:
    """Multiples of a step, from the end that is nearer."""
    found = [step * k for k in range(count)]
    return found if here <= found[-1] / 2.0 else found[::-1]
