"""The start and end of a compensation."""

from __future__ import annotations

import math
from typing import NoReturn

from toolpace.programs.reading.compensation.corners import TANGENT, Followed
from toolpace.programs.reading.compensation.elements import Line, is_behind, turning, turning_away
from toolpace.programs.reading.compensation.following import ACROSS_ALONE, Follower
from toolpace.programs.reading.compensation.rules import AROUND, TOUCHING, Rules
from toolpace.programs.reading.compensation.stage import Leaving
from toolpace.programs.reading.control.control import Control
from toolpace.programs.reading.control.moves import Rate
from toolpace.programs.reading.curves.arcs import Arc

BESIDE = (
    "the tool's centre goes {:.6g} mm beside the contour, the radius on the set-up sheet: where the program is the "
    "centre's path and the control holds wear alone, give --compensation program"
)

STAYS = "behind the end of a compensation the tool's centre stays beside the contour until a block moves in its plane"

SCALE = 1e-9
"""By what a scale may differ from 1."""


def follow(control: Control, side: int, radius: float, plane: int, rules: Rules) -> None:
    """Follow the contour from now on. Raises ProgramError where it is not read.

    side: 1 left of it, -1 right. radius: of the tool [m]. plane: 0 XY, 1 ZX, 2 YZ.
    """

    def fail(message: str) -> NoReturn:
        control.source.fail(message, control.line)

    if not len(control.moves):
        fail("compensation begins before the program has gone to a place: position with G0 before it")
    if control.placement.tip_mode and not control.coordinates.tilted:
        fail("cutter compensation in tool-centre-point mode is not read: let the CAM system compensate")
    if is_scaled(control):
        fail("cutter compensation in scaled coordinates is not read: let the CAM system apply the scale")
    control.findings.assumed(BESIDE.format(radius * 1e3))
    control.stage = Follower(control, side, radius, plane, rules)


def is_scaled(control: Control) -> bool:
    """Whether a length of the program is another one on the part, where the tool's radius is what it is."""
    matrix = control.placement.matrix
    return any(abs(math.hypot(*(row[k] for row in matrix)) - 1.0) > SCALE for k in range(3))


def leave(follower: Follower) -> None:
    """The word that ends the compensation. Raises ProgramError."""
    if follower.last is None and follower.entering is not None:
        follower.fail("the compensation ends before it has followed a contour: take its words out")
    follower.pause()
    follower.control.stage = None if follower.last is None else Departing(follower)


def leave_here(follower: Follower) -> None:
    """End the compensation across the contour's end; the program goes on from where the centre is.

    Raises ProgramError.
    """
    leave(follower)
    follower.control.stage, follower.control.words = None, follower.control.reached()


class Departing(Leaving):
    """Leaves a contour: across its end, or round the corner to the way that leads away."""

    def __init__(self, follower: Follower) -> None:
        super().__init__(follower)
        self.follower, self.moves = follower, len(follower.control.moves)
        self.is_new = True
        """Whether the block of the word that ends it goes on."""

    def behind_block(self, moved: bool) -> None:
        """A block has ended: where it is that of the word, and moved nothing, the tool may be shifted back."""
        is_new, self.is_new = self.is_new, False
        if not (is_new and self.follower.rules.shifts):
            return
        if moved:
            self.follower.fail(f"compensation ends beside a motion {ACROSS_ALONE}")
        self.control.stage = None
        self.control.lay(self.control.words, *self.follower.speed)

    def move(self, start: list[float], end: list[float], arc: Arc | None, rate: Rate, kind: float) -> None:
        """The first straight motion in the plane leads away. Raises ProgramError."""
        follower, last = self.follower, self.follower.last
        path = follower.element(start, end, arc)
        if path is None:
            self.control.findings.assumed(STAYS)
        elif isinstance(path, Line) and last is not None:
            self._lead_away(last, path, start, end, rate, kind)
        super().move(start, end, arc, rate, kind)

    def _lead_away(
        self, last: Followed, path: Line, start: list[float], end: list[float], rate: Rate, kind: float
    ) -> None:
        """To where the way away begins, where that is not across the contour's end."""
        follower, corner, side = self.follower, path.start, self.follower.side
        words, rules = follower.at_corner(start, end), follower.rules
        turned = -side * turning(last.element.ends, path.begins)
        if rules.ends == TOUCHING and is_behind(path.end, corner, last.element.ends, side):
            self._need_no_motion()
            along = follower.touching(path.end - corner, -1)
            line = Line(corner + follower.radius * 1j * side * along, path.end)
            turned = turning_away(last.element.ends, along, side)
            follower.go_round(last, Line(corner, corner + along), line, turned, start, words, rate, kind)
        elif rules.ends == AROUND and turned > TANGENT:
            self._need_no_motion()
            follower.round_in_lines(last, path, path, start, words, rate, kind)

    def _need_no_motion(self) -> None:
        if len(self.control.moves) != self.moves:
            self.stage.fail(
                "motions stand between the end of the compensation and the way that leads away, which goes round the "
                "contour's end: write that way first"
            )
