"""LN: straight blocks with surface normal and tool direction."""

from __future__ import annotations

import math
from collections.abc import Sequence

from toolpace.programs.reading.control.control import Control
from toolpace.programs.reading.control.tool_axis import direction_on_part, rotary_for
from toolpace.programs.reading.heidenhain.contour.motion import Motion, Step
from toolpace.programs.reading.heidenhain.klartext.expressions import Value, evaluate
from toolpace.programs.reading.heidenhain.klartext.parameters import BlockError
from toolpace.programs.reading.heidenhain.klartext.words import PathWords
from toolpace.programs.reading.heidenhain.state import State


class SurfaceLines:
    """Compiles LN."""

    def __init__(self, control: Control, state: State, motion: Motion) -> None:
        self.control, self.state, self.motion = control, state, motion

    def line(self, words: PathWords) -> Step:
        """LN: the tip goes straight, the tool to the direction TX TY TZ; NX NY NZ is the way out of the part, and the
        direction of the tool where that is not told.

        "If no tool orientation is programmed in the LN block, the TNC maintains the tool perpendicular to the workpiece
        contour" under M128; "if you have not activated M128, the TNC ignores the direction vector T" (iTNC 530
        Conversational, "Face milling: 3-D compensation with and without tool orientation").
        """
        motion = self.motion
        axes = motion.resolved(words)
        motion.only(words, "LN", ("NX", "NY", "NZ", "TX", "TY", "TZ"))
        given = [words.others.get(name) for name in ("TX", "TY", "TZ")]
        normals = [words.others.get(name) for name in ("NX", "NY", "NZ")]
        has_tool, has_normal = (any(value is not None for value in vector) for vector in (given, normals))

        def run() -> None:
            control = self.control
            motion.compensation.take(words.side)
            if control.stage is not None and control.stage.compensates:
                raise BlockError("LN under RL or RR, compensation in space, is not read: let the CAM system compensate")
            rapid = motion.set_feed(words)
            if has_normal and self.state.oversize:
                control.findings.refused(
                    "NX NY NZ with an oversize of TOOL CALL", control.line,
                    "the control moves the tool along the normal by DL, DR and DR2: let the CAM system do that, and "
                    "call the tool without them",
                )  # fmt: skip
            if has_normal and self.state.path_is_contour:
                # "the control references the 3-D radius compensation to the entire tool radius R + DR and the corner
                # radius R2 + DR2" (TNC 640 Klartext, "Interpretation of the programmed path")
                control.findings.refused(
                    "NX NY NZ under FUNCTION PROG PATH IS CONTOUR", control.line,
                    "the control moves the tool along the normal by its radii: let the CAM system do that, and write "
                    "FUNCTION PROG PATH IS OFF",
                )  # fmt: skip
            target, named = motion.target(axes)
            normal, tool = direction_of("NX NY NZ", normals), direction_of("TX TY TZ", given)
            upright = tool if has_tool else normal
            if upright and self.state.tip_mode:
                target[3:] = rotary_for(control, direction_on_part(control, upright))
                self.state.spatial_angles = [None] * 3
            elif has_tool:
                control.findings.assumed("TX TY TZ of LN without M128 turns no axis: the control ignores it")
            rows = len(control.moves)
            motion.straight(target, named, rapid)
            if len(control.moves) > rows and normal:
                x, y, z = direction_on_part(control, normal)
                control.moves.normals[len(control.moves) - 1] = x, y, z

        return run


def direction_of(name: str, given: Sequence[Value | None]) -> list[float]:
    """Unit vector (3,) of components, where any is given; else empty. Raises BlockError where it has no length."""
    if all(value is None for value in given):
        return []
    vector = [0.0 if value is None else evaluate(value) for value in given]
    length = math.hypot(*vector)
    if not 1e-6 < length < 1e6:
        raise BlockError(f"{name} is no direction: its length is {length:g}, write the components of a unit vector")
    return [value / length for value in vector]
