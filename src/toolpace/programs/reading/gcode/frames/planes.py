"""Tilted planes, and turns of the tool to them."""

from __future__ import annotations

import math
from collections.abc import Sequence

from toolpace.common.units import DEGREE
from toolpace.programs.reading.arcs import ROUNDING
from toolpace.programs.reading.control.control import Control
from toolpace.programs.reading.control.machine_moves import plane_axis, rotary_for, turn_about, turn_to_plane
from toolpace.programs.reading.controllers.controller import Controller
from toolpace.programs.reading.coordinates import affine
from toolpace.programs.reading.coordinates.affine import Matrix, Vector
from toolpace.programs.reading.expressions import BlockError
from toolpace.programs.reading.gcode.frames.frames import Frames
from toolpace.programs.reading.gcode.modal import Modal
from toolpace.programs.reading.gcode.program.variables import Variables
from toolpace.programs.reading.gcode.program.words import Handler, Numbers, RefusedError

STEPS = {2.0: (0.0, 1.0, 2.0, 3.0), 3.0: (1.0, 2.0)}
"""Q of the blocks that tell a plane together, by P: three points, of which Q0 may be left out; two vectors."""
MEANINGS = ("tilt plane", "tilt plane upon plane")
SHORT = 1e-9
"""Least length of a direction, and of the sine of an angle between two of them."""
SQUARE = 1e-4
"""Most of the cosine of two axes that are meant to be square: what numbers of four places leave."""


class Planes:
    """Carries out G68.2, G68.3, G68.4, G53.1, G53.6, Haas G254 and G268, and MillPlus' G7."""

    def __init__(self, control: Control, state: Modal, frames: Frames, variables: Variables, by: Controller) -> None:
        self.control, self.state, self.frames, self.variables = control, state, frames, variables
        self.roll: str = by.option("roll_pitch_yaw", "")
        """About which axes P1 turns: those that stand ("fixed"), those of the plane ("moving"); "": not known."""
        self.blocks: dict[float, Numbers] = {}
        """What the blocks of a plane that is not whole have told, by their Q: X, Y, Z, R, I, J, K."""
        self.kind = 0.0
        """P of that plane."""

    def handlers(self) -> dict[str, Handler]:
        """What carries out each meaning."""
        return {
            "tilt plane": self.tilt_plane,
            "tilt plane upon plane": self.tilt_upon_plane,
            "plane of tool": self.plane_of_tool,
            "tilt plane by order": self.tilt_plane_by_order,
            "carried frame": self.carried_frame,
            "tilt by axes": self.tilt_by_axes,
            "turn to plane": self.turn_to_plane,
            "turn to plane about tip": self.turn_about_tip,
        }

    def need_whole(self) -> None:
        """Raise BlockError where a plane has been begun, and its other blocks do not follow."""
        if self.blocks:
            missing = [f"Q{q:g}" for q in STEPS[self.kind] if q and q not in self.blocks]
            raise BlockError(
                f"the plane of G68.2 P{self.kind:g} is not whole here: write its blocks one behind the other, "
                f"{' and '.join(missing)} too"
            )

    # Planes

    def tilt_plane(self, numbers: Numbers, word: str) -> None:
        """G68.2: a plane in the coordinates of the work offset."""
        plane = self._plane(numbers, word)
        if plane is not None:
            self.frames.tilt(plane, word)

    def tilt_upon_plane(self, numbers: Numbers, word: str) -> None:
        """G68.4: a plane in the coordinates of the one in force."""
        present = self.frames.plane
        if present is None:
            numbers.clear()
            raise RefusedError(f"{word} without a plane in force", "it lays one upon another: write G68.2 before it")
        plane = self._plane(numbers, word)
        if plane is not None:
            self.frames.tilt(affine.product(present, plane), word)

    def _plane(self, numbers: Numbers, word: str) -> Matrix | None:
        """What a block tells; None where further blocks have to."""
        self._need_machine(word)
        kind = numbers.pop("P", 0.0)
        if kind in STEPS:
            return self._of_blocks(kind, numbers, word)
        self.need_whole()
        if kind == 4.0:
            numbers.clear()
            raise RefusedError(f"{word} P4", "the signs of its angles are not sure: write P0 with I, J, K, or P2, P3")
        if kind not in (0.0, 1.0):
            raise BlockError(f"{word} P{kind:g} is no way to tell a plane: write P0 (or none) to P4")
        if "R" in numbers or ("Q" in numbers and kind == 0.0):
            numbers.clear()
            raise RefusedError(f"{word} with Q or R", f"write its plane as {word} X Y Z I J K")
        at = affine.shift(self._place(numbers))
        angles = [numbers.pop(letter, 0.0) * DEGREE for letter in "IJK"]
        if kind == 0.0:
            turned = affine.turns((2, angles[0]), (0, angles[1]), (2, angles[2]))
        else:
            turned = self._rolled(angles, numbers.pop("Q", None), word)
        return affine.product(at, turned)

    def _rolled(self, angles: list[float], order: float | None, word: str) -> Matrix:
        """P1: turns about X, Y, Z by I, J, K, in the order of the digits of Q."""
        several = sum(angle != 0.0 for angle in angles) > 1
        if several and not self.roll:
            raise RefusedError(
                f"{word} P1 with several angles",
                "machines differ in whether the axes turn with the plane: write Euler's angles (without P), or set "
                'roll_pitch_yaw = "fixed" or "moving" in the controller\'s file',
            )
        if several and order is None:
            raise BlockError(f"{word} P1 needs the order of its turns as Q: write it like Q123")
        digits = _order(order, word)
        if several:
            stands = "stand" if self.roll == "fixed" else "turn with the plane"
            self.control.findings.assumed(
                f"the axes of {word} P1 {stands}, as roll_pitch_yaw in the controller's file says"
            )
        return _turned(angles, digits, fixed=self.roll != "moving")

    def _of_blocks(self, kind: float, numbers: Numbers, word: str) -> Matrix | None:
        """P2 and P3: a block for each point or vector, told apart by Q."""
        if self.blocks and kind != self.kind:
            self.need_whole()
        step = numbers.pop("Q", math.nan)
        if step not in STEPS[kind] or step in self.blocks:
            raise BlockError(f"{word} P{kind:g} takes Q{' and Q'.join(f'{q:g}' for q in STEPS[kind])}, each once")
        self.kind = kind
        self.blocks[step] = {letter: numbers.pop(letter) for letter in [*"XYZRIJK"] if letter in numbers}
        wanted = [q for q in STEPS[kind] if q]
        if any(q not in self.blocks for q in wanted):
            return None
        blocks, self.blocks = self.blocks, {}
        if kind == 3.0:
            return self._of_vectors(blocks, word)
        made = plane_of_points([self._place(blocks[q]) for q in wanted], word)
        beside = blocks.get(0.0, {})
        turn, shift = beside.pop("R", 0.0), self._place(beside)
        if any(shift) or turn:
            self.control.findings.assumed(
                f"X, Y, Z of {word} P2 Q0 are in the coordinates of the plane, from its first point, and R turns it "
                "about its Z"
            )
        return affine.product(affine.product(made, affine.shift(shift)), affine.rotation(2, turn * DEGREE))

    def _of_vectors(self, blocks: dict[float, Numbers], word: str) -> Matrix:
        """P3: Q1 tells the origin and the direction of X, Q2 that of Z."""
        if any("R" in words for words in blocks.values()):
            raise RefusedError(f"{word} P3 with R", "write the direction of X so that no turn is needed")
        x, z = ([blocks[q].get(letter, 0.0) for letter in "IJK"] for q in STEPS[3.0])
        return plane_of_vectors(self._place(blocks[1.0]), x, z, word)

    def plane_of_tool(self, numbers: Numbers, word: str) -> None:
        """G68.3 X Y Z R: the plane on which the tool stands upright (A-79976E)."""
        self._need_machine(word)
        self.need_whole()
        control = self.control
        if any(letter not in numbers for letter in "XYZ"):
            numbers.clear()
            raise RefusedError(f"{word} without X, Y and Z", "name the origin of the plane")
        rotary = control.placement.place(control.words)[3:]
        if any(abs(turned) > ROUNDING for turned in control.poses.carried(rotary)):
            numbers.clear()
            raise RefusedError(
                f"{word} while a rotary axis of the table is not at zero",
                "what its X is then depends on the machine: write G68.2 X Y Z I J K",
            )
        at = self._place(numbers)
        made = plane_of_tool(at, control.poses.axis(rotary), word)
        control.findings.assumed(f"X of the plane of {word} is level, as where parameter 12321 of Fanuc is Z")
        self.frames.tilt(affine.product(made, affine.rotation(2, numbers.pop("R", 0.0) * DEGREE)), word)

    def tilt_plane_by_order(self, numbers: Numbers, word: str) -> None:
        """Haas G268 X Y Z I J K Q: turns about the fixed axes X, Y, Z by I, J, K, in the order of the digits of Q."""
        self._need_machine(word)
        at = affine.shift(self._place(numbers))
        angles = [numbers.pop(letter, 0.0) * DEGREE for letter in "IJK"]
        order = numbers.pop("Q", None)
        several = sum(angle != 0.0 for angle in angles) > 1
        if order is None and several:
            raise RefusedError(f"{word} without Q", "it tells the order of the turns: write Q123 with its angles")
        digits = _order(order, word)
        if several:
            self.control.findings.assumed(f"{word} turns about the fixed axes X, Y and Z, in the order of Q")
        self.frames.tilt(affine.product(at, _turned(angles, digits, fixed=True)), word)

    def carried_frame(self, numbers: Numbers, word: str) -> None:
        """Haas G254: coordinates parallel to the machine's, about the work offset as the table has carried it."""
        self._need_machine(word)
        self.frames.tilt(self._carried(), word)

    def _carried(self) -> Matrix:
        control = self.control
        return affine.of_array(control.poses.turn_of_part(control.placement.place(control.words)[3:]))

    def tilt_by_axes(self, numbers: Numbers, word: str) -> None:
        """MillPlus G7: turns about the fixed axes X, Y, Z by A5, B5, C5; L1=1 turns the axes, B7 and C7 are told."""
        control = self.control
        angles = [numbers.pop(letter, 0.0) * DEGREE for letter in ("A5", "B5", "C5")]
        turns_axes = numbers.pop("L1", 0.0) == 1.0
        letters = [letter for letter in ("A", "B", "C") if f"{letter}7" in numbers]
        if any(angles):
            self._need_machine(word)
        self.frames.tilt(_turned(angles, "123", fixed=True) if any(angles) else None, word)
        if letters:
            wanted = rotary_for(control, plane_axis(control))
            for letter in letters:
                key = round(numbers.pop(f"{letter}7"))
                self.variables.set(key, wanted[control.slot(letter) - 3] / DEGREE)
        if turns_axes and control.poses.machine is not None:
            turn_to_plane(control)

    # Turns of the tool

    def turn_to_plane(self, numbers: Numbers, word: str) -> None:
        """G53.1: turn the rotary axes until the tool stands on the plane; the linear axes keep their places."""
        self._need_plane(numbers, word)
        turn_to_plane(self.control, first=self._first())
        self._say_alike(word)

    def turn_about_tip(self, numbers: Numbers, word: str) -> None:
        """G53.6 H R: as G53.1, while the tip keeps its place on the part, or with R a point that far above it."""
        self._need_plane(numbers, word)
        control, above = self.control, numbers.pop("R", 0.0) * self.state.unit
        length = numbers.pop("H", None)
        if length is not None:
            control.set_length(f"{length:g}")
        wanted = rotary_for(control, plane_axis(control), first=self._first())
        turn_about(control, wanted, above, rapid=self.state.motion in (None, "rapid"))
        self._say_alike(word)

    def _need_plane(self, numbers: Numbers, word: str) -> None:
        self._need_machine(word)
        self.need_whole()
        which = numbers.pop("P", 0.0)
        if which:
            raise RefusedError(
                f"{word} P{which:g}",
                "it chooses between two positions of the rotary axes: turn them near the one that is meant before, and "
                f"write {word} without P",
            )
        if self.frames.plane is None:
            numbers.clear()
            raise RefusedError(f"{word} without a tilted plane in force", "tell it before: write G68.2, or G268")

    def _say_alike(self, word: str) -> None:
        """Say where the rule leaves it open which of two positions is taken."""
        control = self.control
        if control.orientation.alike:
            names, other = control.poses.rotary_names, control.orientation.alike
            taken = control.placement.place(control.words)[3:]
            shown = [" ".join(f"{n}{math.degrees(v):.4g}" for n, v in zip(names, each)) for each in (taken, other)]
            control.findings.assumed(f"{word} turns to {shown[0]}, not to {shown[1]}, which is as near")

    def _first(self) -> tuple[int, int]:
        """The order in which the rotary axes turn as little as they can (16i operator's manual, "Angle of rotation
        axis"): of a head the first from the bed, of two of a table likewise, else that of the table."""
        poses = self.control.poses
        both = len(poses.rotary) == 2 and all(poses.carried([0.5, 0.5]))
        return (1, 0) if both else (0, 1)

    # Words

    def _place(self, numbers: Numbers) -> list[float]:
        """X, Y, Z [m], which are absolute under G91 too."""
        return [numbers.pop(letter, 0.0) * self.state.unit for letter in "XYZ"]
    def _need_machine(self, word: str) -> None:
        if self.control.poses.machine is None:
            raise BlockError(f"{word} needs the machine: give --machine NAME (machine= in Python)")


def _order(order: float | None, word: str) -> str:
    """The digits of Q; 123 where none is given."""
    digits = f"{order or 123.0:g}"
    if sorted(digits) != ["1", "2", "3"]:
        raise RefusedError(f"{word} Q{digits}", "write each of X, Y, Z once, like Q123, with their angles")
    return digits


def _turned(angles: list[float], digits: str, *, fixed: bool) -> Matrix:
    """Turns about X, Y, Z by angles (3,) [rad] one after the other, about axes that stand or those of the plane."""
    made = affine.IDENTITY
    for digit in digits:
        axis = int(digit) - 1
        turn = affine.rotation(axis, angles[axis])
        made = affine.product(turn, made) if fixed else affine.product(made, turn)
    return made


def plane_of_points(points: Sequence[Vector], word: str) -> Matrix:
    """Origin in the first of three points (3,) [m], X to the second, the third on the side of +Y. Raises BlockError."""
    first, second, third = points
    x = [b - a for a, b in zip(first, second)]
    y = [b - a for a, b in zip(first, third)]
    return _frame(first, x, affine.cross(x, y), f"the three points of {word} P2 are on one line")


def plane_of_vectors(at: Vector, x: Vector, z: Vector, word: str) -> Matrix:
    """Origin at a point (3,) [m], axes X and Z along vectors (3,). Raises BlockError, and RefusedError where these are
    not square."""
    product = math.hypot(*x) * math.hypot(*z)
    if product > SHORT and abs(sum(a * b for a, b in zip(x, z))) > SQUARE * product:
        raise RefusedError(f"{word} P3 with vectors that are not square", "write X in the plane, at 90 degrees to Z")
    return _frame(at, x, z, f"a vector of {word} P3 is zero")


def plane_of_tool(at: Vector, axis: Vector, word: str) -> Matrix:
    """Origin at a point (3,) [m], Z along the axis (3,) of a tool, X level. Raises RefusedError where it is upright."""
    level = affine.cross((0.0, 0.0, 1.0), axis)
    if math.hypot(*level) < 1e-6:
        raise RefusedError(f"{word} with the tool upright", "every X is level then: write G68.2 X Y Z I J K")
    return _frame(at, level, axis, "")


def _frame(at: Vector, x: Vector, z: Vector, fault: str) -> Matrix:
    """From an origin (3,), X in the plane across Z (3,), and Z. BlockError with the fault where there is none."""
    made = affine.of_axes(x, z)
    if made is None:
        raise BlockError(f"{fault}: correct it")
    return affine.product(affine.shift(at), made)
