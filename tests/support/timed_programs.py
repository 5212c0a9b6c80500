"""Times of short programs on a machine whose linear axes are all alike."""

from __future__ import annotations

import numpy as np

from toolpace import Limits, Machine
from toolpace.controls.timing.figures import ControlFigures, figures_of
from toolpace.controls.timing.program_time import ProgramTime, time_of_moves
from toolpace.programs.reading import Source, read_commanded

MACHINE = Machine.load("xyzac-trunnion")
A, J = 2.0, 40.0
"""Acceleration and jerk of the linear axes [m/s^2, m/s^3]."""


def machine(acceleration: float = A, jerk: float = J) -> Machine:
    own = MACHINE.limits
    rotary = MACHINE.is_rotary
    return MACHINE.with_limits(
        Limits(own.velocity, np.where(rotary, 50.0, acceleration), np.where(rotary, 500.0, jerk), MACHINE.joints)
    )


def timed(body: str, figures: ControlFigures | None = None, on: Machine | None = None) -> ProgramTime:
    text = f"G21 G90 G17 G94\nG0 X0 Y0 Z0 A0 C0\n{body}M2\n"
    on = on or machine()
    moves = read_commanded(Source.from_text(text, "part.ngc"), on)
    return time_of_moves(moves, on, figures or figures_of({}, "", "lookahead"))
