"""PLANE AXIAL and cycle 19 with axis angles."""

from __future__ import annotations

import math
from collections.abc import Mapping

import numpy as np

from toolpace.common.arrays import Floats
from toolpace.programs.reading.arcs import ROUNDING
from toolpace.programs.reading.control.control import Control
from toolpace.programs.reading.coordinates import affine
from toolpace.programs.reading.coordinates.affine import Matrix
from toolpace.programs.reading.coordinates.kinematics import near
from toolpace.programs.reading.heidenhain.klartext.parameters import BlockError

HEAD = (
    "write PLANE SPATIAL or PLANE VECTOR: where two axes turn the tool, or one that is not across it, axis positions "
    "do not tell in one way how X and Y of the plane are turned"
)
TURNED_HEAD = "PLANE AXIAL: the axis of the head that is tilted turns X, Y and Z of the plane with the tool"


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
        return turn_about(about / np.linalg.norm(about), angle) if _along(about, axis, angle) else None


def _along(about: Floats, axis: Floats, angle: float) -> bool:
    """Whether a turn of z about a direction (3,) by an angle [rad] leads to an axis (3,)."""
    unit = about / np.linalg.norm(about)
    return bool(np.allclose(turn_about(unit, angle)[:, 2], axis, atol=ROUNDING))


def turn_about(unit: Floats, angle: float) -> Floats:
    """Rotation (3, 3) about a unit vector (3,) by an angle [rad]: Rodrigues' formula."""
    x, y, z = unit
    cross = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
    made: Floats = np.eye(3) + math.sin(angle) * cross + (1.0 - math.cos(angle)) * (cross @ cross)
    return made
