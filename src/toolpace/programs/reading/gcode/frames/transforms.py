"""Programmable mirrors, scales and rotations.

"Processing proceeds from program mirror image to scaling and coordinate system rotation in the order stated. The
commands should be specified in this order, and, for cancelation, in the reverse order" (Fanuc B-63944EN-2, chapter 6,
"Programmable mirror image"; Haas 96-8000, "Rotation with scaling", says the same of the latter two). What is written in
another order is refused.
"""

from __future__ import annotations

from toolpace.common.units import DEGREE
from toolpace.programs.reading.arcs import PLANE_ACROSS, ROUNDING
from toolpace.programs.reading.control.control import Control
from toolpace.programs.reading.controllers.controller import Controller
from toolpace.programs.reading.coordinates import affine
from toolpace.programs.reading.coordinates.affine import Matrix
from toolpace.programs.reading.expressions import BlockError
from toolpace.programs.reading.gcode.modal import Modal
from toolpace.programs.reading.gcode.program.words import Handler, Numbers, RefusedError


class Transforms:
    """What carries out G51.1, G50.1, G51, G50, two-dimensional G68, and three-dimensional about the tool."""

    def __init__(self, control: Control, state: Modal, by: Controller) -> None:
        self.control, self.state = control, state
        self.factor_of_whole: float = by.option("scale_of_whole", 1.0)
        """What a whole P of scaling counts (0.001 where P1000 is life size)."""
        self.by_axis = by.option("scales_by_axis", False)
        """Whether I, J, K scale each axis."""
        self.adds = by.option("rotation_adds", False)
        """Whether R of G68 under G91 is added to the turn in force."""
        self.absolute_centre = by.option("rotation_centre_is_absolute", False)
        """Whether the centres of turns and scales are absolute under G91 too; else they are refused there."""
        self.mirrors: dict[int, float] = {}
        """Places of mirrors [m] by the slot of their axis."""
        self.scaled: Matrix | None = None
        self.angle = 0.0
        """Of the turn in force [rad]."""
        self.turned: Matrix | None = None
        self.about_tool = False
        """Whether that is a three-dimensional turn."""

    def handlers(self, changed: Handler) -> dict[str, Handler]:
        """What carries out each meaning; `changed` is called behind it."""

        def then(handler: Handler) -> Handler:
            def carried_out(numbers: Numbers, word: str) -> None:
                handler(numbers, word)
                changed(numbers, word)

            return carried_out

        return {
            "scale": then(self.scale),
            "scale off": then(self.scale_off),
            "mirror": then(self.mirror),
            "mirror off": then(self.mirror_off),
        }

    @property
    def any(self) -> bool:
        """Whether one is in force."""
        return bool(self.mirrors) or self.scaled is not None or self.turned is not None

    @property
    def matrix(self) -> Matrix:
        """From the program's coordinates to those in which the mirrors stand."""
        made = affine.IDENTITY
        for part in (self._mirror(), self.turned, self.scaled):
            if part is not None:
                made = part if made is affine.IDENTITY else affine.product(made, part)
        return made

    def _mirror(self) -> Matrix | None:
        if not self.mirrors:
            return None
        signs = [-1.0 if slot in self.mirrors else 1.0 for slot in range(3)]
        back = affine.shift([2.0 * self.mirrors.get(slot, 0.0) for slot in range(3)])
        return affine.product(back, affine.scaling(signs))

    # Turns

    def turn(self, numbers: Numbers, word: str) -> None:
        """G68: turn the plane about a point, that where the machine is unless X, Y tell another, by R [deg].

        In scales the centre is scaled, the angle is not, and "scaling is applied first and then the coordinates are
        rotated" (B-63944EN-2, "Scaling and coordinate system rotation"). In a mirror the turn goes the other way.
        """
        if self.about_tool:
            raise RefusedError(f"{word} in a three-dimensional turn", "end that turn before it: write G69")
        normal = PLANE_ACROSS[self.state.plane]
        angle = numbers.pop("R") * DEGREE
        about = self._centre(numbers, word, self.scaled)
        about[normal] = 0.0
        only_linear(numbers, word)
        if self.scaled is not None and any(self.scaled[slot][slot] < 0.0 for slot in range(3)):
            raise RefusedError(f"{word} in scales below zero (G51)", "mirror with G51.1, or end the scales before it")
        if self.mirrors and any(abs(about[slot] - place) > ROUNDING for slot, place in self.mirrors.items()):
            self.control.findings.assumed(f"the centre of {word} in a mirror is mirrored too")
        if not self.state.absolute and self.turned is not None:
            self.control.findings.assumed(
                f"R of {word} under G91 {'is added to' if self.adds else 'takes the place of'} the turn in force "
                "(rotation_adds in the controller's file: parameter 5400#0 of Fanuc, Setting 73 of Haas)"
            )
            angle += self.angle if self.adds else 0.0
        self.angle = angle
        if self.scaled is not None:
            about = list(affine.apply(self.scaled, about))
        back = affine.shift([-value for value in about])
        self.turned = affine.product(affine.shift(about), affine.product(affine.rotation(normal, angle), back))

    def turn_about_tool(self, numbers: Numbers, word: str) -> None:
        """Three-dimensional G68 X Y Z I J K R about the direction of a tool that stands upright.

        X, Y, Z are the centre, and the origin of what follows (A-63537E, "Equation for three-dimensional coordinate
        conversion": the centre is added to what is turned). About another direction the length of the tool would be
        turned too, and where its tip then is depends on what the length is measured from.
        """
        i, j, k = (numbers.pop(letter, 0.0) for letter in "IJK")
        if abs(i) > ROUNDING or abs(j) > ROUNDING or abs(k) < ROUNDING:
            numbers.clear()
            raise RefusedError(
                f"{word} about a vector that is not the tool's (I, J)",
                "where the tip is then depends on what the length of the tool counts from: write G68.2 and G53.1",
            )
        if self.any:
            raise RefusedError(f"{word} with I, J, K in turned, scaled or mirrored coordinates", "end those before it")
        angle = numbers.pop("R") * DEGREE
        at = self._centre(numbers, word, None)
        only_linear(numbers, word)
        self.angle = angle if k > 0.0 else -angle
        self.about_tool = True
        self.turned = affine.product(affine.shift(at), affine.rotation(2, self.angle))

    def turn_off(self) -> None:
        """G69."""
        self.turned, self.angle, self.about_tool = None, 0.0, False

    def _centre(self, numbers: Numbers, word: str, inside: Matrix | None) -> list[float]:
        """A point of X, Y, Z, in coordinates inside others; of what is not named, the place where the machine is."""
        if not self.state.absolute and not self.absolute_centre and any(letter in numbers for letter in "XYZ"):
            raise RefusedError(f"{word} with its centre under G91", "write G90 before it")
        point = self.control.words[:3]
        for part in (self.scaled, self.turned):
            if part is not None:
                point = list(affine.apply(part, point))
        if inside is not None:
            point = list(affine.apply(affine.inverse(inside), point))
        for slot, letter in enumerate("XYZ"):
            if letter in numbers:
                point[slot] = numbers.pop(letter) * self.state.unit
        return point

    # Scales

    def scale(self, numbers: Numbers, word: str) -> None:
        """G51: by P, or by I, J, K along the axes, about X, Y, Z."""
        self._need_inside(word, "turned coordinates (G68)", self.turned is not None)
        common = numbers.pop("P", None)
        factors = [numbers.pop(letter, None) for letter in "IJK"]
        if common is None and not any(factors):
            raise BlockError(f"{word} needs its factor as P, or I, J and K: write it like {word} X0 Y0 P0.5")
        if common is None and not self.by_axis:
            raise RefusedError(f"{word} with I, J, K", "one factor P is read here: scale the axes in the CAM system")
        if common is None and None in factors:
            self.control.findings.assumed(f"axes of which {word} names no factor (I, J, K) are not scaled")
        chosen = [
            self._factor("P", common, word) if factor is None else self._factor(letter, factor, word)
            for letter, factor in zip("IJK", factors)
        ]
        if not all(chosen):
            raise BlockError(f"{word} by zero leaves nothing: correct the factor")
        about = self._centre(numbers, word, None)
        only_linear(numbers, word)
        back = affine.shift([-value for value in about])
        self.scaled = affine.product(affine.shift(about), affine.product(affine.scaling(chosen), back))

    def _factor(self, letter: str, factor: float | None, word: str) -> float:
        if factor is None:
            return 1.0
        if self.factor_of_whole != 1.0 and factor and letter not in self.state.whole | self.state.reckoned:
            raise RefusedError(f"{word} {letter} with a point", "it counts thousandths: write 1000 for life size")
        return factor * self.factor_of_whole

    def scale_off(self, numbers: Numbers, word: str) -> None:
        """G50; with S it limits the spindle of a lathe."""
        if "S" in numbers:
            numbers.clear()
            raise RefusedError(f"{word} S", "it limits the spindle of lathes, and turning is not read: leave it out")
        self._need_inside(word, "turned coordinates (G68)", self.scaled is not None and self.turned is not None)
        self.scaled = None

    # Mirrors

    def mirror(self, numbers: Numbers, word: str) -> None:
        """G51.1: the named axes turn round at the positions named."""
        self._need_inside(word, "turned coordinates (G68)", self.turned is not None)
        self._need_inside(word, "scaled coordinates (G51)", self.scaled is not None)
        if not self.state.absolute:
            raise RefusedError(f"{word} under G91", "its place may count from the tool: write G90 before it")
        named = {slot: numbers.pop(letter) * self.state.unit for slot, letter in enumerate("XYZ") if letter in numbers}
        only_linear(numbers, word)
        if word == "G101" and any(named.values()):
            raise RefusedError(f"{word} about another place than zero", "write it like G101 X0")
        self.mirrors = self.mirrors | named

    def mirror_off(self, numbers: Numbers, word: str) -> None:
        """G50.1: of the axes that are named; without one, of all."""
        named = [slot for slot, letter in enumerate("XYZ") if numbers.pop(letter, None) is not None]
        others = [letter for letter in "ABCUVW" if numbers.pop(letter, None) is not None]
        ends = [slot for slot in self.mirrors if slot in named or not (named or others)]
        if ends:
            self._need_inside(word, "turned coordinates (G68)", self.turned is not None)
            self._need_inside(word, "scaled coordinates (G51)", self.scaled is not None)
        self.mirrors = {slot: place for slot, place in self.mirrors.items() if slot not in ends}

    @staticmethod
    def _need_inside(word: str, what: str, fault: bool) -> None:
        """The order of the manuals: mirror, scale, turn, and back."""
        if fault:
            raise RefusedError(
                f"{word} in {what}", "write G51.1, G51 and G68 in this order, and G69, G50 and G50.1 to end them"
            )


def only_linear(numbers: Numbers, word: str) -> None:
    """A rotary word that is left in the block of a turn, a scale or a mirror is none of a motion."""
    for letter in "ABCUVW":
        if letter in numbers:
            numbers.clear()
            raise RefusedError(
                f"{word} with {letter}", "it acts on X, Y and Z here: let the CAM system write the other axes so"
            )
