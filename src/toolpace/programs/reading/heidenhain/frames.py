"""The frame of a program: shift, mirror, rotation, scale, tilted plane."""

from __future__ import annotations

import math
from collections.abc import Mapping

from toolpace.programs.reading.control.control import Control
from toolpace.programs.reading.coordinates import affine
from toolpace.programs.reading.coordinates.affine import Matrix

IN_TILTED = "what is shifted, mirrored, turned or scaled in a tilted plane adds to what was before the plane"

IN_ITS_PLACE = "a shift, mirror, rotation or scale that is programmed anew keeps its place in that order"
IN_ORDER = "shift, mirror, rotation and scales each act in the frame of those that were programmed before"


SCALES = ("scale", "scale of axes")
"""Kinds of cycles 11 and 26."""


class Level:
    """Transformations in the order in which they were first programmed: each acts in the frame of those before."""

    def __init__(self) -> None:
        self.steps: dict[str, Matrix] = {}
        self.shifts = [0.0, 0.0, 0.0]
        self.angle = 0.0
        self.replaced = False
        """Whether one was programmed anew while others that came behind it were in force."""

    def put(self, kind: str, matrix: Matrix) -> None:
        """Replace the transformation of a kind; one that does nothing gives up its place in the order."""
        if matrix == affine.IDENTITY:
            self.steps.pop(kind, None)
            return
        self.replaced |= kind in self.steps and self.steps[kind] != matrix and next(reversed(self.steps)) != kind
        self.steps[kind] = matrix

    def uneven(self, first: int, second: int) -> bool:
        """Whether scales differ along two of the axes 0, 1 and 2."""
        scales = [self.steps[kind] for kind in SCALES if kind in self.steps]
        return any(scale[first][first] != scale[second][second] for scale in scales)

    def matrix(self) -> Matrix:
        """All of them."""
        made = affine.IDENTITY
        for step in self.steps.values():
            made = affine.product(made, step)
        return made


class Frames:
    """The frame of a program: a level before the tilted plane, the plane, and a level in it."""

    def __init__(self, control: Control) -> None:
        self.control = control
        self.before, self.within = Level(), Level()
        self.plane: Matrix | None = None
        self.rotary = [0.0] * len(control.coordinates.turn)
        self.mirrored: frozenset[int] = frozenset()
        """Columns of the words of rotary axes that count the other way."""

    def hindrance(self, *, by_axes: bool) -> tuple[str, str] | None:
        """What is in force over which a plane is not laid here, and what to do; None where nothing is.

        by_axes: the plane is one of axis angles or of cycle 19. In the workpiece coordinate system, before a plane,
        there are shifts and mirrors; mirrors do not turn planes by axis angles and of cycle 19 (TNC 620
        Conversational, "Workpiece coordinate system W-CS"). Where a rotation that was programmed there acts, and what
        stood in the plane before, no manual says.
        """
        steps = self.before.steps
        if self.within.steps:
            word = "PLANE over a shift, mirror, rotation or scale in the plane before"
            return word, "reset them before the next PLANE"
        if "rotation" in steps or self.before.uneven(0, 1) or self.before.uneven(0, 2):
            return "PLANE over a rotation or scale of axes", "program them behind PLANE, and reset them before the next"
        if self.mirrored or ("mirror" in steps and (by_axes or steps["mirror"][2][2] < 0.0)):
            return "PLANE over a mirror", "program the mirror behind PLANE, or let the CAM system mirror the path"
        return None

    @property
    def level(self) -> Level:
        """Where a transformation that is programmed now belongs."""
        if self.plane is None:
            return self.before
        self.control.findings.assumed(IN_TILTED)
        return self.within

    def matrix(self) -> Matrix:
        """The whole frame."""
        plane = affine.IDENTITY if self.plane is None else self.plane
        return affine.product(affine.product(self.before.matrix(), plane), self.within.matrix())

    def normal(self) -> list[float]:
        """The direction (3,) on the part that the tool has when it stands upright on the plane."""
        plane = affine.IDENTITY if self.plane is None else self.plane
        found = affine.direct(affine.product(self.before.matrix(), plane), (0.0, 0.0, 1.0))
        length = math.hypot(*found)
        return [value / length for value in found]

    def apply(self) -> None:
        """Hand it to the control."""
        if len(self.before.steps) > 1 or len(self.within.steps) > 1:
            self.control.findings.assumed(IN_ORDER)
        if self.before.replaced or self.within.replaced:
            self.control.findings.assumed(IN_ITS_PLACE)
        matrix = self.matrix()
        matrix = affine.IDENTITY if matrix == affine.IDENTITY else matrix
        self.control.set_frame(matrix, tilted=self.plane is not None)

    def shift(self, by: Mapping[str, tuple[float, bool]]) -> None:
        """Shift axes by letter: value [m, rad], and whether it adds to the shift before."""
        level = self.level if any(letter in "XYZ" for letter in by) else self.before
        for letter, (value, adds) in by.items():
            slot = self.control.slot(letter)
            if slot in self.mirrored and value:
                cure = "shift it before, and end the shift after the mirror"
                self.control.refuse("a shift of a mirrored rotary axis", cure)
            elif slot < 3:
                level.shifts[slot] = value + (level.shifts[slot] if adds else 0.0)
            else:
                self.rotary[slot - 3] = value + (self.rotary[slot - 3] if adds else 0.0)
        level.put("shift", affine.shift(level.shifts))
        self.apply()
        self.control.set_rotary_shift(tuple(self.rotary))

    def reset_shift(self) -> None:
        """No shift of any axis; refused in a plane over one before it, of which no manual says whether it ends."""
        if self.plane is not None and "shift" in self.before.steps:
            cure = "write PLANE RESET before, or CYCL DEF 7 with zeros in the plane"
            self.control.refuse("TRANS DATUM RESET in a plane over a shift", cure)
        for level in (self.before, self.within):
            level.shifts = [0.0, 0.0, 0.0]
            level.put("shift", affine.IDENTITY)
        self.rotary = [0.0] * len(self.rotary)
        self.apply()
        self.control.set_rotary_shift(tuple(self.rotary))

    def mirror(self, letters: str) -> None:
        """Mirror the axes of these letters, and no others; of rotary axes the words count the other way."""
        rotary = frozenset(self.control.slot(letter) for letter in letters if letter not in "XYZ")
        if rotary and (self.plane is not None or any(self.rotary[slot - 3] for slot in rotary)):
            self.control.refuse(
                "a mirror of a rotary axis in a tilted plane, or over its shift",
                "mirror it without both, or let the CAM system mirror the path",
            )
            return
        self.mirrored = rotary
        self.level.put("mirror", affine.scaling([-1.0 if letter in letters else 1.0 for letter in "XYZ"]))
        self.apply()

    def rotate(self, axis: int, angle: float, adds: bool) -> None:
        """Turn about an axis 0, 1 or 2 [rad]."""
        level = self.level
        level.angle = angle + (level.angle if adds else 0.0)
        level.put("rotation", affine.rotation(axis, level.angle))
        self.apply()

    def scale(self, by: list[float], centre: list[float] | None = None) -> None:
        """Scale along the axes (3,), about a centre (3,) [m] or the datum."""
        made = affine.scaling(by)
        if centre is not None:
            back = affine.shift([-value for value in centre])
            made = affine.product(affine.product(affine.shift(centre), made), back)
        self.level.put("scale" if centre is None else "scale of axes", made)
        self.apply()

    def scaled(self) -> list[int]:
        """Slots of X, Y, Z that cycle 26 scales where it would act now."""
        scale = (self.before if self.plane is None else self.within).steps.get("scale of axes", affine.IDENTITY)
        return [slot for slot in range(3) if scale[slot][slot] != 1.0]

    def tilt(self, plane: Matrix | None) -> None:
        """Tilt to a plane, a rotation in the frame of the datum; None: not at all."""
        if plane is None and self.within.steps:
            self.control.findings.assumed("what was shifted in the tilted plane ends with it")
        self.within = Level() if plane is None else self.within
        self.plane = plane
        self.apply()

    def new_preset(self) -> None:
        """Drop what was programmed about the preset before; the tilted plane stays."""
        if self.before.steps or self.within.steps or any(self.rotary) or self.mirrored:
            self.before, self.within = Level(), Level()
            self.rotary, self.mirrored = [0.0] * len(self.rotary), frozenset()
            self.apply()
            self.control.set_rotary_shift(tuple(self.rotary))


def spatial(a: float, b: float, c: float) -> Matrix:
    """Spatial angles [rad] about the fixed axes X, then Y, then Z."""
    return affine.turns((2, c), (1, b), (0, a))


def euler(precession: float, nutation: float, rotation: float) -> Matrix:
    """Euler angles [rad] about z, the new x, the new z."""
    return affine.turns((2, precession), (0, nutation), (2, rotation))
