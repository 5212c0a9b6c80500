"""Cutter radius compensation: R0, RL, RR."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

from toolpace.programs.reading.compensation.ends import follow, leave
from toolpace.programs.reading.compensation.following import Follower
from toolpace.programs.reading.compensation.rules import ACROSS, ARC, Rules
from toolpace.programs.reading.control.control import Control
from toolpace.programs.reading.heidenhain.klartext.expressions import Value, evaluate
from toolpace.programs.reading.heidenhain.klartext.parameters import BlockError
from toolpace.programs.reading.heidenhain.state import ARC_PLANE, State

LENGTHENED = {"R+": 1.0, "R-": -1.0}
"""What makes the way of one axis longer or shorter by the tool's radius."""
UNKNOWN = (
    "the tool's radius is not known: write it on the set-up sheet ([tools.N] radius), give --compensation program "
    "where the contour is the tool's centre, or write R0"
)
RULES = Rules(ARC, ACROSS, most_idle=2, gouge="the control stops with an error")
"""TNC 640, Klartext, "Tool radius compensation": an arc at outside corners, the ways' intersection at inside ones, and
across the contour at its ends; how many blocks across the plane it looks over is not said."""


class Compensation:
    """Begins and ends compensation as the words of blocks say."""

    def __init__(
        self, control: Control, state: State, as_programmed: bool, approach_waits: Callable[[], bool]
    ) -> None:
        """as_programmed: whether the contour is the way. approach_waits: whether APPR waits for its contour."""
        self.control, self.state = control, state
        self.as_programmed, self.approach_waits = as_programmed, approach_waits

    @property
    def follower(self) -> Follower | None:
        """What goes beside the contour now."""
        stage = self.control.stage
        return stage if isinstance(stage, Follower) else None

    def take(self, side: str) -> None:
        """R0, RL, RR, or none. Raises BlockError."""
        follower = self.follower
        if side in LENGTHENED:
            raise BlockError(f"{side} belongs to a block of one axis, like X+50 {side}: write RL or RR here")
        before, self.state.side = self.state.side, side or self.state.side
        if side in ("", "R0"):
            if side and follower is not None:
                leave(follower)
                self.state.looks_ahead = 0
        elif follower is not None:
            if before != side:
                raise BlockError(f"{side} changes the side of the tool while it compensates: write R0 before it")
        elif not self.approach_waits() and (radius := self.radius()):
            self.begin(radius)

    def radius(self) -> float:
        """How far beside the contour the centre goes [m]. Raises BlockError."""
        return 0.0 if self.state.side == "R0" else self.of_tool(self.state.side)

    def of_tool(self, side: str) -> float:
        """Radius of the tool in the spindle, with DR, for a word that compensates it [m]. Raises BlockError."""
        control = self.control
        if self.as_programmed:
            control.findings.assumed(f"{side}: the programmed contour is the way of the tool's centre")
            return 0.0
        known = control.setup.tool(control.tool)
        if known is None or known.radius is None:
            control.findings.refused(side, control.line, UNKNOWN)
            return 0.0
        found = known.radius + self.state.radius_oversize
        if found < 0.0:
            raise BlockError(f"the radius of the tool and DR come to {found * 1e3:.6g} mm: correct them")
        return found

    def begin(self, radius: float) -> None:
        """Go beside the contour from here on."""
        side = 1 if self.state.side == "RL" else -1
        rules = replace(RULES, looks_ahead=self.state.looks_ahead)
        follow(self.control, side, radius, ARC_PLANE[self.state.tool_axis], rules)

    def look_ahead(self, elements: Value | None) -> None:
        """M120 with LA: loops of the way are left out; without it, or with 0, they are not."""
        self.control.findings.ignored("M120")
        self.state.looks_ahead = 0 if elements is None else int(evaluate(elements))
        if self.follower is not None:
            self.follower.rules = replace(self.follower.rules, looks_ahead=self.state.looks_ahead)
