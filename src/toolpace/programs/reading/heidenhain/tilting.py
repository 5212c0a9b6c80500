"""PLANE and cycle 19: tilted planes from angles, vectors, points or axis positions, and the turn of the axes to one."""

from __future__ import annotations

import math
import re
from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np

from toolpace.common.arrays import Floats
from toolpace.common.units import DEGREE
from toolpace.programs.reading.arcs import ROUNDING
from toolpace.programs.reading.control.control import Control
from toolpace.programs.reading.control.machine_moves import plane_axis, turn_about, turn_joints
from toolpace.programs.reading.coordinates import affine
from toolpace.programs.reading.coordinates.affine import Matrix
from toolpace.programs.reading.coordinates.kinematics import near
from toolpace.programs.reading.expressions import BlockError
from toolpace.programs.reading.heidenhain.contour.straight_lines import Step
from toolpace.programs.reading.heidenhain.frames import Frames, euler, spatial
from toolpace.programs.reading.heidenhain.machine import MachineFunctions
from toolpace.programs.reading.heidenhain.parameters import Parameters, Value, evaluate
from toolpace.programs.reading.heidenhain.words import VALUE, signed

HEAD = (
    "write PLANE SPATIAL or PLANE VECTOR: where two axes turn the tool, or one that is not across it, axis positions "
    "do not tell in one way how X and Y of the plane are turned"
)
TURNED_HEAD = "PLANE AXIAL: the axis of the head that is tilted turns X, Y and Z of the plane with the tool"
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


class AxialAngles:
    """Positions of the rotary axes that planes by axis angles name.

    "Rotary axis coordinates defined with PLANE AXIAL are modally effective. Successive definitions therefore build on
    each other" (TNC 640 Klartext, "Tilting the working plane through axis angle: PLANE AXIAL").
    """

    def __init__(self, control: Control) -> None:
        self.control = control
        self.named: dict[int, float] = {}
        """By column of the rotary words [rad], since the last PLANE RESET."""

    def reset(self) -> None:
        """Forget them."""
        self.named.clear()

    def take(self, angles: Mapping[str, tuple[float, bool]]) -> list[float]:
        """Rotary words (rotary) [rad] of a block that names angles by letter, each with whether it adds.

        Raises BlockError where an axis that was never named does not stand at zero.
        """
        control = self.control
        if control.poses.machine is None:
            raise BlockError("PLANE AXIAL needs the machine: give --machine NAME (machine= in Python)")
        for letter, (angle, adds) in angles.items():
            column = control.slot(letter) - 3
            self.named[column] = angle + (self.named.get(column, 0.0) if adds else 0.0)
        for column, name in enumerate(control.poses.rotary_names):
            if column not in self.named and abs(control.words[3 + column]) > ROUNDING:
                raise BlockError(
                    f"PLANE AXIAL leaves {name} out, which stands at {math.degrees(control.words[3 + column]):.4g}: "
                    "which angle the control takes is not known here, write all rotary axes"
                )
        return [self.named.get(column, 0.0) for column in range(len(control.poses.rotary))]

    def plane(self, words: list[float]) -> Matrix | None:
        """The plane across the tool at rotary words [rad], turned as the table or one tilted axis of the head turns it;
        None where two axes of a head make it, or one that is not across the tool."""
        poses, shift = self.control.poses, self.control.placement.shift
        rotary = [a + b for a, b in zip(words, shift)] if shift else words
        _, _, straight = poses.linear_map([0.0] * len(rotary))
        if not (abs(straight[0]) < ROUNDING and abs(straight[1]) < ROUNDING and straight[2] > 0.0):
            return None
        carried = poses.carried(rotary)
        head = [a - b for a, b in zip(rotary, carried)]
        turned = self._of_head(head)
        if turned is None:
            return None
        if any(head):
            self.control.findings.assumed(TURNED_HEAD)
        return affine.of_array(poses.turn_of_part(carried) @ turned)

    def turning_to(self, plane: Matrix) -> list[float] | None:
        """Rotary words (rotary) [rad] at which a table turns the part so that a plane which is not tilted lies along X
        and Y; None where no axis does. The whole turns are those that lead there the shortest way."""
        angle, present = math.atan2(plane[1][0], plane[0][0]), self.control.words[3:]
        poses, machine = self.control.poses, self.control.poses.machine
        assert machine is not None
        for column, joint in enumerate(poses.rotary):
            for turned in (angle, -angle):
                there = near(turned, present[column], *map(float, machine.travel[joint]))
                words = [0.0 if there is None or k != column else there for k in range(len(poses.rotary))]
                made = self.plane(words)
                if there is not None and made is not None and np.allclose(made, plane, atol=ROUNDING):
                    return words
        return None

    def _of_head(self, head: list[float]) -> Floats | None:
        """Rotation (3, 3) of a tool along z by positions of the axes of the head [rad]."""
        tilted = [column for column, angle in enumerate(head) if abs(angle) > ROUNDING]
        if not tilted:
            return np.eye(3)
        if len(tilted) > 1:
            return None
        _, _, axis = self.control.poses.linear_map(head)
        quarter = [math.copysign(0.5, angle) if angle else 0.0 for angle in head]
        _, _, beside = self.control.poses.linear_map(quarter)
        about = np.cross((0.0, 0.0, 1.0), beside)
        angle = abs(head[tilted[0]])
        if abs(float(np.linalg.norm(about)) - math.sin(0.5)) > ROUNDING:
            return None
        return rotation_about(about / np.linalg.norm(about), angle) if _along(about, axis, angle) else None


def _along(about: Floats, axis: Floats, angle: float) -> bool:
    """Whether a turn of z about a direction (3,) by an angle [rad] leads to an axis (3,)."""
    unit = about / np.linalg.norm(about)
    return bool(np.allclose(rotation_about(unit, angle)[:, 2], axis, atol=ROUNDING))


def rotation_about(unit: Floats, angle: float) -> Floats:
    """Rotation (3, 3) about a unit vector (3,) by an angle [rad]: Rodrigues' formula."""
    x, y, z = unit
    cross = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
    made: Floats = np.eye(3) + math.sin(angle) * cross + (1.0 - math.cos(angle)) * (cross @ cross)
    return made


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
