"""PLANE and cycle 19: tilted planes, and the motion of the rotary axes to them."""

from __future__ import annotations

import math
import re
from dataclasses import dataclass, field

from toolpace.common.units import DEGREE
from toolpace.programs.reading.arcs import ROUNDING
from toolpace.programs.reading.control.control import Control
from toolpace.programs.reading.control.machine_moves import plane_axis, turn_about, turn_joints
from toolpace.programs.reading.coordinates import affine
from toolpace.programs.reading.coordinates.affine import Matrix
from toolpace.programs.reading.heidenhain.axial import HEAD, AxialAngles
from toolpace.programs.reading.heidenhain.contour.motion import Step
from toolpace.programs.reading.heidenhain.frames import Frames, euler, spatial
from toolpace.programs.reading.heidenhain.klartext.expressions import Value, evaluate
from toolpace.programs.reading.heidenhain.klartext.parameters import BlockError, Parameters
from toolpace.programs.reading.heidenhain.klartext.words import VALUE, signed
from toolpace.programs.reading.heidenhain.machine import MachineFunctions

_WORD = re.compile(
    r"\s*(?:(TURN|MOVE|STAY|F\s*MAX|F\s*AUTO|MAX|SEQ\s*[-+]|SYM\s*[-+]|COORD\s+ROT|TABLE\s+ROT|ROT(?=\s+F)|MB(?=\s+MAX))"
    r"|(SP[ABC]|EULPR|EULNU|EULROT|PROPR|PROMIN|(?:PRO)?ROT|P[123][XYZ]|[BN][XYZ]|DIST|ABST|MB|I?[ABC]|F)\s*("
    + VALUE
    + "))"
)
FORMS = ("SPATIAL", "EULER", "VECTOR", "POINTS", "RELATIV", "AXIAL", "RESET")
PROJECTED = (
    "in which sense its angles count is told by a picture of the manual only: write the plane as PLANE VECTOR or "
    "PLANE SPATIAL"
)
ANGLES = ("A", "B", "C")
MOST_ANGLE = 360.0
"""Of a tilt or a rotation [deg] (TNC 640, "Input format and unit of TNC functions")."""


@dataclass
class PlaneBlock:
    """The words of a PLANE block."""

    values: dict[str, Value] = field(default_factory=dict)
    words: set[str] = field(default_factory=set)

    def value(self, name: str, default: float | None = None) -> float:
        """A figure. Raises BlockError where it is missing."""
        found = self.values.get(name, default)
        if found is None:
            raise BlockError(f"PLANE lacks {name}: write all of its values")
        return evaluate(found)

    def angles(self, *names: str, default: float | None = None) -> list[float]:
        """Angles [rad]. Raises BlockError where one is missing or more than a turn."""
        found = [self.value(name, default) for name in names]
        if max(map(abs, found)) > MOST_ANGLE:
            raise BlockError(f"{', '.join(names)} of PLANE are angles between -360 and 360: correct them")
        return [angle * DEGREE for angle in found]

    def vector(self, name: str) -> list[float]:
        """Components X, Y, Z (3,)."""
        return [self.value(name + letter) for letter in "XYZ"]


class Tilting:
    """Compiles PLANE and hands the plane to the frames."""

    def __init__(self, control: Control, frames: Frames, machine: MachineFunctions, parameters: Parameters) -> None:
        self.control, self.frames, self.machine, self.parameters = control, frames, machine, parameters
        self.axes = AxialAngles(control)
        self.positions: list[float] | None = None
        """Rotary words that the plane in force was told by [rad]; None where it was told otherwise."""
        self.of_cycle_19: dict[str, float] | None = {}
        """Angles of cycle 19 in force [deg], those of value zero may be missing; None where PLANE tilted since."""

    def compile(self, text: str) -> Step:
        """PLANE and what stands behind it. Raises BlockError."""
        form, _, rest = text.partition(" ")
        if form not in FORMS:
            cure = PROJECTED if form == "PROJECTED" else "write PLANE SPATIAL with its angles"
            return lambda: self.control.refuse(f"PLANE {form}", cure)
        block = self.words(rest)
        if form != "RESET" and not block.words & {"MOVE", "TURN", "STAY"}:
            raise BlockError(f"PLANE {form} does not say how the axes turn: write MOVE, TURN or STAY")
        return lambda: self.run(form, block)

    def words(self, text: str) -> PlaneBlock:
        """Read the words. Raises BlockError."""
        block, at = PlaneBlock(), 0
        while text[at:].strip():
            match = _WORD.match(text, at)
            if match is None:
                raise BlockError(f"'{text[at:].strip()[:20]}' is not read in PLANE: check its spelling")
            at = match.end()
            if match[1]:
                block.words.add("".join(match[1].split()))
            else:
                block.values[match[2]] = signed(match[3], self.parameters)
        return block

    def run(self, form: str, block: PlaneBlock) -> None:
        """Tilt, and turn the rotary axes as asked."""
        self.positions = None
        self.of_cycle_19 = {} if form == "RESET" else None
        if form == "RESET":
            self.reset(block)
        elif not self.hindered(by_axes=form == "AXIAL"):
            made = self.matrix(form, block)
            if made is None:
                return
            self.frames.tilt(made)
            self.turn(block, reset=False)
        self.machine.motion.seen_upright = None
        self.machine.state.came_from = []
        self.machine.state.spatial_angles = [None] * 3

    def reset(self, block: PlaneBlock) -> None:
        """The axes back to zero, and no plane: MOVE holds the tip on the part, as long as the plane is there."""
        self.axes.reset()
        turned = any(abs(angle) > ROUNDING for angle in self.control.words[3:])
        if "MOVE" in block.words and turned and self.frames.plane is None and self.control.poses.machine is not None:
            self.frames.tilt(affine.rotation(2, 0.0))
        self.turn(block, reset=True)
        self.frames.tilt(None)

    def hindered(self, *, by_axes: bool) -> bool:
        """Note what is in force over which a plane is not laid, if anything is."""
        found = self.frames.hindrance(by_axes=by_axes)
        if found is not None:
            word, cure = found
            self.control.refuse(word, cure)
        return found is not None

    def matrix(self, form: str, block: PlaneBlock) -> Matrix | None:
        """The rotation of a plane in the frame of the datum; None where it is refused."""
        if form == "SPATIAL":
            return spatial(*block.angles("SPA", "SPB", "SPC"))
        if form == "EULER":
            return euler(*block.angles("EULPR", "EULNU", "EULROT"))
        if form == "RELATIV":
            now = affine.IDENTITY if self.frames.plane is None else self.frames.plane
            return affine.product(now, spatial(*block.angles("SPA", "SPB", "SPC", default=0.0)))
        if form == "AXIAL":
            return self.axial(block)
        if form == "VECTOR":
            made = affine.of_axes(block.vector("B"), block.vector("N"))
        else:
            first, second, third = (block.vector(f"P{k}") for k in (1, 2, 3))
            x = [b - a for a, b in zip(first, second)]
            made = affine.of_axes(x, affine.cross(x, [b - a for a, b in zip(first, third)]))
        if made is None:
            raise BlockError(f"PLANE {form}: its vectors are parallel or zero and span no plane")
        return made

    def axial(self, block: PlaneBlock) -> Matrix | None:
        """The plane across the tool at positions of the rotary axes; None where it is refused."""
        angles = {}
        for word in block.values:
            if word.removeprefix("I") in ANGLES:
                angles[word[-1]] = block.value(word) * DEGREE, word.startswith("I")
        self.positions = self.axes.take(angles)
        made = self.axes.plane(self.positions)
        if made is None:
            self.control.refuse("PLANE AXIAL", HEAD)
        return made

    def turn(self, block: PlaneBlock, *, reset: bool) -> None:
        """MOVE, TURN or STAY; the angles go to Q120 to Q122."""
        control = self.control
        words = block.words
        if "MB" in block.values or "MB" in words or "MAX" in words:
            distance = block.value("MB") * self.machine.state.unit if "MB" in block.values else None
            if distance is not None and distance < 0.0:
                raise BlockError("MB of PLANE is the length of the way back, from zero on: correct it")
            self.machine.back(distance, None)
        pivot = block.value("DIST", block.value("ABST", 0.0)) * self.machine.state.unit
        if pivot < 0.0:
            raise BlockError("DIST of PLANE is a distance from zero on: correct it")
        sign = 1 if words & {"SEQ+", "SYM+"} else -1 if words & {"SEQ-", "SYM-"} else 0
        moves = bool(words & {"MOVE", "TURN"})
        if control.poses.machine is None and not moves:
            return
        straight, turned = reset, None
        if "TABLEROT" in words and self.positions is None and upright(plane_axis(control)):
            # the table turns to the angle of the plane, which is told without its axis where it is zero
            turned = self.axes.turning_to(self.frames.plane or affine.IDENTITY)
            if turned is None:
                cure = "no table of the machine turns about the tool: write COORD ROT"
                control.refuse("TABLE ROT of a plane that is not tilted", cure)
        if straight or turned is not None:
            wanted = turned or [0.0] * len(control.poses.rotary)
        elif self.positions is not None:
            wanted = self.positions  # SEQ, TABLE ROT and COORD ROT do nothing with PLANE AXIAL
        else:
            wanted = self.rotary(sign)
        self.note(wanted)
        if not moves:
            return
        if "TURN" in words and self.machine.state.tip_mode:
            cure = "write MOVE, or M129 before: whether the tip stays or the linear axes do is not known here"
            control.refuse("PLANE .. TURN under M128", cure)
            return
        feed = self.feed(block)
        rapid = feed is None
        with control.feed.held(*((1.0, 1.0) if feed is None else self.machine.motion.speed_of(feed))):
            if "MOVE" in words:
                turn_about(control, wanted, pivot, rapid=rapid)
            else:
                turn_joints(control, wanted, rapid=rapid)

    def feed(self, block: PlaneBlock) -> float | None:
        """F of MOVE or TURN; None at rapid. Raises BlockError."""
        if "F" in block.values:
            return block.value("F")
        if "FAUTO" in block.words:
            return self.machine.motion.automatic()
        if "FMAX" not in block.words:
            self.control.findings.assumed("PLANE .. MOVE and TURN without F turn the axes at rapid")
        return None

    def rotary(self, sign: int, *, from_zero: bool = False) -> list[float]:
        """Rotary words [rad] of the plane: the nearer solution, or that with the master axis below or above zero.

        Of two that are as near the one above zero: from A+0 C+0 the manual's table has A+45 C+90, not A-45 C-90
        (TNC 640 Klartext, "Selection of tilting possibilities SEQ +/-"). from_zero: near to the zero of the axes, not
        to where they stand.
        """
        control, axis = self.control, plane_axis(self.control)
        stands = control.placement.place(control.words)[3:]
        start = [0.0] * len(stands) if from_zero else stands
        nearer, fault = control.orientation.rotary(axis, start, sign)
        if fault:
            control.source.fail(fault, control.line)
        above, out_of_travel = control.orientation.rotary(axis, start, 1)
        if not sign and not out_of_travel and math.dist(above, start) < math.dist(nearer, start) + ROUNDING:
            nearer = above
        shift = control.placement.shift or (0.0,) * len(nearer)
        return [a - b for a, b in zip(nearer, shift)]

    def note(self, wanted: list[float]) -> None:
        """Set Q120, Q121, Q122 to the angles [deg] of A, B and C."""
        names = [name.upper() for name in self.control.poses.rotary_names]
        for k, letter in enumerate(ANGLES):
            angle = wanted[names.index(letter)] / DEGREE if letter in names else 0.0
            self.parameters.set(f"Q{120 + k}", angle)

    def cycle_19(self, angles: dict[str, float], *, axial: bool) -> None:
        """CYCL DEF 19: tilt without turning the axes; all angles zero, or none named: not at all.

        An angle that is left out stays as it was ("nonprogrammed rotary axis values are interpreted as unchanged"), and
        of two solutions Q120 to Q122 have the one nearer to the zero of the axes ("the shorter path from the zero
        position of the rotary axes"; iTNC 530 Cycle Programming, "Working plane (cycle 19)").
        """
        self.positions = None
        if angles and self.of_cycle_19 is None and len(angles) < len(ANGLES) and not axial:
            raise BlockError(
                "CYCL DEF 19 behind PLANE leaves an angle out, and what it was is not known here: write A, B and C"
            )
        angles = {**(self.of_cycle_19 or {}), **angles} if angles and not axial else angles
        self.of_cycle_19 = angles
        if not any(angles.values()):
            self.axes.reset()
            self.frames.tilt(None)
        elif self.hindered(by_axes=True):
            return
        elif axial:
            made = self.axial(PlaneBlock(dict(angles)))
            if made is None:
                return
            self.frames.tilt(made)
        else:
            self.frames.tilt(spatial(*(angles.get(letter, 0.0) * DEGREE for letter in ANGLES)))
        self.machine.motion.seen_upright = None
        self.machine.state.came_from = []
        if self.positions is not None:
            self.note(self.positions)
        elif self.control.poses.machine is not None:
            self.note(self.rotary(0, from_zero=True))


def upright(axis: list[float]) -> bool:
    """Whether a direction (3,) is +z."""
    return abs(axis[0]) < ROUNDING and abs(axis[1]) < ROUNDING and axis[2] > 0.0
